"""Suffixes and their targets."""

import numpy as np
import pytest

import envlights as el
from envlights.export import TARGETS, target_of
from envlights.export.scene import scene_of

RIG = el.Rig([0.1, 0.1, 0.1], el.Lights([[0, 1, 0]], [[1, 1, 1]]), error=0.0)


def test_names_and_suffixes_are_unique():
    suffixes = [suffix for target in TARGETS for suffix in target.suffixes]
    assert len({*suffixes}) == len(suffixes)
    assert len({target.name for target in TARGETS}) == len(TARGETS)
    assert all(suffix == suffix.lower() and suffix[0] == "." for suffix in suffixes)


def test_the_longest_end_decides():
    for target in TARGETS:
        for suffix in target.suffixes:
            assert target_of(f"a.b{suffix.upper()}") == target


def test_an_unknown_suffix_lists_what_can_be_written(tmp_path):
    with pytest.raises(el.EnvLightsError, match=r"must be one of \.json, \.csv"):
        RIG.lights.save(tmp_path / "scene.yaml")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("scene.blend", r"give \.py, a script"),
        ("scene.GLB", r"give \.gltf"),
        ("scene.png", "`plot.save` writes pictures"),
        ("scene.exr", "`to_map` makes a map"),
    ],
)
def test_a_suffix_that_is_nearly_right_says_what_to_write(tmp_path, name, hint):
    with pytest.raises(el.EnvLightsError, match=f"{hint}.*; the suffix must be one of"):
        RIG.save(tmp_path / name)


def test_what_is_no_rig_is_refused(tmp_path):
    with pytest.raises(el.EnvLightsError, match="only a rig or lights can be exported; got 'lamp'"):
        el.export.save("lamp", tmp_path / "scene.csv")


def test_a_map_that_the_target_cannot_hold_is_refused(tmp_path):
    with pytest.raises(el.EnvLightsError, match="accepts no environment map"):
        RIG.save(tmp_path / "scene.csv", environment=np.ones((4, 8, 3), np.float32))
    assert not list(tmp_path.iterdir())


def test_a_map_with_borders_becomes_cells_for_every_target():
    env = el.EnvMap(
        el.synthetic.hall(16).radiance, layout=el.io.Layout(registration="border-sampled")
    )
    scene = scene_of(RIG, env, target="usd")
    assert scene.environment.registration == "cell-centred"
    np.testing.assert_array_equal(scene.environment.radiance, env.cells())


@pytest.mark.parametrize("suffix", [".usda", ".xml", ".rad", ".py", ".pbrt", ".unity.json"])
def test_a_texture_that_breaks_off_leaves_no_scene(tmp_path, monkeypatch, suffix):
    """The disk may fill up while it is written; a scene never names what is missing."""

    def full(path, *_, **__):
        raise el.EnvLightsError(f"cannot write {path}: the disk is full")

    for writer in ("write_exr", "write_hdr"):
        monkeypatch.setattr(f"envlights.export.files.{writer}", full, raising=False)
    env = np.ones((16, 32, 3), np.float32)
    with pytest.raises(el.EnvLightsError, match="the disk is full"):
        RIG.save(tmp_path / f"scene{suffix}", environment=env)
    assert list(tmp_path.iterdir()) == []
