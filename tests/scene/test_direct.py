"""Direct light on surfaces: closed forms, independent computations, refusals."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import envlights as el
from envlights import kernels
from envlights.scene.sky import sky_transfer
from envlights.scene.surface import tangent_frames

UP = np.array([0.0, 1.0, 0.0])
DARK = np.zeros(3)


def surface(positions, normals, albedo=0.5):
    """One row of texels."""
    positions, normals = np.atleast_2d(positions), np.atleast_2d(normals)
    shape = (1, max(len(positions), len(normals)), 3)
    maps = [np.broadcast_to(each, shape) for each in (positions, normals, albedo)]
    return el.scene.Surface(*maps)


def nothing(origins, directions):
    """Nothing in the way."""
    return np.zeros(len(origins), np.bool_)


def wall(height, distance=1.0):
    """An endless wall in front of x = `distance`, so high."""

    def is_blocked(origins, directions):
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (distance - origins[:, 0]) / directions[:, 0]
            y = origins[:, 1] + t * directions[:, 1]
        return (t > 0) & (y > 0) & (y < height)

    return is_blocked


def rig(ambient=DARK, *lights):
    directions = np.reshape([direction for direction, _ in lights], (-1, 3))
    irradiance = np.reshape([irradiance for _, irradiance in lights], (-1, 3))
    return el.Rig(ambient, el.Lights(directions, irradiance), error=0.0)


def towards(elevation_deg, azimuth_deg=0.0):
    """From +x, `azimuth_deg` towards +z."""
    e, a = np.deg2rad([elevation_deg, azimuth_deg])
    return np.array([np.cos(e) * np.cos(a), np.sin(e), np.cos(e) * np.sin(a)])


@pytest.mark.parametrize("elevation", [90, 50, 5, -20])
def test_an_open_floor_under_a_light_gets_its_cosine(elevation):
    floor = surface([[0, 0, 0], [3, 0, 1]], UP, [0.2, 0.5, 0.9])
    image = el.scene.DirectLight.of(floor, nothing).image(
        rig(DARK, (towards(elevation), [1, 2, 3]))
    )
    cosine = max(np.sin(np.deg2rad(elevation)), 0)
    wanted = np.array([0.2, 0.5, 0.9]) / np.pi * [1, 2, 3] * cosine
    np.testing.assert_allclose(image[0], [wanted, wanted], rtol=1e-12, atol=1e-12)


def test_an_open_surface_reflects_its_albedo_of_a_constant_sky():
    normals = kernels.icosphere(20)[0]
    image = el.scene.DirectLight.of(surface(DARK, normals, 0.3), nothing).image(rig([1, 2, 4]))
    np.testing.assert_allclose(image[0], np.tile([0.3, 0.6, 1.2], (20, 1)), rtol=1e-12)


def test_an_open_surface_is_a_probe():
    """Any ambient term, any lights: without obstacles it is the fit's own model."""
    normals = kernels.icosphere(80)[0]
    ball = el.scene.DirectLight.of(surface(DARK, normals, np.pi), nothing)
    for each in el.synthetic.rigs(5):
        np.testing.assert_allclose(ball.image(each)[0], each.probe(normals), rtol=1e-12)


def discs(radii, seed=0):
    """A rig of lights with these radii in degrees, anywhere."""
    rng = np.random.default_rng(seed)
    at = kernels.uniform_sphere(rng.random((len(radii), 2)))
    return el.Rig(DARK, el.Lights(at, rng.random((len(radii), 3)), np.deg2rad(radii)), error=0.0)


def test_discs_on_an_open_surface_have_no_noise():
    """They are the probe in closed form, whatever part of a disc the horizon cuts."""
    normals = kernels.icosphere(320)[0]
    ball = el.scene.DirectLight.of(surface(DARK, normals, np.pi), nothing)
    rig = discs([0, 0.3, 5, 30, 60, 90])
    np.testing.assert_allclose(ball.image(rig)[0], rig.probe(normals), rtol=1e-12)


def test_the_part_of_a_disc_behind_a_wall_is_a_map_painted_black():
    height = 512
    flat = kernels.pixel_directions(height, 2 * height).reshape(-1, 3)
    behind = wall(2.0)(np.zeros_like(flat), flat).reshape(height, -1, 1)
    normals = np.array([UP, [0.6, 0.8, 0], [0, 0.8, 0.6], [0.48, 0.6, -0.64]])
    light = el.scene.DirectLight.of(surface(DARK, normals, np.pi), wall(2.0), 1)
    light = replace(light, rays=4096)
    for radius in (3, 10, 30, 60):
        for elevation in (55, 63.4, 75):
            lamp = el.Lights([towards(elevation, 20)], [[1, 2, 3]], [np.deg2rad(radius)])
            painted = np.where(behind, np.float32(0), lamp.to_map(height).radiance)
            truth = el.EnvMap(painted).probe(normals)
            np.testing.assert_allclose(light.image(lamp)[0], truth, rtol=0.02, atol=0.02)


