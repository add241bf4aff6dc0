"""Many maps with one command: the same brightness, each in a folder under its own name."""

import numpy as np
import pytest
from click.testing import CliRunner

import envlights as el
from envlights.cli import main

UP = [0.0, 1.0, 0.0]
LUMINANCE = [0.2126, 0.7152, 0.0722]


@pytest.fixture
def maps(tmp_path):
    paths = []
    for name, gain in (("a.hdr", 0.2), ("b.exr", 7.0), ("c.png", None)):
        env = el.EnvMap((gain or 1) * el.synthetic.plain(len(paths), 128).radiance)
        path = tmp_path / name
        env.save(path) if gain else env.to("equirectangular").save(path)
        paths.append(path)
    return paths


def convert(*arguments, code=0):
    done = CliRunner().invoke(main, ["convert", *map(str, arguments)])
    assert done.exit_code == code, done.output
    return done.output


def test_maps_of_a_folder_get_the_same_irradiance_of_a_horizontal_plane(maps, tmp_path):
    out = tmp_path / "same"
    convert("--lux", 1000, *maps, "-o", out)
    assert sorted(path.name for path in out.iterdir()) == ["a.hdr", "b.exr", "c.exr"]
    for path in out.iterdir():
        received = el.EnvMap.open(path).probe(UP) @ LUMINANCE
        assert received == pytest.approx(1000, rel=2e-3)
    ours = [el.EnvMap.open(path).calibrated(lux=1000) for path in maps]
    np.testing.assert_allclose(el.EnvMap.open(out / "b.exr").radiance, ours[1].radiance, rtol=1e-6)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["a.hdr", "b.exr", "-o", "x.exr"], "2 maps need a folder"),
        (["a.hdr", "b.exr", "c.png"], "give -o"),
        (["a.hdr", "b.exr", "-o", "."], "it is the map"),
        (["a.hdr", "sub/a.hdr", "-o", "out"], "two maps have the same name"),
    ],
)
def test_a_folder_that_cannot_hold_the_maps_is_refused(arguments, words, maps, monkeypatch):
    monkeypatch.chdir(maps[0].parent)
    assert words in convert(*arguments, code=2)
    assert not (maps[0].parent / "out").exists()
