"""Options on how a map is read: the same for one map, for many, for sequences and comparisons."""

import numpy as np
import pytest
from click.testing import CliRunner

import envlights as el
from envlights.cli import main
from envlights.environment.reading import as_envmap
from envlights.io import Layout

LAYOUT = Layout.fisheye(fov=360, mapping="equidistant", forward=(1, 0, 0))
READING = {
    "layout": LAYOUT,
    "width": 64,
    "colour": "srgb",
    "clip_level": 40.0,
    "up": (0, 0.9, 0.1),
    "lux": 900.0,
    "camera": [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],
    "frame": "colmap",
}
WORDS = [
    *("--projection", "fisheye", "--fov", "360", "--mapping", "equidistant"),
    *("--forward", "0,0,1", "--map-width", "64", "--colour", "srgb", "--clip-level", "40"),
    *("--level", "-0,-0.9,0.1", "--lux", "900"),
    *("--camera", "0,0,1,0,1,0,-1,0,0", "--frame", "colmap"),
]
#: The same directions in the frame colmap: forward is our +x, and `up` has no x.
WORDS[WORDS.index("--forward") + 1] = "-1,0,0"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("maps")
    for name, gain in (("a", 1.0), ("b", 0.5)):
        hall = el.EnvMap(gain * el.synthetic.hall(64).radiance)
        hall.to(LAYOUT, width=64).save(folder / f"{name}.exr")
    return folder


@pytest.fixture(scope="module")
def maps(folder):
    """Both maps, by the methods themselves."""
    return [
        el.EnvMap.open(folder / name, layout=LAYOUT, width=64, colour="srgb", clip_level=40.0)
        .levelled((0, 0.9, 0.1))
        .calibrated(lux=900)
        .rotated(camera=READING["camera"], frame="colmap")
        for name in ("a.exr", "b.exr")
    ]


def same(one, other):
    np.testing.assert_allclose(one.lights.direction, other.lights.direction, atol=1e-6)
    np.testing.assert_allclose(one.lights.irradiance, other.lights.irradiance, rtol=1e-5)


def test_batch_reads_maps_as_the_methods_do(folder, maps, tmp_path):
    el.batch(folder, tmp_path, lights=2, jobs=1, reading=READING)
    for name, env in zip("ab", maps, strict=True):
        same(el.Rig.load(tmp_path / f"{name}.json"), el.fit(env, 2))
    again = el.batch(folder, tmp_path, lights=2, jobs=1, reading=READING)
    assert again.unchanged == 2
    other = el.batch(folder, tmp_path, lights=2, jobs=1, reading={**READING, "lux": 100.0})
    assert other.unchanged == 0


def test_follow_reads_frames_as_the_methods_do(folder, maps):
    rigs = el.follow(folder, 2, steadiness=0, reading=READING).sequence()
    expected = el.follow(maps, 2, steadiness=0).sequence()
    np.testing.assert_allclose(rigs.irradiance, expected.irradiance, rtol=1e-5)


def test_compare_reads_both_sides_as_the_methods_do(folder, maps):
    paths = [folder / "a.exr", folder / "b.exr"]
    expected = el.compare(*maps)
    assert el.compare(*paths, reading=READING).probe_error == pytest.approx(expected.probe_error)
    # A map in memory stays as it is, and so does a rig.
    mixed = el.compare(maps[0], paths[1], reading=READING)
    assert mixed.probe_error == pytest.approx(expected.probe_error)
    table = el.compare_folders(folder, folder, reading=READING)
    assert table.mean["probe_error"] == pytest.approx(0, abs=1e-6)
    assert not table.failures


def run(*arguments):
    done = CliRunner().invoke(main, [*map(str, arguments)])
    assert done.exit_code == 0, done.output
    return done.stdout


def test_the_command_line_has_the_same_options_everywhere(folder, maps, tmp_path):
    run("batch", folder, "-o", tmp_path / "rigs", "--set", "lights=2", *WORDS)
    same(el.Rig.load(tmp_path / "rigs" / "b.json"), el.fit(maps[1], 2))
    run("follow", folder, "-n", 2, "--steadiness", 0, "-o", tmp_path / "rigs.csv", *WORDS)
    assert (tmp_path / "rigs.csv").exists()
    printed = run("compare", folder / "a.exr", folder / "b.exr", *WORDS)
    assert printed.rstrip() == str(el.compare(*(folder / name for name in ("a.exr", "b.exr")),
                                              reading=READING))  # fmt: skip


def test_arrays_take_what_the_constructor_takes():
    image = el.EnvMap(el.synthetic.hall(32).radiance).to(LAYOUT, width=32)
    env = as_envmap(np.asarray(image), {"layout": LAYOUT, "lux": 10.0})
    assert env.units == "cd/m2"
    assert as_envmap(np.ones((8, 16, 3)), {"fill": None}).units != "cd/m2"


@pytest.mark.parametrize(
    ("reading", "words"),
    [
        ({"color": "srgb"}, "colour, .*got 'color'"),
        ({"lights": 2}, "got 'lights'"),
        ({3: 4}, "got 3"),
        ("srgb", "must map names"),
    ],
)
def test_other_options_are_refused_before_a_map_is_read(reading, words):
    for call in (
        lambda: el.batch("no-folder", reading=reading),
        lambda: el.follow("no-folder/*.exr", reading=reading),
        lambda: el.compare_folders("no-folder", "none", reading=reading),
    ):
        with pytest.raises((el.EnvLightsError, TypeError), match=words):
            call()
    with pytest.raises(el.EnvLightsError, match="got 'colour'"):
        as_envmap(np.ones((8, 16, 3)), {"colour": "srgb"})
