"""Changed lights, and the map with them, against the irradiance of remainder and lights."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import envlights as el
from envlights.cli import main
from tests.public_maps import public_maps

NORMALS = el.kernels.uniform_sphere(np.random.default_rng(7).random((200, 2)))


def scene(height=128):
    """A sun, a red lamp and a window before a sky that brightens upwards."""
    shapes = [
        el.synthetic.Disc((1, 1, 0), 2.0, (900, 800, 700)),
        el.synthetic.Disc((-1, 0.2, 0.3), 3.0, (90, 10, 5)),
        el.synthetic.Rectangle((0, 0.3, -1), 12, 8, (20, 30, 40)),
    ]
    return el.EnvMap(el.synthetic.scene(height, background=[0.2, 0.3, 0.4], shapes=shapes).radiance)


@pytest.fixture(scope="module")
def parts():
    return el.split(scene())


def irradiance_of(parts, lights, normals):
    """Irradiance of the remainder and of the lights where all of each is visible."""
    return parts.remainder.probe(normals) + el.Rig(np.zeros(3), lights, error=0.0).probe(normals)


def facing(lights, reach=0.5):
    """Normals before whose horizon, or behind it, all lights lie completely."""
    cosine = NORMALS @ lights.direction.T
    return NORMALS[(np.abs(cosine) > np.sin(reach)).all(axis=1)]


def test_each_change_is_one_value_and_the_old_lights_stay():
    lights = el.Lights([[0, 1, 0], [1, 0, 0]], [[4, 4, 4], [1, 2, 3]], [0.1, 0.2])
    moved = lights.moved(1, azimuth=np.pi)
    np.testing.assert_allclose(moved.direction, [[0, 1, 0], [0, 0, 1]], atol=1e-15)
    assert moved.origin == (0, 1)
    assert lights.origin is None
    dimmed = lights.dimmed(0, 0.25)
    np.testing.assert_array_equal(dimmed.irradiance, [[1, 2, 3], [1, 1, 1]])
    assert dimmed.origin == (1, 0)
    assert dimmed.without(0).origin == (0,)
    np.testing.assert_array_equal(lights.irradiance, [[4, 4, 4], [1, 2, 3]])
    assert lights.resized(0, 0.5).angular_radius.tolist() == [0.5, 0.2]
    coloured = lights.coloured(1, [1, 0, 0])
    np.testing.assert_allclose(coloured.luminance, lights.luminance)
    assert lights.with_light([0, 0, 3], [9, 9, 9]).origin == (-1, 0, 1)
    warm = lights.coloured(0, kelvin=3000)
    np.testing.assert_allclose(warm.luminance, lights.luminance)
    assert (np.diff(warm.irradiance[0]) < 0).all()
    np.testing.assert_allclose(lights.coloured(0, kelvin=6504).irradiance[0], [4, 4, 4], rtol=1e-3)


def test_changed_lights_keep_their_origin_in_files_and_slices(tmp_path):
    lights = el.Lights([[0, 1, 0], [1, 0, 0]], [[4, 4, 4], [1, 2, 3]]).dimmed(0, 0.1)
    lights.save(tmp_path / "lights.json")
    assert el.Lights.load(tmp_path / "lights.json").origin == lights.origin == (1, 0)
    assert lights[1:].origin == (0,)
    assert lights.rotated(np.eye(3)).origin == (1, 0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda lights: lights.moved(0), "give a direction, or an azimuth"),
        (lambda lights: lights.moved(0, [0, 1, 0], azimuth=1), "give a direction, or an azimuth"),
        (lambda lights: lights.moved(0, [0, 0, 0]), "not all 0"),
        (lambda lights: lights.moved(0, [0, np.nan, 0]), "finite"),
        (lambda lights: lights.moved(0, elevation=2), "elevation must be a finite number, from"),
        (lambda lights: lights.dimmed(0, -1), "factor must be a finite number, 0 or more"),
        (lambda lights: lights.coloured(0, [0, 0, 0]), "rgb must not be black"),
        (lambda lights: lights.coloured(0), "give rgb or kelvin"),
        (lambda lights: lights.coloured(0, kelvin=900), "kelvin must be a finite number, from"),
        (lambda lights: lights.coloured(0, [1, 2]), "rgb must be three numbers"),
        (lambda lights: lights.resized(0, 2), "angular_radius must be a finite number, from 0"),
        (lambda lights: lights.resized(0, [0.1, 0.2]), "angular_radius must be a finite number"),
        (lambda lights: lights.with_light([0, 1, 0], [1, -1, 1]), "irradiance must be"),
        (lambda lights: el.Lights([[0, 1, 0]], [[1, 1, 1]], origin=(1, 2)), "origin must hold"),
    ],
)
def test_a_wrong_change_is_refused(change, words):
    with pytest.raises(el.EnvLightsError, match=words):
        change(el.Lights([[0, 1, 0]], [[1, 1, 1]]))
    with pytest.raises(IndexError):
        el.Lights([[0, 1, 0]], [[1, 1, 1]]).dimmed(1, 0.5)


def test_unchanged_lights_give_back_the_map(parts):
    np.testing.assert_allclose(
        parts.with_lights(parts.lights).radiance, scene().radiance, rtol=1e-6, atol=0
    )


def test_without_a_light_its_pixels_stay_filled(parts):
    """The irradiance is that of the remainder and of the other lights."""
    env = parts.with_lights(parts.lights.without(0))
    normals = facing(parts.lights.discs())
    expected = irradiance_of(parts, parts.lights.without(0), normals)
    np.testing.assert_allclose(env.probe(normals), expected, rtol=1e-4)
    chosen = parts.with_lights(parts.lights[1:])
    np.testing.assert_array_equal(env.radiance, chosen.radiance)


@pytest.mark.parametrize(
    "towards", [(0, 1, 0), (0.01, 0.1, -1), (-0.01, 0.1, -1), (0.3, -0.9, 0.1), (0, -1, 0)]
)
def test_a_moved_light_has_its_irradiance_anywhere(parts, towards):
    """Over the seam and the poles, dimmed and in another colour."""
    lights = parts.lights.moved(0, towards).coloured(0, [1, 0.6, 0.3])
    env = parts.with_lights(lights)
    normals = facing(lights)
    np.testing.assert_allclose(env.probe(normals), irradiance_of(parts, lights, normals), rtol=1e-4)


def test_a_moved_light_keeps_its_pixels():
    """A window that moves along the horizon by whole columns is the same picture there."""
    env = scene()
    parts = el.split(env)
    window = int(np.argmin(parts.lights.direction[:, 2]))
    azimuth = parts.lights.azimuth[window] + 2 * np.pi * 20 / env.width
    moved = parts.with_lights(parts.lights.moved(window, azimuth=azimuth))
    removed = parts.with_lights(parts.lights[[window]]).radiance - parts.remainder.radiance
    found = moved.radiance - parts.with_lights(parts.lights.without(window)).radiance
    np.testing.assert_allclose(found, np.roll(removed, 20, axis=1), atol=2e-2)


def test_an_added_and_a_resized_light_are_discs(parts):
    lights = parts.lights.resized(0, 0.2).with_light([0, -1, 0.5], [5, 6, 7], 0.1)
    normals = facing(lights)
    env = parts.with_lights(lights)
    np.testing.assert_allclose(env.probe(normals), irradiance_of(parts, lights, normals), rtol=1e-4)


def test_lights_of_another_split_are_refused(parts):
    stranger = el.Lights([[0, 1, 0]], [[1, 1, 1]], origin=(77,))
    with pytest.raises(el.EnvLightsError, match="must be those of this split"):
        parts.with_lights(stranger)
    with pytest.raises(el.EnvLightsError, match=r"by `el\.split`"):
        el.Split(parts.lights, parts.remainder).with_lights(parts.lights)


def test_a_part_of_the_sphere_allows_dimming_alone():
    coverage = np.ones((128, 256), np.float32)
    coverage[100:] = 0
    env = el.EnvMap(scene().radiance, coverage=coverage)
    parts = el.split(env)
    dimmed = parts.with_lights(parts.lights.dimmed(0, 0.5))
    assert dimmed.coverage is not None
    assert dimmed.radiance.max() < env.radiance.max()
    with pytest.raises(el.EnvLightsError, match="shows a part of the sphere"):
        parts.with_lights(parts.lights.moved(0, [0, 1, 0]))


@public_maps()
def test_moved_lights_of_real_maps(path):
    env = el.EnvMap.open(path)
    parts = el.split(env, 2)
    if not len(parts.lights):
        pytest.skip("a map without lights")
    np.testing.assert_allclose(
        parts.with_lights(parts.lights).radiance, env.radiance, rtol=1e-6, atol=1e-6
    )
    lights = parts.lights.moved(0, [0.02, 0.6, -0.8])
    env = parts.with_lights(lights)
    towards = lights.direction[lights.origin.index(0)]
    np.testing.assert_allclose(
        (
            env.probe(towards)
            - parts.with_lights(lights.without(lights.origin.index(0))).probe(towards)
        ),
        lights.irradiance[lights.origin.index(0)],
        rtol=2e-4,
    )


def test_the_command_changes_lights_by_the_numbers_of_split(tmp_path):
    source, out = str(tmp_path / "map.exr"), str(tmp_path / "new.exr")
    scene().save(source)
    args = ["--move", "1=,20", "--gain", "1=0.5", "--remove", "2", "--add", "200,80,3", "-o", out]
    result = CliRunner().invoke(main, ["relight", source, *args])
    assert result.exit_code == 0, result.output
    env = el.EnvMap.open(source)
    parts = el.split(env)
    lights = parts.lights.moved(0, elevation=np.deg2rad(20)).dimmed(0, 0.5)
    towards = el.kernels.uv_to_direction([[200 / 360, 0.5 - 80 / 180]])[0]
    lights = lights.with_light(towards, [3, 3, 3])
    lights = lights.without(lights.origin.index(parts.lights.origin[1]))
    expected = parts.with_lights(lights).radiance
    np.testing.assert_allclose(el.EnvMap.open(out).radiance, expected, rtol=1e-3)


def test_the_command_moves_by_degrees_colours_by_temperature_and_resizes(tmp_path):
    """A sun 20 degrees lower and redder in one command."""
    source, out = str(tmp_path / "map.exr"), str(tmp_path / "new.exr")
    scene().save(source)
    args = ["--turn", "1=400,-20", "--tint", "1=2500K", "--radius", "1=1.5", "-o", out]
    result = CliRunner().invoke(main, ["relight", source, *args])
    assert result.exit_code == 0, result.output
    assert "note" not in result.output
    parts = el.split(el.EnvMap.open(source))
    azimuth, elevation = (each[0] for each in (parts.lights.azimuth, parts.lights.elevation))
    lights = parts.lights.moved(
        0, azimuth=azimuth + np.deg2rad(40), elevation=elevation - np.deg2rad(20)
    )
    lights = lights.coloured(0, kelvin=2500).resized(0, np.deg2rad(1.5))
    expected = parts.with_lights(lights).radiance
    np.testing.assert_allclose(el.EnvMap.open(out).radiance, expected, rtol=1e-3)


def test_the_command_notes_a_light_below_the_horizon(tmp_path):
    """An elevation is easily taken for a difference."""
    source, out = str(tmp_path / "map.exr"), str(tmp_path / "new.exr")
    scene().save(source)
    result = CliRunner().invoke(main, ["relight", source, "--move", "1=,-20", "-o", out])
    assert result.exit_code == 0
    assert "note: a light was moved below the horizon, from 45.0 to -20.0 degrees" in result.output


def test_the_command_reads_lights_that_were_changed_by_hand(tmp_path):
    source, out, file = (str(tmp_path / name) for name in ("map.exr", "new.exr", "lights.json"))
    scene().save(source)
    assert CliRunner().invoke(main, ["split", source, "-o", file]).exit_code == 0
    data = json.loads((tmp_path / "lights.json").read_text())
    data["direction"][0] = [0, 1, 0]
    (tmp_path / "lights.json").write_text(json.dumps(data))
    result = CliRunner().invoke(main, ["relight", source, "--lights", file, "-o", out])
    assert result.exit_code == 0, result.output
    assert el.split(out, 1).lights.direction[0, 1] > 0.999


def test_the_command_draws_the_lights_of_a_rig_as_discs(tmp_path):
    source, out, file = (str(tmp_path / name) for name in ("map.exr", "new.exr", "rig.json"))
    scene().save(source)
    lights = el.Lights([[0, 1, 0], [0.6, 0.8, 0]], [[30, 20, 10], [5, 5, 5]], [0.1, 0.2])
    el.Rig([0.1, 0.2, 0.3], lights).save(file)
    result = CliRunner().invoke(main, ["relight", source, "--lights", file, "-o", out])
    assert result.exit_code == 0, result.output
    expected = el.split(el.EnvMap.open(source)).with_lights(lights)
    np.testing.assert_allclose(el.EnvMap.open(out).radiance, expected.radiance, rtol=1e-3)


@pytest.mark.parametrize(
    ("args", "words"),
    [
        ([], "give --lights, or what to change"),
        (["--move", "1=x,3"], "--move must be a number"),
        (["--move", "1=,95"], "elevation in degrees must be a finite number, from -90 to 90"),
        (["--move", "9=1,3"], "names light 9; the map has"),
        (
            ["--turn", "1=0,60"],
            "the new elevation in degrees must be a finite number, from -90 to 90",
        ),
        (["--turn", "1=5"], "--turn must be two numbers"),
        (["--tint", "1=red"], "--tint must be three numbers"),
        (["--tint", "1=99K"], "kelvin must be a finite number, from 2000 to 15000"),
        (["--gain", "half"], "--gain must be such as 1=0.5"),
        (["--remove", "1", "--remove", "1"], "names light 1 twice"),
    ],
)
def test_the_command_refuses_in_a_sentence(args, words, tmp_path):
    scene().save(tmp_path / "map.exr")
    paths = [str(tmp_path / "map.exr"), "-o", str(tmp_path / "new.exr")]
    result = CliRunner().invoke(main, ["relight", *paths, *args])
    assert result.exit_code
    assert words in result.output
    assert not (tmp_path / "new.exr").exists()
