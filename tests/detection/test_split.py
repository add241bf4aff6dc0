"""Lights removed from maps: closed forms, closure of energy, and the rest."""

import numpy as np
import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st

import envlights as el
from envlights import kernels
from envlights.kernels.image import LUMINANCE
from envlights.synthetic import Disc, PixelSun, Rectangle, scene
from tests.conftest import real_maps
from tests.detection.worlds import SKY, three, world
from tests.helpers import printed_by_threads

NORMALS, _ = kernels.icosphere(5120)

#: On the seam, at both poles, and elsewhere.
PLACES = [(0, 0, -1), (0.02, 0.3, -1), (0, 1, 0), (0.05, 1, 0.02), (0.1, -1, 0), (1, 0.4, 0.3)]


def closure(env, lights, rest):
    """Relative difference of map and rest with lights at normals that see each light whole or not.

    By `vector_irradiance`, so that parts across the directions count.
    """
    cosine = NORMALS @ lights.direction.T
    # A light that reaches a right angle from its direction is seen whole by no surface.
    is_whole = (np.abs(cosine) > np.sin(np.minimum(lights.reach, np.pi / 2))).all(axis=1)
    seen = np.einsum("nl,na,lca->nc", cosine > 0, NORMALS, lights.vector_irradiance)
    truth = env.probe(NORMALS[is_whole])
    return np.abs(rest.probe(NORMALS[is_whole]) + seen[is_whole] - truth) / truth


def left_over(env, lights, rest):
    """Vector irradiance of map less rest less lights, relative to what both sides of a surface see.

    A surface and its back see all of the sphere, so this holds for lights of any reach.
    """
    both = np.r_[NORMALS, -NORMALS]
    whole, left = (np.split(each.probe(both), 2) for each in (env, rest))
    taken = NORMALS @ lights.vector_irradiance.sum(axis=0).T
    return np.abs(whole[0] - whole[1] - left[0] + left[1] - taken) / (whole[0] + whole[1])


# Closed forms


@pytest.mark.parametrize("direction", PLACES)
def test_a_disc_before_an_even_sky_leaves_that_sky(direction):
    env = world([Disc(direction, 4.0, (90, 60, 30))])
    lights, rest = el.split(env)
    assert len(lights) == 1
    np.testing.assert_array_equal(rest.radiance, np.broadcast_to(np.float32(SKY), (128, 256, 3)))
    np.testing.assert_allclose(np.linalg.norm(lights.vector_irradiance, axis=2), lights.irradiance)
    assert lights.off_axis.max() < 1e-6
    taken = (env.radiance.astype(float) - rest.radiance).reshape(-1, 3)
    angles = kernels.pixel_solid_angles(128, 256).reshape(-1, 1)
    flux = (taken * angles).sum(axis=0) @ LUMINANCE
    map_flux = (env.radiance.reshape(-1, 3) * angles).sum(axis=0) @ LUMINANCE
    np.testing.assert_allclose(lights.flux_fraction, flux / map_flux, rtol=1e-6)


def test_a_removed_light_gives_what_its_disc_gives():
    radius = np.deg2rad(4.0)
    lights, _ = el.split(world([Disc((1, 0.4, 0.3), 4.0, (90, 60, 30))], height=512))
    # Of radiance L above the sky, a disc gives pi L sin^2 a at normal incidence.
    expected = np.pi * np.sin(radius) ** 2 * (np.array([90, 60, 30]) - SKY)
    np.testing.assert_allclose(lights.irradiance[0], expected, rtol=2e-3)
    np.testing.assert_allclose(lights.angular_radius, radius, rtol=0.02)


def test_the_fill_continues_a_harmonic_sky():
    """The logarithm of tan(theta / 2) solves Laplace's equation on the sphere."""
    theta = np.pi * (np.arange(256) + 0.5) / 256
    sky = 5 + np.log(np.tan(theta / 2))[:, None, None] * np.ones((1, 512, 3))
    sky = np.maximum(sky, 1)  # not so near the poles
    for direction in [(1, 0.2, 0.3), (0, 0.2, -1)]:
        shape = world([Disc(direction, 6.0, (900, 800, 700))], 256, (0, 0, 0)).radiance
        _, rest = el.split((sky + shape).astype(np.float32))
        np.testing.assert_allclose(rest.radiance, sky, rtol=2e-3)


