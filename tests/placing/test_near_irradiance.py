"""The kernel of lights with positions, against sums over parts and closed forms."""

import numpy as np
import pytest

from envlights import _native, kernels
from tests.placing.rooms import WHITE, Ball, Panel

NORMALS, _ = kernels.icosphere(320)
NO_SPHERES, NO_CARDS, NO_PATCHES = (np.zeros((0, size)) for size in (7, 13, 10))
#: Points before a panel at y = 1.4, beside it, and behind its plane.
POINTS = np.array([[0.0, 0, 0], [0.9, 1.1, -0.4], [-2.0, -1.0, 1.0], [0.2, 1.9, 0.1]])


def panel(is_disc):
    return Panel((0.5, 1.4, -0.3), (0.6, 0, 0.1), (-0.05, 0, 0.3), 7 * WHITE, is_disc)


def row_of(lamp):
    """Row of the kernel: U to the right and V down from the origin, and its irradiance there."""
    u, v = 2 * np.array(lamp.u), 2 * np.array(lamp.v)
    corner = np.array(lamp.centre) - (u + v) / 2
    if np.linalg.det([u, v, corner]) < 0:
        u, v = v, u
    towards = np.array(lamp.centre) / np.linalg.norm(lamp.centre)
    return [*u, *v, *corner, lamp.is_disc, *lamp.probe(np.zeros(3), towards[None])[0]]


@pytest.mark.parametrize(("is_disc", "tolerance"), [(False, 2e-4), (True, 2e-3)])
def test_the_horizon_cuts_a_panel_as_a_sum_over_parts_does(is_disc, tolerance):
    lamp = panel(is_disc)
    seen = _native.near_irradiance(
        POINTS, NORMALS, NO_SPHERES, np.array([row_of(lamp)]), NO_PATCHES
    )
    for received, point in zip(seen, POINTS, strict=True):
        wanted = lamp.probe(point, NORMALS)
        np.testing.assert_allclose(received, wanted, atol=tolerance * max(wanted.max(), 1e-9))
    assert not seen[3].any(), "nothing shines behind the panel"


def test_a_facing_square_has_the_form_factor_of_the_tables():
    lamp = Panel((0, 2, 0), (1, 0, 0), (0, 0, 1), WHITE)
    (seen,) = _native.near_irradiance(
        np.zeros((1, 3)), np.array([[0.0, 1, 0]]), NO_SPHERES, np.array([row_of(lamp)]), NO_PATCHES
    )
    # Howell, configuration C-1, four times.
    x = 0.5 / np.hypot(1, 0.5)
    unit = 4 * x * np.arctan(x)
    np.testing.assert_allclose(lamp.probe(np.zeros(3), np.array([[0.0, 1, 0]])), [[unit] * 3], 1e-4)
    np.testing.assert_allclose(seen, [[unit] * 3], rtol=1e-4)


def test_a_sphere_is_a_disc_whose_irradiance_falls_with_the_square():
    ball = Ball((1.0, 0.5, -2.0), 0.4, 3 * WHITE)
    centre = np.array(ball.centre)
    home = np.pi * 3 * 0.16 / (centre @ centre)
    row = np.array([[*ball.centre, 0.4, home, home, home]])
    points = np.array([[0.0, 0, 0], [1.0, 1.4, -2.0]])
    seen = _native.near_irradiance(points, NORMALS, row, NO_CARDS, NO_PATCHES)
    for received, point in zip(seen, points, strict=True):
        np.testing.assert_allclose(received, ball.probe(point, NORMALS), rtol=1e-12, atol=1e-15)


def test_a_patch_is_a_small_disc_and_dark_from_behind():
    radius = 0.05
    patch = np.array([[0, 2.0, 0, 0, -1, 0, np.pi * radius**2, 1, 2, 3]])
    points = np.array([[0.0, 0, 0], [0.0, 3.0, 0]])
    up = np.array([[0.0, 1, 0], [0.0, -1, 0]])
    near, behind = _native.near_irradiance(points, up, NO_SPHERES, NO_CARDS, patch)
    disc = np.pi * radius**2 / (4 + radius**2)
    np.testing.assert_allclose(near, [disc * np.array([1, 2, 3]), [0, 0, 0]], rtol=1e-12)
    assert not behind.any()
