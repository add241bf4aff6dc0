"""Sun as a light of its own, and the sky without it."""

import datetime
from dataclasses import replace

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from envlights.cli.repair import repair_with_sun
from envlights.kernels.image import LUMINANCE
from tests.helpers import NORMALS
from tests.sun.suns import IRRADIANCE, TOWARDS, clipped, sky, sun_of

UP = [0.0, 1.0, 0.0]
NIGHT = datetime.datetime(2024, 6, 21, 0, tzinfo=datetime.timezone.utc)
NOON = datetime.datetime(2024, 6, 21, 12, tzinfo=datetime.timezone.utc)


def upward(parts):
    """Luminance of the irradiance on an upward surface under sky and sun."""
    under = parts.remainder.probe(UP) + parts.lights.irradiance[0] * parts.lights.direction[0, 1]
    return float(under @ LUMINANCE)


def test_the_light_is_a_disc_of_the_sun_and_the_rest_has_sky_behind_it():
    env, plateau = clipped()
    lights, rest = el.with_sun(env, sun_of(plateau))
    np.testing.assert_allclose(lights.direction, [TOWARDS])
    np.testing.assert_allclose(lights.irradiance, [IRRADIANCE])
    assert np.degrees(lights.angular_radius) == pytest.approx([0.265])
    assert rest.clip_level is None
    np.testing.assert_array_equal(rest.radiance[~plateau], env.radiance[~plateau])
    np.testing.assert_allclose(rest.radiance[plateau] @ LUMINANCE, 1.5, rtol=1e-6)


@pytest.mark.parametrize("answer", ["perhaps", "no"])
def test_without_the_answer_sun_there_is_no_light_and_the_map_stays(answer):
    env, plateau = clipped()
    env = env.with_radiance(env.radiance, ("a picture of May",))
    lights, rest = el.with_sun(env, sun_of(plateau, answer, notes=("too many clouds",)))
    assert len(lights) == 0
    assert rest == env
    assert rest.notes[0] == "a picture of May"
    assert repr(answer) in rest.notes[-1]
    assert "too many clouds" in rest.notes[-1]
    assert rest.notes[-1] in str(lights)


def test_a_guess_is_called_a_guess_with_its_interval():
    env, plateau = clipped()
    parts = el.with_sun(env, sun_of(plateau))
    for text in (parts.lights.notes[0], parts.remainder.notes[-1], str(parts), parts._repr_html_()):
        assert "the direction is a guess, by depth and symmetry" in text
        assert "the irradiance is a guess, in two of three maps true times 0.5 to 2" in text
        assert "± 1.1°" in text


def test_the_lights_of_a_sun_alone_say_so_too_also_in_a_file(tmp_path):
    lights = sun_of().lights
    assert lights.notes == el.with_sun(sky(), sun_of()).lights.notes
    for name in ("sun.json", "sun.py"):
        lights.save(tmp_path / name)
        assert "the irradiance is a guess" in (tmp_path / name).read_text()
    assert sun_of(answer="no").lights.notes == ()


def test_a_given_direction_is_no_guess():
    sun = sun_of(evidence=("given",), direction_uncertainty=0.0, interval=(1.0, 1.0))
    (note,) = el.with_sun(sky(), sun).lights.notes
    assert "guess" not in note
    assert "as given" in note


def test_an_irradiance_is_that_of_sun_and_sky():
    env, plateau = clipped()
    parts = el.with_sun(env, sun_of(plateau), irradiance=12.5)
    assert upward(parts) == pytest.approx(12.5, rel=1e-9)
    measured = parts.lights.irradiance[0]
    np.testing.assert_allclose(measured / measured[0], IRRADIANCE / IRRADIANCE[0])
    assert "irradiance of 12.5" in parts.lights.notes[0]
    assert "irradiance is a guess" not in parts.lights.notes[0]


def test_a_ratio_is_that_of_two_readings():
    env, plateau = clipped()
    parts = el.with_sun(env, sun_of(plateau), ratio=6.0)
    shaded = float(parts.remainder.probe(UP) @ LUMINANCE)
    assert upward(parts) / shaded == pytest.approx(6.0, rel=1e-9)


def test_light_and_rest_turn_with_the_map():
    env, plateau = clipped()
    turn = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    quarter = np.roll(plateau, -32, axis=1)
    lights, rest = el.with_sun(env, sun_of(plateau))
    turned = el.with_sun(env.rotated(turn), sun_of(quarter, direction=turn @ TOWARDS))
    np.testing.assert_allclose(turned.lights.direction, lights.rotated(turn).direction)
    np.testing.assert_allclose(
        turned.remainder.probe(NORMALS @ turn.T), rest.probe(NORMALS), rtol=1e-5
    )