def test_lights_that_are_apart_are_removed_as_if_alone():
    one, two = Disc((0, 0.2, -1), 3.0, (90, 60, 30)), Disc((1, 0.4, 0.3), 5.0, (9, 30, 60))
    together, alone = el.split(world([one, two])), [el.split(world([each])) for each in (one, two)]
    for light in together.lights:
        (same,) = [
            taken.lights[0]
            for taken in alone
            if np.allclose(taken.lights.direction[0], light.direction, atol=1e-6)
        ]
        np.testing.assert_allclose(light.irradiance, same.irradiance, rtol=1e-6)
    np.testing.assert_array_equal(together.remainder.radiance, alone[0].remainder.radiance)


def test_a_split_map_is_a_fixed_point():
    lamps = [Disc(place, 3.0, (40, 50, 60)) for place in PLACES[::2]]
    _, rest = el.split(world([*lamps, Rectangle((-1, 0.3, 0.2), 20, 12, (9, 8, 7))]))
    lights, again = el.split(rest)
    assert len(lights) == 0
    np.testing.assert_array_equal(again.radiance, rest.radiance)


def test_lights_that_stay_are_found_again_in_the_rest():
    lights, rest = el.split(three(), 1)
    others, nothing = el.split(rest)
    assert (len(lights), len(others), len(el.split(nothing).lights)) == (1, 2, 0)
    np.testing.assert_array_equal(nothing.radiance, el.split(three()).remainder.radiance)


@pytest.mark.parametrize("unevenness", [0.0, 0.1])
def test_the_glow_of_a_light_is_dimmed_below_two_thresholds(unevenness):
    sun = np.array([1, 0.5, 0.3]) / np.linalg.norm([1, 0.5, 0.3])
    angle = np.degrees(np.arccos(np.clip(kernels.pixel_directions(256, 512) @ sun, -1, 1)))
    # A bright cloud: its luminance does not fall, so the rings of glare end before it does.
    noise = np.random.default_rng(5).uniform(1 - unevenness, 1 + unevenness, angle.shape)
    sky = SKY * np.where(angle < 9, 8 * noise, 1)[..., None]
    disc = world([Disc(sun, 1.0, (9e4, 8e4, 7e4))], 256, (0, 0, 0)).radiance
    sunny = (sky + disc).astype(np.float32)
    lights, rest = el.split(sunny)
    assert len(lights) == 1
    assert (sunny @ LUMINANCE)[angle < 8].min() > 2 * lights.report.threshold
    assert (rest.radiance @ LUMINANCE).max() < 2 * lights.report.threshold
    np.testing.assert_array_equal(rest.radiance[angle > 10], sunny[angle > 10])


def sun_in_a_haze(sun, centre):
    """A sun before a haze, 5 times the sky, that fades from 1 to 17 degrees around a centre."""
    angle = np.degrees(np.arccos(np.clip(kernels.pixel_directions(256, 512) @ centre, -1, 1)))
    # A light ends in an even top where it was clipped; no haze does.
    uneven = np.random.default_rng(5).uniform(0.9, 1.1, angle.shape)
    share = np.clip((17 - angle) / 16, 0, 1)
    sky = SKY * (1 + (5 * uneven - 1) * share)[..., None]
    disc = world([Disc(sun, 1.0, (2000, 2000, 2000))], 256, (0, 0, 0)).radiance
    return (sky + disc).astype(np.float32)


def test_only_the_excess_of_a_haze_is_removed_with_the_light():
    up, sun = np.array([0.2, 1, 0]), np.array([1, 0.05, 0.3])
    sun /= np.linalg.norm(sun)
    centre = sun + 0.12 * up
    sunny = sun_in_a_haze(sun, centre / np.linalg.norm(centre))
    lights, rest = el.split(sunny)
    assert len(lights) == 1
    assert len(el.detect(rest)) == 0
    assert closure(el.EnvMap(sunny), lights, rest).max() < 1e-6
    # All of the haze would turn the light twice as far.
    assert np.degrees(np.arccos(lights.direction[0] @ sun)) < 0.5
    all_of_it = (sunny - SKY) @ LUMINANCE * kernels.pixel_solid_angles(256, 512)
    away = np.tensordot(all_of_it, kernels.pixel_directions(256, 512), axes=2)
    turned = np.arccos(lights.direction[0] @ sun)
    assert turned < 0.5 * np.arccos(away @ sun / np.linalg.norm(away))
    # Of y thresholds there remain 2 - 1/4 / (y - 1), in the colours of before.
    cosine = kernels.pixel_directions(256, 512) @ sun
    seen = (cosine < np.cos(np.deg2rad(4))) & (rest.radiance < sunny).any(axis=2)
    before, after = (radiance[seen] for radiance in (sunny, rest.radiance))
    bright = before @ LUMINANCE / lights.report.threshold
    expected = (2 - 0.25 / (bright - 1)) / bright
    assert seen.sum() > 300
    np.testing.assert_allclose(after, before * expected[:, None], rtol=1e-5)


