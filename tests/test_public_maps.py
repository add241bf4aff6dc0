"""Detector, probe, fit, split and transfer on real files, against sums that are written out.

The files are read by another library, and nothing is shared with the package: a map that is
mirrored, upside down or seven times as bright is noticed.
"""

import numpy as np
import pytest

import envlights as el
from tests.helpers import angle_deg
from tests.public_maps import LUMINANCE, directions, public_maps, quadrature, read, solid_angles

#: Six axes and six oblique normals, none symmetric to another.
NORMALS = np.concatenate([np.eye(3), -np.eye(3), np.random.default_rng(7).normal(size=(6, 3))])
NORMALS /= np.linalg.norm(NORMALS, axis=1, keepdims=True)


def brightest_blob(radiance):
    """Direction and flux of the pixels around the brightest one that reach half of it."""
    ndimage = pytest.importorskip("scipy.ndimage")
    luminance = radiance @ LUMINANCE
    labels, _ = ndimage.label(luminance >= luminance.max() / 2)
    blob = labels == labels[np.unravel_index(luminance.argmax(), luminance.shape)]
    flux = (luminance * solid_angles(*luminance.shape))[blob]
    centre = flux @ directions(*luminance.shape)[blob]
    return centre / np.linalg.norm(centre), flux.sum()


# The brightest pixels of "courtyard" are a glint with a twentieth of a percent of its flux.
@public_maps("city", "forest", "interior", "night", "studio", "sunrise", "sunset")
def test_a_light_is_at_the_brightest_place_with_its_flux(path):
    centre, flux = brightest_blob(read(path))
    lights = el.detect(el.EnvMap.open(path))
    apart = angle_deg(lights.direction, centre)
    nearest = apart.argmin()
    # The softbox of "studio" is 12 degrees wide, and its brightest half is not in its middle.
    assert apart[nearest] < (1.0 if "studio" in path.name else 0.2)
    assert 0.99 * flux < lights.irradiance[nearest] @ LUMINANCE < 2 * flux


@public_maps()
def test_the_probe_is_the_sum_over_the_pixels(path):
    """The sum takes the cosine at the centres of quarter pixels: 2e-5 off."""
    expected = quadrature(read(path), NORMALS, finer=2)
    probe = el.EnvMap.open(path).probe(NORMALS)
    np.testing.assert_allclose(probe, expected, rtol=2e-4)


@public_maps()
def test_the_error_of_a_fit_is_what_a_sum_over_the_pixels_says(path):
    normals = np.random.default_rng(3).normal(size=(60, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    truth = quadrature(read(path), normals)
    rig = el.fit(el.EnvMap.open(path), lights=4)
    error = np.linalg.norm(rig.probe(normals) - truth) / np.linalg.norm(truth)
    assert rig.error / 2 < error < 2 * rig.error + 2e-4
    assert rig.error < 0.05


def vector_irradiance(radiance):
    """Integral of luminance times direction."""
    luminance = radiance @ LUMINANCE
    light = luminance * solid_angles(*luminance.shape)
    return np.einsum("ijk,ij->k", directions(*luminance.shape), light)


@public_maps()
def test_lights_and_remainder_of_a_split_have_the_vector_irradiance_of_the_map(path):
    radiance = read(path).clip(0)
    lights, rest = el.split(el.EnvMap.open(path))
    taken = lights.direction.T @ lights.irradiance @ LUMINANCE
    parts = vector_irradiance(rest.radiance.astype(float)) + taken
    expected = vector_irradiance(radiance)
    assert np.linalg.norm(parts - expected) < 1e-4 * np.linalg.norm(expected)


@public_maps()
def test_a_split_changes_a_part_of_the_map(path):
    env = el.EnvMap.open(path)
    _, rest = el.split(env)
    changed = (rest.radiance != env.radiance).any(axis=2)
    assert 0 < (changed * solid_angles(*changed.shape)).sum() / (4 * np.pi) < 0.2


@public_maps("city")
def test_transfer_learns_the_irradiance_of_turned_maps(path):
    """Direct images are the map, turned and small; indirect ones are its irradiance."""
    env = el.EnvMap.open(path).resized(64)
    normals = directions(4, 8).reshape(-1, 3)
    rng = np.random.default_rng(5)
    direct, indirect = [], []
    for _ in range(70):
        turned = env.rotated(rotation(rng)).resized(16)
        direct.append(turned.radiance)
        indirect.append(quadrature(turned.radiance.astype(float), normals).reshape(4, 8, 3))
    direct, indirect = np.stack(direct), np.stack(indirect).astype(np.float32)
    model = el.TransferModel.fit(direct[:60], indirect[:60], rank=32, ridge="loo")
    error = model.predict(direct[60:]) - indirect[60:]
    assert np.linalg.norm(error) < 0.1 * np.linalg.norm(indirect[60:])


def rotation(rng):
    """Random rotation from the QR factors of Gaussian numbers."""
    turn, upper = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.sign(np.diag(upper))
    return turn if np.linalg.det(turn) > 0 else -turn
