"""Lights of a split map with the remainder around them: names in scenes, and the files there."""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

import envlights as el
from envlights.export import TARGETS
from envlights.export.links import relative_name, save_with_map
from envlights.export.targets import PANORAMA

pytestmark = pytest.mark.filterwarnings(
    "ignore:.* shows lights as points:UserWarning", "ignore:Godot 4 shows the 8 bright:UserWarning"
)

PANORAMAS = [target.suffixes[0] for target in TARGETS if target.texture == PANORAMA]
OTHERS = {
    target.suffixes[0]: target.texture for target in TARGETS if target.texture not in ("", PANORAMA)
}
WITHOUT_MAP = [target.suffixes[0] for target in TARGETS if not target.texture]


@pytest.fixture(scope="module")
def parts():
    return el.split(el.synthetic.hall(32).radiance, 2)


def names(folder):
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*.*"))


def named_maps(path):
    """Names of maps in a scene."""
    text = path.read_text(encoding="utf-8")
    return sorted(set(re.findall(r"[^\s\"'@]+\.(?:exr|hdr)", text)))


@pytest.mark.parametrize("suffix", PANORAMAS)
def test_a_scene_names_the_file_of_the_remainder(parts, suffix, tmp_path):
    written = parts.save(tmp_path / "rest.exr", tmp_path / f"sun{suffix}")
    assert names(tmp_path) == sorted(path.name for path in written) == ["rest.exr", f"sun{suffix}"]
    assert {name.removeprefix("./") for name in named_maps(written[1])} == {"rest.exr"}


@pytest.mark.parametrize("suffix", PANORAMAS)
def test_a_scene_alone_brings_the_remainder(parts, suffix, tmp_path):
    scene, texture = parts.save(tmp_path / f"sun{suffix}")
    assert names(tmp_path) == sorted([scene.name, texture.name])
    assert {name.removeprefix("./") for name in named_maps(scene)} == {texture.name}
    np.testing.assert_array_equal(el.EnvMap.open(texture).radiance, parts.remainder.radiance)


@pytest.mark.parametrize("suffix", OTHERS)
def test_a_map_of_another_form_is_written_once_and_returned(parts, suffix, tmp_path):
    map_file, scene, texture = parts.save(tmp_path / "rest.exr", tmp_path / f"sun{suffix}")
    assert texture.name == f"sun{OTHERS[suffix]}"
    assert names(tmp_path) == sorted([map_file.name, scene.name, texture.name])
    assert named_maps(scene) == [texture.name]


@pytest.mark.parametrize("suffix", WITHOUT_MAP)
def test_other_files_have_no_map_beside_them(parts, suffix, tmp_path):
    (written,) = parts.save(tmp_path / f"sun{suffix}")
    assert names(tmp_path) == [written.name]
    if suffix != ".three.json":
        assert "exr" not in written.read_text()
    else:  # three.js has the pixels in its file
        image = json.loads(written.read_text())["images"][0]["url"]
        pixels = np.reshape(image["data"], (32, 64, 4))[..., :3]
        np.testing.assert_allclose(pixels, parts.remainder.radiance, rtol=1e-6)


def test_three_gets_at_most_1024_columns():
    env = el.EnvMap(np.ones((1024, 2048, 3), np.float32))
    image = el.export.three(el.Lights([[0, 1, 0]], [[1, 1, 1]]), env)["images"][0]["url"]
    assert (image["height"], image["width"]) == (512, 1024)


def test_scenes_without_a_file_of_the_remainder_share_one(parts, tmp_path):
    written = parts.save(*(tmp_path / name for name in ("a.py", "b.usda", "c.unity.json")))
    assert [path.name for path in written] == ["a.py", "a.ambient.exr", "b.usda", "c.unity.json"]
    for path in (written[0], *written[2:]):
        assert {name.removeprefix("./") for name in named_maps(path)} == {"a.ambient.exr"}