def test_a_calibrated_map_has_a_sun_in_lux():
    env = sky().calibrated(lux=10000)
    lights, _ = el.with_sun(env, sun_of(units="cd/m2"), irradiance=90000)
    assert lights.units == "cd/m2"
    up = float(lights.irradiance[0] @ LUMINANCE * TOWARDS[1])
    assert up == pytest.approx(80000, rel=1e-5)


@pytest.mark.parametrize(
    ("sun", "message"),
    [
        ("maybe", r"sun must be 'auto', a direction .*; got 'maybe'"),
        ([0, 0, 0], r"sun must be .* not all 0, .*; got \(0, 0, 0\)"),
        ([0, np.nan, 1], r"sun must be .* finite numbers .*; got \(0.0, nan, 1.0\)"),
        ([0, 1], "sun must be 'auto', a direction"),
        ([[0, 1, 0]], "sun must be 'auto', a direction"),
        (None, "sun must be 'auto', .*; got None"),
        ([0, -1, 2], "sun must be above the horizon; got an elevation of -26.6°"),
        (sun_of(direction=[0, -0.6, 0.8]), "sun must be above the horizon; got .* -36.9°"),
        (el.sun.SunAt(NIGHT, 51.48, 0.0), "sun must be above the horizon; got an elevation of -15"),
        (sun_of(units="cd/m2"), "sun must have the units of the map"),
        (sun_of(np.ones((4, 8), bool)), r"sun must be that of this map, of \(64, 128\) pixels"),
    ],
)
def test_an_impossible_sun_is_refused(sun, message):
    with pytest.raises(el.EnvLightsError, match=message):
        el.with_sun(sky(), sun)


def test_a_ratio_to_a_black_sky_is_refused():
    env = sky()
    with pytest.raises(el.EnvLightsError, match="black without the sun"):
        el.with_sun(el.EnvMap(0 * env.radiance), sun_of(), ratio=5.0)


@pytest.mark.parametrize(
    ("reading", "message"),
    [
        ({"irradiance": 0.5}, "irradiance must be at least that of the sky .*; got 0.5"),
        ({"ratio": 0.9}, "ratio must be at least .*, 1; got 0.9"),
        ({"ratio": np.nan}, "ratio must be a finite number"),
        ({"ratio": 2.0, "irradiance": 3.0}, "give irradiance or ratio, not both"),
    ],
)
def test_an_impossible_reading_is_refused(reading, message):
    with pytest.raises(el.EnvLightsError, match=message):
        el.with_sun(sky(), sun_of(), **reading)


def test_a_time_gives_the_direction_or_the_elevation(monkeypatch):
    asked = {}

    def find(env, **options):
        asked.update(options)
        return sun_of()

    monkeypatch.setattr("envlights.sun.choice.find_sun", find)
    at = el.sun.SunAt(NOON, 51.48, 0.0, north=90)
    el.with_sun(sky(), at)
    np.testing.assert_allclose(asked.pop("direction"), at.direction)
    el.with_sun(sky(), replace(at, north=None))
    assert asked.pop("elevation") == pytest.approx(np.degrees(at.elevation))
    el.with_sun(sky(), (0, 3, 4))
    np.testing.assert_allclose(asked.pop("direction"), [0, 0.6, 0.8])
    el.with_sun(sky())
    assert asked == {}


# The disc in the pixels


@pytest.mark.parametrize("registration", ["cell-centred", "border-sampled"])
@pytest.mark.parametrize("height", [64, 200, 512])
@pytest.mark.parametrize(
    "direction",
    [
        [0, 1, 0],
        [0.001, 1, 0],
        [0, 0.3, -1],
        [1e-9, 0.5, -1],
        [0.6, 0.8, 0],
        [0.3, 0.1, 0.2],
    ],
    ids=["pole", "beside the pole", "seam", "beside the seam", "on axis", "low"],
)
def test_the_pixels_of_the_disc_have_its_irradiance(height, registration, direction):
    env = sky(height, registration)
    direction = np.array(direction) / np.linalg.norm(direction)
    repaired = el.with_sun(env, sun_of(direction=direction)).to_map()
    added = repaired.probe(direction) - env.probe(direction)
    np.testing.assert_allclose(added, IRRADIANCE, rtol=1e-6)
    assert repaired.registration == registration


