"""Sun on the command line: `split --sun`, `repair --sun`, `fit --sun`."""

import json
import re

import numpy as np
import pytest
from click.testing import CliRunner

import envlights as el
from envlights.cli import main
from tests.sun.suns import IRRADIANCE, TOWARDS, clipped, sun_of


@pytest.fixture
def searches(monkeypatch):
    """Arguments of the search, which finds a sun by hand."""
    calls = []

    def find(env, **options):
        calls.append(options)
        return sun_of(clipped()[1])

    monkeypatch.setattr("envlights.sun.choice.find_sun", find)
    return calls


@pytest.fixture
def picture(tmp_path):
    path = tmp_path / "map.exr"
    clipped()[0].save(path)
    return path


def run(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def test_split_writes_the_sky_and_a_scene_of_the_sun(picture, searches, tmp_path):
    files = [tmp_path / name for name in ("rest.exr", "sun.py", "sun.png")]
    result = run("split", picture, "--sun", *(word for file in files for word in ("-o", file)))
    assert result.exit_code == 0, result.output
    assert searches == [{}]
    assert "the irradiance is a guess" in result.stdout
    assert "MAP = 'rest.exr'" in files[1].read_text()
    env, plateau = clipped()
    _, rest = el.with_sun(env, sun_of(plateau))
    np.testing.assert_array_equal(el.EnvMap.open(files[0]).radiance, rest.radiance)
    assert files[2].read_bytes().startswith(b"\x89PNG")


def test_split_prints_the_sun_as_json_with_the_irradiance_of_a_reading(picture, searches):
    result = run("split", picture, "--sun-direction", "0.48,0.6,0.64", "--ratio", 6, "--json")
    lights = json.loads(result.stdout)
    np.testing.assert_allclose(searches[-1]["direction"], TOWARDS)
    np.testing.assert_allclose(lights["direction"], [TOWARDS])
    env, plateau = clipped()
    expected = el.with_sun(env, sun_of(plateau), ratio=6).lights.irradiance
    np.testing.assert_allclose(lights["irradiance"], expected)
    assert "ratio of 6" in lights["notes"][0]


def test_the_picture_has_the_irradiance_of_a_reading(picture, searches, tmp_path, monkeypatch):
    drawn = []

    def draw(env, sun):
        drawn.append(sun)
        return el.plot.Picture()

    monkeypatch.setattr(el.plot, "sun", draw)
    result = run("split", picture, "--sun", "--ratio", 6, "-o", tmp_path / "sun.png")
    assert result.exit_code == 0, result.output
    env, plateau = clipped()
    expected = el.with_sun(env, sun_of(plateau), ratio=6).lights.irradiance
    np.testing.assert_allclose(drawn[0].irradiance, expected[0])


def test_repair_draws_the_sun(picture, searches, tmp_path):
    repaired = tmp_path / "repaired.exr"
    result = run("repair", picture, "--sun", "-o", repaired)
    assert result.exit_code == 0, result.output
    assert "added as a disc" in result.stdout
    expected = el.with_sun(clipped()[0], sun_of(clipped()[1])).to_map()
    np.testing.assert_array_equal(el.EnvMap.open(repaired).radiance, expected.radiance)


def test_fit_has_the_sun_as_a_light(picture, searches):
    result = run("fit", picture, "-n", 2, "--sun", "--json")
    assert result.exit_code == 0, result.output
    rig = json.loads(result.stdout)
    (row,) = rig["report"]["fixed"]
    np.testing.assert_allclose(rig["lights"]["irradiance"][row], IRRADIANCE)


def test_a_time_and_a_place_give_the_elevation(picture, searches):
    place = ["--latitude", 51.48, "--longitude", 0]
    result = run("split", picture, "--sun-time", "2024-06-21T12:00Z", *place)
    assert result.exit_code == 0, result.output
    assert searches[-1]["elevation"] == pytest.approx(62.0, abs=0.1)
    run("split", picture, "--sun-time", "2024-06-21T12:00Z", *place, "--north", 90)
    np.testing.assert_allclose(searches[-1]["direction"], [-0.47, 0.88, 0.01], atol=0.005)


def test_a_direction_of_the_sun_is_one_of_the_frame(picture, searches):
    run("split", picture, "--sun-direction", "0.48,0.6,0.64", "--frame", "blender")
    expected = el.frames.frame_named("blender").from_target([0.48, 0.6, 0.64])
    np.testing.assert_allclose(searches[-1]["direction"], expected, atol=1e-9)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--sun", "-n", "1"], "a sun is one light; leave out --lights"),
        (["--sun", "--limit", "3"], "a sun is one light; leave out --lights"),
        (["--ratio", "3"], "--irradiance and --ratio are readings of a sun; add --sun"),
        (["--sun-direction", "1,2"], "--sun-direction must be three numbers"),
        (["--sun-direction", "0,-1,0"], "sun must be above the horizon"),
        (["--sun-time", "noon"], "--sun-time, --latitude and --longitude go together"),
        (["--north", "3"], "--sun-time, --latitude and --longitude go together"),
        (
            ["--sun-time", "noon", "--latitude", "0", "--longitude", "0"],
            "--sun-time must be a time with its zone, .*; got noon",
        ),
        (
            ["--sun-direction", "0,1,0", "--north", "3"],
            "give --sun-direction or --sun-time, not both",
        ),
    ],
)
def test_what_makes_no_sense_is_refused(picture, searches, arguments, message):
    result = run("split", picture, *arguments)
    assert result.exit_code == 2
    assert len(result.stderr.splitlines()) == 1
    assert re.search(message, result.stderr)


def test_without_a_sun_the_output_says_so(picture):
    result = run("split", picture, "--sun")
    assert result.exit_code == 0
    assert "no sun was added" in result.stdout