def test_a_program_with_too_many_lights_has_a_map_of_its_own(tmp_path):
    remainder = el.split(el.synthetic.hall(32).radiance, 1).remainder
    lamps = el.Lights(np.tile([0.0, 1.0, 0.0], (9, 1)), np.ones((9, 3)))
    for folder, names_ in (("one", ("a.usda", "b.tscn")), ("other", ("b.tscn", "a.usda"))):
        (tmp_path / folder).mkdir()
        written = save_with_map(lamps, remainder, [tmp_path / folder / n for n in names_])
        assert {path.name for path in written} == {
            "a.usda",
            "a.ambient.exr",
            "b.tscn",
            "b.ambient.exr",
        }
        assert el.EnvMap.open(tmp_path / folder / "a.ambient.exr") == remainder
        assert named_maps(tmp_path / folder / "b.tscn") == ["b.ambient.exr"]
    with pytest.raises(el.EnvLightsError, match=r"cannot write .* twice"):
        save_with_map(lamps, remainder, [tmp_path / "a.usda", tmp_path / "a.tscn"])


@pytest.mark.parametrize("suffix", PANORAMAS)
def test_folders_move_together(parts, suffix, tmp_path):
    for folder in ("maps", "scenes/day"):
        (tmp_path / "here" / folder).mkdir(parents=True)
    here = tmp_path / "here"
    parts.save(here / "maps/rest.exr", here / f"scenes/day/sun{suffix}")
    shutil.move(here, tmp_path / "there")
    scene = tmp_path / f"there/scenes/day/sun{suffix}"
    (name,) = named_maps(scene)
    assert name == "../../maps/rest.exr"
    assert el.EnvMap.open(scene.parent / name) == parts.remainder
    assert names(tmp_path) == ["there/maps/rest.exr", f"there/scenes/day/sun{suffix}"]


def test_openusd_finds_the_remainder_in_another_folder(parts, tmp_path):
    usd = pytest.importorskip("pxr.Usd")
    for name in ("maps", "scenes"):
        (tmp_path / name).mkdir()
    parts.save(tmp_path / "maps/rest.exr", tmp_path / "scenes/sun.usda")
    stage = usd.Stage.Open(str(tmp_path / "scenes/sun.usda"))
    file = stage.GetPrimAtPath("/rig/ambient").GetAttribute("inputs:texture:file").Get()
    assert Path(file.resolvedPath).resolve() == (tmp_path / "maps/rest.exr").resolve()


def test_no_name_leads_out_of_a_linked_folder(parts, tmp_path):
    for folder in ("maps", "far/scenes"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "scenes").symlink_to(tmp_path / "far/scenes", target_is_directory=True)
    assert relative_name(tmp_path / "maps/rest.exr", tmp_path / "scenes/sun.py") is None
    parts.save(tmp_path / "maps/rest.exr", tmp_path / "scenes/sun.py")
    assert named_maps(tmp_path / "scenes/sun.py") == ["sun.ambient.exr"]
    assert (tmp_path / "far/scenes/sun.ambient.exr").exists()


def test_programs_read_no_border_sampled_file(tmp_path):
    """Blender would take its pixels as cells."""
    env = el.EnvMap(
        el.synthetic.hall(32).radiance, layout=el.io.Layout(registration="border-sampled")
    )
    parts = el.split(env, 1)
    parts.save(tmp_path / "rest.exr", tmp_path / "sun.py")
    assert named_maps(tmp_path / "sun.py") == ["sun.ambient.exr"]
    written = parts.save(*(tmp_path / name for name in ("rest.exr", "rest.hdr", "sky.py")))
    assert len(written) == 3
    assert named_maps(tmp_path / "sky.py") == ["rest.hdr"]


@pytest.mark.parametrize(
    ("outputs", "sentence"),
    [
        ((), "there is no path; give one"),
        (("sun.py", "sun.yaml"), r"cannot write .*sun\.yaml: the suffix must be one of"),
        (("sun.py", "sun.py"), r"cannot write .*sun\.py twice"),
        (
            ("sun.ambient.mitsuba.exr", "sun.xml"),
            r"cannot write .*mitsuba\.exr twice",
        ),
        (("rest.exr", "none/sun.py"), "the folder .*none does not exist"),
    ],
)
def test_what_cannot_be_written_is_refused_before_the_first_file(
    parts, outputs, sentence, tmp_path
):
    with pytest.raises(el.EnvLightsError, match=sentence):
        parts.save(*(tmp_path / output for output in outputs))
    assert names(tmp_path) == []