@pytest.mark.slow
def test_so_have_those_of_a_map_of_8192_rows():
    dark = el.EnvMap(np.zeros((8192, 16384, 3), np.float32))
    repaired = el.with_sun(dark, sun_of()).to_map()
    np.testing.assert_allclose(repaired.probe(TOWARDS), IRRADIANCE, rtol=1e-6)


def test_the_probe_is_that_of_sky_and_sun():
    env, plateau = clipped(1024)
    sun = sun_of(plateau)
    lights, rest = el.with_sun(env, sun)
    rig = el.Rig([0, 0, 0], lights, error=0.0)
    together = rest.probe(NORMALS) + rig.probe(NORMALS)
    drawn = el.with_sun(env, sun).to_map().probe(NORMALS)
    # At normals whose horizon cuts the disc, its pixels differ from a circle: 1e-4 of the sun.
    cut = np.abs(NORMALS @ TOWARDS) < np.radians(0.6)
    np.testing.assert_allclose(drawn[~cut], together[~cut], rtol=1e-6)
    np.testing.assert_allclose(drawn, together, atol=3e-4 * IRRADIANCE.max())


def test_the_disc_is_as_wide_as_the_sun_or_as_a_pixel():
    for height in (128, 2048):
        dark = el.EnvMap(np.zeros((height, 2 * height, 3), np.float32))
        drawn = el.with_sun(dark, sun_of()).to_map().radiance[..., 0]
        solid_angle = kernels.pixel_solid_angles(height, 2 * height)
        covered = solid_angle[drawn > 0.5 * drawn.max()].sum()
        radius = np.degrees(np.sqrt(covered / np.pi))
        assert radius == pytest.approx(max(0.265, 180 / height), rel=0.25)


def test_the_drawn_disc_agrees_with_that_of_lights():
    dark = el.EnvMap(np.zeros((2048, 4096, 3), np.float32))
    drawn = el.with_sun(dark, sun_of()).to_map().radiance
    reference = sun_of().lights.to_map(2048).radiance
    is_inside = reference[..., 0] > 0.99 * reference.max()
    # Both blur the rim over a pixel, a third of the radius here, in different ways.
    np.testing.assert_allclose(drawn[is_inside], reference[is_inside], rtol=0.04)
    is_outside = kernels.pixel_directions(2048, 4096) @ TOWARDS < np.cos(np.radians(0.4))
    assert not drawn[is_outside].any()


def test_a_reading_is_that_of_the_repaired_map():
    env, plateau = clipped()
    repaired = el.with_sun(env, sun_of(plateau), irradiance=20.0).to_map()
    assert float(repaired.probe(UP) @ LUMINANCE) == pytest.approx(20.0, rel=1e-6)
    assert repaired.clip_level is None
    assert "added as a disc" in repaired.notes[-1]


def test_without_a_sun_the_repair_is_that_of_the_kernel():
    from envlights.environment.repair import repair

    env, _ = clipped()
    expected = repair(env._pixels, None, None)
    repaired = env.repaired()
    assert repaired.radiance.tobytes() == expected.radiance.tobytes()
    assert repaired.notes == (*env.notes, expected.note)
    assert env.repaired(sun=None) == repaired
    with pytest.raises(el.EnvLightsError, match=r"takes no sun; el\.with_sun\(env, sun\)\.to_map"):
        env.repaired(sun="auto")


@pytest.mark.parametrize("answer", ["perhaps", "no"])
def test_without_the_answer_sun_the_repair_is_that_without_a_sun(answer):
    env, plateau = clipped()
    parts = el.with_sun(env, sun_of(plateau, answer))
    assert parts.to_map() is parts.remainder
    repaired = repair_with_sun(env, sun_of(plateau, answer))
    assert repaired == env.repaired()
    assert "no sun was added" in repaired.notes[-2]
    assert repaired.notes[-1] == env.repaired().notes[-1]


def test_an_unseen_sun_is_a_light_but_no_pixels():
    seen = np.ones((64, 128))
    seen[:20] = 0
    env = sky(coverage=seen)
    sun = sun_of(direction=[0, 1, 0])
    assert len(el.with_sun(env, sun).lights) == 1
    with pytest.raises(el.EnvLightsError, match="sun must be in the part that the map shows"):
        el.with_sun(env, sun).to_map()