# Exact energy


@settings(max_examples=20)
@given(
    st.lists(
        st.tuples(
            st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1),
            st.floats(1, 12),
            st.tuples(*[st.floats(2, 500)] * 3),
        ),
        min_size=1,
        max_size=4,
    ),
    st.integers(0, 2**31),
    st.sampled_from(["cell-centred", "border-sampled"]),
)
def test_energy_is_kept_in_each_channel(lamps, seed, registration):
    shapes = [Disc(direction, radius, rgb) for direction, radius, rgb in lamps]
    try:
        clean = scene(64, background=SKY, shapes=shapes).radiance
    except el.EnvLightsError as refusal:
        if "adds no light" not in str(refusal):
            raise
        reject()  # one lamp hides another
    noise = np.random.default_rng(seed).uniform(0.7, 1.3, clean.shape)
    env = el.EnvMap(
        (clean * noise).astype(np.float32), layout=el.io.Layout(registration=registration)
    )
    lights, rest = el.split(env)
    assert rest.registration == registration
    assert (rest.radiance >= 0).all()
    assert closure(env, lights, rest).max(initial=0.0) < 1e-6
    assert left_over(env, lights, rest).max() < 1e-6
    # Along the direction, the irradiance is all of the vector; the luminance has none across.
    along = np.einsum("lca,la->lc", lights.vector_irradiance, lights.direction)
    np.testing.assert_allclose(lights.irradiance, np.maximum(along, 0), rtol=1e-9, atol=1e-12)
    luminance = np.einsum("lca,c->la", lights.vector_irradiance, LUMINANCE)
    size = np.linalg.norm(luminance, axis=1, keepdims=True)
    np.testing.assert_allclose(
        luminance, size * lights.direction, rtol=0, atol=1e-9 * size.max(initial=1)
    )


@pytest.mark.parametrize("turn", [1, 64, 100, 255])
def test_a_turned_map_has_turned_lights_and_rest(turn):
    shapes = [Disc(place, 3.0, (40, 50, 60)) for place in PLACES[1::2]]
    slope = 1 + 0.5 * kernels.pixel_directions(128, 256)[..., :1]
    env = (world(shapes).radiance * slope).astype(np.float32)
    there, back = el.split(np.roll(env, turn, axis=1)), el.split(env)
    np.testing.assert_allclose(
        np.roll(there.remainder.radiance, -turn, axis=1), back.remainder.radiance, rtol=2e-3
    )
    np.testing.assert_allclose(there.lights.irradiance, back.lights.irradiance, rtol=1e-4)


def test_a_map_upside_down_has_the_same_rest_upside_down():
    env = world([Disc((0.05, 1, 0.02), 6.0, (40, 50, 60))]).radiance
    np.testing.assert_array_equal(
        el.split(env[::-1]).remainder.radiance, el.split(env).remainder.radiance[::-1]
    )


def test_a_red_lamp_on_a_white_wall_removes_no_blue():
    lamp = world([Disc((1, 0.2, 0), 5.0, (1, 1, 1))], background=(0, 0, 0)).radiance
    env = el.EnvMap((1 + lamp * (89, -0.9, -0.95)).astype(np.float32))
    lights, rest = el.split(env)
    assert len(lights) == 1
    assert lights.irradiance[0, 0] > 0.5
    np.testing.assert_array_equal(lights.irradiance[0, 1:], 0)
    np.testing.assert_array_less(-1e-9, env.radiance - rest.radiance)


def halves(upper, lower):
    """A lamp of two colours."""
    places = {(1, 0.07, 0): upper, (1, -0.07, 0): lower}
    return [Rectangle(place, 8, 8, colour) for place, colour in places.items()]


