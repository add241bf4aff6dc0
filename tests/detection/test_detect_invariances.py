"""Detection under other exposures, rotations, mirrors and numbers of threads."""

import hashlib

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from envlights.synthetic import suite
from tests.conftest import real_maps
from tests.detection.worlds import family
from tests.helpers import angle_deg, printed_by_threads


def some_worlds():
    return [*family("plain")[1:4], *family("hard")[1:4]]


def assert_same_lights(lights, others, turn=lambda d: d):
    assert len(lights) == len(others)
    wanted = turn(others.direction)
    for direction, irradiance in zip(lights.direction, lights.flux, strict=True):
        angles = angle_deg(wanted, direction)
        assert angles.min() < 1e-3
        flux = others.flux[angles.argmin()]
        # Sums in f32 of turned pixels differ in the last places.
        np.testing.assert_allclose(irradiance, flux, rtol=1e-4)


def turned_by(columns, width):
    """Return what turns directions as a map does that is rolled by some columns."""
    azimuth = 2 * np.pi * columns / width
    cos, sin = np.cos(azimuth), np.sin(azimuth)
    # phi runs from -z over +x: turning adds to it.
    rotation = np.array([[cos, 0, -sin], [0, 1, 0], [sin, 0, cos]])
    return lambda directions: directions @ rotation.T


@pytest.mark.parametrize("which", range(6))
@pytest.mark.parametrize("factor", [1e-6, 1e6])
@pytest.mark.parametrize("registration", ["cell-centred", "border-sampled"])
def test_exposure_changes_nothing_but_radiance(which, factor, registration):
    radiance = some_worlds()[which].radiance.astype(np.float64)

    def detect(values):
        return el.detect(
            el.EnvMap(values.astype(np.float32), layout=el.io.Layout(registration=registration))
        )

    lights, scaled = detect(radiance), detect(factor * radiance)
    assert len(scaled) == len(lights)
    assert angle_deg(scaled.direction, lights.direction).max(initial=0) < 1e-3
    np.testing.assert_allclose(scaled.flux, factor * lights.flux, rtol=1e-5)
    assert scaled.report.threshold == pytest.approx(factor * lights.report.threshold, rel=1e-4)


@pytest.mark.parametrize("which", range(6))
@pytest.mark.parametrize("columns", [1, 333, 512])
def test_a_turned_map_has_turned_lights(which, columns):
    radiance = some_worlds()[which].radiance
    turned = el.detect(np.ascontiguousarray(np.roll(radiance, columns, axis=1)))
    turn = turned_by(columns, radiance.shape[1])
    assert_same_lights(turned, el.detect(radiance), turn)


@pytest.mark.parametrize("which", range(6))
def test_a_mirrored_map_has_mirrored_lights(which):
    radiance = some_worlds()[which].radiance
    mirrored = el.detect(np.ascontiguousarray(radiance[:, ::-1]))
    assert_same_lights(mirrored, el.detect(radiance), lambda d: d * (-1, 1, 1))
    upside_down = el.detect(np.ascontiguousarray(radiance[::-1]))
    assert_same_lights(upside_down, el.detect(radiance), lambda d: d * (1, -1, 1))


@real_maps("hdr/*.hdr", "exr/*.exr")
@pytest.mark.parametrize("columns", [333, 512])
def test_a_real_map_turned_by_whole_blocks_has_turned_lights(path, columns):
    env = el.EnvMap.open(path)
    # By other numbers of columns a reduced map has other working pixels.
    columns *= -(-env.width // 1024)
    turned = el.detect(np.ascontiguousarray(np.roll(env.radiance, columns, axis=1)))
    assert_same_lights(turned, el.detect(env), turned_by(columns, env.width))


@pytest.mark.parametrize("registration", ["cell-centred", "border-sampled"])
@pytest.mark.parametrize("direction", [(0, 0, -1), (0, 1, 0), (0.01, -1, 0)])
def test_a_light_on_the_seam_or_a_pole_is_one_light_of_the_flux_it_has_elsewhere(
    direction, registration
):
    is_border = registration == "border-sampled"
    towards = kernels.pixel_directions(512, 1024, border_sampled=is_border)
    inside = towards @ (np.array(direction) / np.linalg.norm(direction)) > np.cos(0.1)
    env = el.EnvMap(
        np.where(inside[..., None], 9.0, [0.1] * 3), layout=el.io.Layout(registration=registration)
    )
    lights = el.detect(env)
    solid_angle = kernels.pixel_solid_angles(512, 1024, border_sampled=is_border)[inside].sum()
    np.testing.assert_allclose(lights.flux, np.full((1, 3), 9 * solid_angle), rtol=1e-5)
    np.testing.assert_allclose(lights.solid_angle, [solid_angle], rtol=1e-5)


def test_the_number_of_threads_changes_no_bit():
    code = (
        "import hashlib, envlights as el;"
        "lights = el.detect(el.synthetic.hard(1001).radiance);"
        "print(hashlib.sha256(str(lights.to_dict()).encode()).hexdigest())"
    )
    lights = el.detect(suite.hard(1001).radiance)
    here = hashlib.sha256(str(lights.to_dict()).encode()).hexdigest()
    assert printed_by_threads(code, (1, 2, 7)) == {f"{here}\n"}
