"""One meaning of an option in all subcommands: -n, -o, flux fractions, --sun with --shapes."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import envlights as el
from envlights.cli import main
from tests.helpers import NORMALS

HALL = el.EnvMap(el.synthetic.hall(128).radiance)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("maps")
    HALL.save(folder / "hall.exr")
    return folder


def run(*arguments, code=0):
    done = CliRunner().invoke(main, [*map(str, arguments)])
    assert done.exit_code == code, done.output
    return done.stdout if code == 0 else done.output


def test_at_most_n_lights_are_the_brightest_of_all():
    every = el.detect(HALL)
    some = el.detect(HALL, lights=2)
    np.testing.assert_array_equal(some.direction, every[:2].direction)
    np.testing.assert_array_equal(some.flux_fraction, every[:2].flux_fraction)
    left = f"{len(every) - 2} weaker light"
    assert any(left in line for line in some.report.skipped)
    assert el.detect(HALL, lights=99) == every
    assert len(el.detect(HALL, lights=0)) == 0


def test_what_is_left_stays_in_the_remainder_of_a_detection():
    """The mean radiance of a map is that of its lights and of the remainder."""
    for lights in (None, 1, 0):
        found = el.detect(HALL, lights=lights)
        mean = found.flux.sum(axis=0) / (4 * np.pi) + found.report.remainder
        weights = el.kernels.pixel_solid_angles(HALL.height, HALL.width) / (4 * np.pi)
        expected = (HALL.radiance * weights[..., None]).sum(axis=(0, 1))
        np.testing.assert_allclose(mean, expected, rtol=1e-5)


@pytest.mark.parametrize(
    "find",
    [
        lambda: el.detect(HALL),
        lambda: el.split(HALL).lights,
        lambda: el.papers.loghin.detect(HALL),
    ],
)
def test_fractions_are_of_the_whole_map(find):
    found = find()
    weights = el.kernels.pixel_solid_angles(HALL.height, HALL.width)
    whole = (HALL.radiance @ [0.2126, 0.7152, 0.0722] * weights).sum()
    fraction = found.flux @ [0.2126, 0.7152, 0.0722] / whole
    np.testing.assert_allclose(found.flux_fraction, fraction, rtol=2e-3)


def test_n_is_the_same_in_all_subcommands(folder):
    found = json.loads(run("detect", folder / "hall.exr", "-n", 2, "--json"))
    np.testing.assert_allclose(found["direction"], el.detect(HALL)[:2].direction, atol=1e-6)
    merged = json.loads(run("detect", folder / "hall.exr", "--max-lights", 2, "--json"))
    assert sum(merged["flux_fraction"]) > sum(found["flux_fraction"])
    removed = json.loads(run("split", folder / "hall.exr", "-n", 2, "--json"))
    assert len(removed["direction"]) == 2
    for command in ("fit", "detect", "split", "photograph"):
        assert "-n, --lights" in run(command, "--help")
    words = ["detect", folder / "hall.exr", "--method", "loghin", "--max-lights", 2]
    assert "--method tree" in run(*words, code=2)


def test_convert_and_export_take_o(folder, tmp_path):
    run("convert", folder / "hall.exr", "-o", tmp_path / "a.exr", "--width", 32)
    run("convert", folder / "hall.exr", tmp_path / "b.exr", "--width", 32)
    assert el.EnvMap.open(tmp_path / "a.exr") == el.EnvMap.open(tmp_path / "b.exr")
    el.fit(HALL, 2).save(tmp_path / "rig.json")
    run("export", tmp_path / "rig.json", "-o", "usd", "-o", tmp_path / "x.gltf")
    assert {path.name for path in tmp_path.glob("*.[ug]*")} == {"rig.usda", "x.gltf"}
    assert "give -o" in run("export", tmp_path / "rig.json", code=2)
    assert "give -o" in run("convert", folder / "hall.exr", code=2)


def test_a_mistyped_command_has_a_suggestion():
    assert "Did you mean detect?" in run("detct", code=2)
    assert "Did you mean" not in run("quaternion", code=2)


def test_the_sun_becomes_a_card_beside_those_of_the_sky(tmp_path):
    """Cards and remainder together light a surface as the sun and the rest do."""
    lamp = el.synthetic.Disc((0, 0.3, -1), 6.0, (3, 3, 3))
    sky = el.synthetic.scene(128, background=[0.2, 0.3, 0.4], shapes=[lamp]).radiance
    env = el.EnvMap(np.minimum(sky, 3.0), clip_level=3.0)
    env.save(tmp_path / "sky.exr")
    words = ["--clip-level", "3", "--sun-direction", "0.36,0.8,0.48", "--irradiance", "3"]
    out = ["-o", tmp_path / "rest.exr", "--json"]
    cards = json.loads(run("split", tmp_path / "sky.exr", *words, "--shapes", *out))
    for most in (1, 2):
        few = run("split", tmp_path / "sky.exr", *words, "--shapes", "--json", "-n", most)
        assert len(json.loads(few)["shape"]) == most
    rest = el.EnvMap.open(tmp_path / "rest.exr")
    alone = el.with_sun(env, [0.36, 0.8, 0.48], irradiance=3.0)
    assert cards["shape"].count("disc") >= 1
    sun = int(np.argmax(np.array(cards["irradiance"]).sum(axis=1)))
    np.testing.assert_allclose(cards["irradiance"][sun], alone.lights.irradiance[0], rtol=1e-6)
    matrix = np.array(cards["matrix"][sun])
    centre = matrix @ [0.5, 0.5, 1]
    np.testing.assert_allclose(centre, [0.36, 0.8, 0.48], atol=1e-6)
    assert np.linalg.det(matrix) > 0
    assert matrix[1, 1] < 0  # the second axis goes down
    half = np.linalg.norm(matrix[:, 0]) / 2
    assert np.arctan(half) == pytest.approx(alone.lights.angular_radius[0], rel=1e-6)
    lights = el.Cards(cards["shape"], cards["matrix"], cards["irradiance"])
    there = lights.probe(NORMALS) + rest.probe(NORMALS)
    expected = alone.remainder.probe(NORMALS) + el.Rig([0, 0, 0], alone.lights).probe(NORMALS)
    assert np.linalg.norm(there - expected) < 0.02 * np.linalg.norm(expected)