def test_shadows_of_a_disc_are_black_inside_and_end_where_its_rim_does():
    """Below the rim's lowest ray all is black, above its highest all is lit, between it grows."""
    x = np.linspace(-8, 0.99, 900)
    floor = surface(np.stack([x, 0 * x, 0 * x], axis=1), UP, np.pi)
    lamp = el.Lights([towards(45)], [[1, 1, 1]], [np.deg2rad(10)])
    share = el.scene.DirectLight.of(floor, wall(2.0)).image(lamp)[0, :, 0] / np.sin(np.deg2rad(45))
    rises = np.rad2deg(np.arctan2(2.0, 1 - x))  # to the top of the wall
    np.testing.assert_array_equal(share[rises > 55.1], 0)
    np.testing.assert_allclose(share[rises < 34.9], 1, rtol=1e-12)
    between = share[(rises > 40) & (rises < 50)]
    assert ((between > 0) & (between < 1)).all()
    # Means over 15 neighbours have 240 rays.
    assert (np.diff(between[: len(between) // 15 * 15].reshape(-1, 15).mean(axis=1)) < 0.01).all()


def test_detected_lights_light_as_the_discs_that_they_are():
    found = el.detect(el.synthetic.hall(128).radiance)
    floor = surface(DARK, UP)
    one, other = (
        el.scene.DirectLight.of(floor, nothing).image(each) for each in (found, found.discs())
    )
    np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("elevation", [20, 45, 70])
def test_a_wall_casts_a_shadow_of_its_own_length(elevation):
    x = np.linspace(-4, 0.99, 400)
    floor = surface(np.stack([x, 0 * x, 0 * x], axis=1), UP, np.pi)
    image = el.scene.DirectLight.of(floor, wall(2.0)).image(
        rig(DARK, (towards(elevation), [1, 1, 1]))
    )
    shadow = 2.0 / np.tan(np.deg2rad(elevation))
    # The floor is sampled a hair above itself.
    certain = np.abs(1 - x - shadow) > 0.01
    lit = np.where(1 - x > shadow, np.sin(np.deg2rad(elevation)), 0)
    np.testing.assert_allclose(image[0, certain, 0], lit[certain], atol=1e-12)


@pytest.mark.parametrize("distance", [0.2, 1.0, 5.0])
def test_an_endless_wall_hides_its_form_factor_of_the_sky(distance):
    floor = surface([1 - distance, 0, 0], UP, np.pi)
    image = el.scene.DirectLight.of(floor, wall(2.0), 4096).image(rig([1, 1, 1]))
    hidden = (1 - distance / np.hypot(distance, 2.0)) / 2
    # n points of low discrepancy count what is behind an outline to about n^(-3/4).
    np.testing.assert_allclose(image[0, 0] / np.pi, 1 - hidden, atol=4096**-0.75)


def test_what_a_texel_sees_of_the_sky_is_a_map_with_the_wall_painted_black():
    height = 256
    directions = kernels.pixel_directions(height, 2 * height)
    flat = directions.reshape(-1, 3)
    behind = wall(2.0)(np.zeros_like(flat), flat).reshape(height, -1)
    normals = np.array([UP, [0.6, 0.8, 0], [-1, 0, 0], [0.48, 0.6, -0.64]])
    here = el.scene.DirectLight.of(surface(DARK, normals, np.pi), wall(2.0), 4096)
    for each in el.synthetic.rigs(3):
        radiance = (kernels.harmonic_radiance(flat) @ each.ambient).reshape(height, -1, 3)
        sky = np.where(behind[..., None], 0, np.maximum(radiance, 0))
        image = here.image(rig(each.ambient))[0]
        truth = el.EnvMap(sky.astype(np.float32)).probe(normals)
        # A pixel is 0.7 degrees wide, and the outline of the wall crosses some hundred of them.
        np.testing.assert_allclose(image, truth, rtol=5e-3)


def test_few_rays_are_right_on_the_mean():
    x = np.linspace(-2, 0.9, 256)
    floor = surface(np.stack([x, 0 * x, 0 * x], axis=1), UP)
    few, many = (sky_transfer(floor, wall(2.0), n).mean(axis=0) for n in (16, 4096))
    np.testing.assert_allclose(few, many, atol=5e-3 * np.abs(many).max())


@given(st.integers(0, 1000), st.floats(0.1, 10), st.floats(0.1, 10))
def test_light_adds_up(seed, a, b):
    one, two = el.synthetic.rigs(2, seed)
    both = rig(
        a * one.ambient + b * two.ambient,
        *zip(one.lights.direction, a * one.lights.irradiance, strict=True),
        *zip(two.lights.direction, b * two.lights.irradiance, strict=True),
    )
    x = np.linspace(-4, 0.9, 20)
    light = el.scene.DirectLight.of(surface(np.stack([x, 0 * x, 0 * x], axis=1), UP), wall(2.0), 16)
    apart = a * light.image(one) + b * light.image(two)
    np.testing.assert_allclose(light.image(both), apart, rtol=1e-9, atol=1e-12)


def test_a_ray_tracer_may_answer_with_numbers_and_nothing_else():
    place = surface([[0, 0, 0], [3, 0, 1]], UP)
    light = rig(DARK, (UP, [1, 1, 1]))

    def image_for(answer):
        return el.scene.DirectLight.of(place, answer, 8).image(light)

    as_flags = image_for(lambda origins, _: origins[:, 0] > 1)
    as_numbers = image_for(lambda origins, _: (origins[:, 0] > 1).astype(np.uint8))
    np.testing.assert_array_equal(as_numbers, as_flags)
    np.testing.assert_array_equal(as_flags.any(axis=-1), [[True, False]])
    for answer in (lambda o, _: 2 * np.ones(len(o), int), lambda o, _: [True], lambda *_: None):
        with pytest.raises(el.EnvLightsError, match="blocked must return true or false"):
            image_for(answer)


def test_only_what_faces_a_light_is_asked_for_shadows():
    asked = []

    def is_blocked(origins, directions):
        asked.append(len(origins))
        return nothing(origins, directions)

    normals = np.array([UP, -UP, [1, 0, 0]])
    light = el.scene.DirectLight.of(surface(DARK, normals), is_blocked, 8)
    light.image(rig(DARK, (UP, [1, 1, 1])))
    assert asked == [3 * 8, 1]


@given(st.integers(0, 2**32 - 1))
def test_frames_are_right_handed_and_unit(seed):
    normal = np.random.default_rng(seed).normal(size=(9, 3))
    normal[:3] = [[0, 0, 1], [0, 0, -1], [0, -0.0, -1]]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    found = tangent_frames(normal)
    identity = np.tile(np.eye(3), (9, 1, 1))
    np.testing.assert_allclose(found @ found.swapaxes(1, 2), identity, atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(found), 1)
    np.testing.assert_array_equal(found[:, 2], normal)


def test_means_are_of_the_texels_that_are_there():
    normals = np.tile(UP, (4, 4, 1))
    normals[:2, :2] = 0
    normals[0, 3] = 0
    patch = el.scene.Surface(np.zeros((4, 4, 3)), normals, np.ones((4, 4, 3)))
    values = np.arange(16.0).reshape(4, 4, 1).repeat(3, axis=2)
    np.testing.assert_allclose(patch.means(values, 2)[..., 0], [[0, (2 + 6 + 7) / 3], [10.5, 12.5]])
    image = el.scene.DirectLight.of(patch, nothing).image(rig([1, 1, 1]))
    np.testing.assert_allclose(image[..., 0], normals[..., 1], rtol=1e-12)


def maps(**changes):
    arrays = {
        "position": np.zeros((2, 4, 3)),
        "normal": np.tile(UP, (2, 4, 1)),
        "albedo": np.full((2, 4, 3), 0.5),
    }
    for name, (where, value) in changes.items():
        arrays[name][where] = value
    return arrays


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (maps(position=((1, 2, 0), np.nan)), r"position must be finite; row 1, column 2 holds nan"),
        (maps(normal=((0, 1), [0, 2, 0])), r"at row 0, column 1 has 2"),
        (maps(normal=(..., 0)), r"normal is zero in every texel; the surface is empty"),
        (maps(albedo=((0, 0, 0), -0.5)), r"albedo must not be negative; got -0.5"),
        ({**maps(), "normal": np.zeros((2, 3, 3))}, r"normal must have the shape of position"),
        ({**maps(), "albedo": np.zeros((2, 4))}, r"albedo must have 3 axes"),
        ({**maps(), "albedo": np.zeros((2, 4, 4))}, r"shape \(height, width, 3\); got \(2, 4, 4\)"),
    ],
)
def test_impossible_surfaces_are_refused(given, message):
    with pytest.raises(el.EnvLightsError, match=message):
        el.scene.Surface(**given)


def test_rigs_of_the_open_air_come_from_above_and_from_their_seed():
    once, again, other = el.synthetic.rigs(20), el.synthetic.rigs(20), el.synthetic.rigs(1, seed=1)
    for one, two in zip(once, again, strict=True):
        np.testing.assert_array_equal(one.ambient, two.ambient)
        np.testing.assert_array_equal(one.lights.direction, two.lights.direction)
        assert (one.lights.direction[:, 1] > 0).all()
        assert (kernels.harmonic_radiance(kernels.icosphere(1280)[0]) @ one.ambient > -1e-12).all()
    assert not np.array_equal(once[0].ambient, other[0].ambient)


def test_without_mitsuba_the_way_to_it_is_told(monkeypatch):
    monkeypatch.setitem(sys.modules, "mitsuba", None)
    with pytest.raises(el.EnvLightsError, match=r"pip install 'envlights\[bake\]'"):
        el.synthetic.courtyard()
    with pytest.raises(el.EnvLightsError, match=r"Mitsuba cannot be imported: .*mitsuba"):
        el.scene.MitsubaScene({"type": "scene"})