def test_a_lamp_of_two_colours_reports_its_uneven_colour():
    env = world(halves((90, 10, 10), (10, 10, 90)))
    lights, rest = el.split(env)
    assert len(lights) == 1
    assert lights.off_axis.max() > 0.01
    assert "uneven colour" in str(lights)
    assert closure(env, lights, rest).max() < 1e-6
    np.testing.assert_allclose(rest.radiance, np.broadcast_to(SKY, rest.radiance.shape), rtol=1e-6)


# Removed lights


def test_pictures_that_end_at_white_keep_their_white():
    codes = np.full((64, 128, 3), 60, np.uint8)
    codes[20:24, 40:48] = 255
    lights, rest = el.split(codes)
    assert len(lights) == 1
    assert rest.clip_level == 1.0
    assert "decoded from sRGB" in rest.notes[0]
    assert "1 light with" in rest.notes[1]
    np.testing.assert_allclose(rest.radiance, el.EnvMap(codes).radiance[0, 0, 0], rtol=1e-6)


@pytest.mark.parametrize("value", [0.0, 1.0])
def test_a_map_without_lights_stays(value):
    env = np.full((16, 32, 3), value, np.float32)
    lights, rest = el.split(env)
    assert len(lights) == 0
    assert rest.notes == ()
    np.testing.assert_array_equal(rest.radiance, env)
    assert el.splitting.RemovedLights is type(lights)


def test_removed_lights_are_discs_with_their_irradiance():
    env = three()
    lights, rest = el.split(env)
    np.testing.assert_array_equal(lights.discs().irradiance, lights.irradiance)
    sky = el.fit(rest, lights=0)
    rig = el.Rig(sky.ambient, lights.discs(), error=0.0)
    np.testing.assert_allclose(rig.probe(NORMALS), env.probe(NORMALS), rtol=2e-3)
    np.testing.assert_allclose(
        lights.to_map(128).probe(NORMALS) + rest.probe(NORMALS), env.probe(NORMALS), rtol=2e-3
    )
    assert lights[:1].vector_irradiance.shape == (1, 3, 3)
    assert len(lights.to_dict()["reach"]) == 3


# Maps


def test_a_split_prints_its_lights_and_the_rest():
    parts = el.split(world([Disc((0, 0, 1), 5.0, (9, 9, 9))]))
    assert str(parts) == f"{parts.lights}\n\nthe map without these lights: {parts.remainder}"
    assert "<RemovedLights" not in str(parts)


def test_a_large_map_is_split_by_its_own_pixels():
    shapes = [Disc((0, 0.3, -1), 0.6, (9e4, 8e4, 7e4)), PixelSun((0.2, 0.1, 1), (900, 800, 700))]
    env = world(shapes, height=1024)
    lights, rest = el.split(env, working_width=256)
    assert len(lights) == 2
    assert closure(env, lights, rest).max() < 1e-6
    np.testing.assert_allclose(rest.radiance, np.broadcast_to(SKY, rest.radiance.shape), rtol=1e-6)
    # Each light is known again by the brightest of its own pixels; a block has 64.
    found = el.detect(env, working_width=256)
    np.testing.assert_array_equal(
        el.split(env, found).lights.irradiance,
        el.split(env, working_width=256).lights.irradiance,
    )


def test_any_number_of_threads_gives_the_same_bits():
    code = """
import hashlib, numpy as np, envlights as el
noise = np.random.default_rng(3).uniform(0.5, 1, (256, 512, 3)).astype(np.float32)
lamp = el.synthetic.Disc((0, 1, 0.1), 20.0, (90, 80, 70))
env = el.synthetic.scene(256, background=[0.1] * 3, shapes=[lamp]).radiance * noise
lights, rest = el.split(env)
print(hashlib.sha256(rest.radiance.tobytes() + lights.irradiance.tobytes()).hexdigest())
"""
    assert len(printed_by_threads(code)) == 1


@real_maps("hdr/*.hdr", "exr/*.exr", "openexr_envmaps/*LatLong.exr", "ldr/*.png")
def test_real_maps_close(path):
    env = el.EnvMap.open(path)
    lights, rest = el.split(env)
    assert rest.radiance.shape == env.radiance.shape
    assert (rest.radiance >= 0).all()
    assert closure(env, lights, rest).max(initial=0.0) < 1e-6
    assert left_over(env, lights, rest).max() < 1e-6
