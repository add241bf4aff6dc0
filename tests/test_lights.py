"""Directional lights, and the one order in which everything about them stands."""

from dataclasses import replace

import numpy as np
import pytest

import envlights as el
from envlights.kernels.image import LUMINANCE
from envlights.lights import brightest_first

NORMALS, SOLID_ANGLES = el.kernels.icosphere(320)

#: Two lamps that mirror each other, and colours of equal luminance: rounding decides their order.
LAMPS = np.array([[0.6, 0.64, 0.48], [-0.6, 0.64, 0.48]])
COLOURS = np.array([[0.5, 0.5, 0.1], [0.1, 0.5, 0.5]]) / LUMINANCE


def a_probe_that_fits(weights):
    """The probe under both lamps and ambient light, with a residual that changes no fitted number.

    Beside it the factor of each lamp in its standard error, by which the lamps can be told apart.
    """
    columns = np.column_stack([np.full(len(NORMALS), np.pi), np.maximum(NORMALS @ LAMPS.T, 0)])
    root = np.sqrt(weights)[:, None]
    noise = root * np.random.default_rng(15).normal(scale=0.02, size=(len(NORMALS), 3))
    noise -= root * columns @ np.linalg.lstsq(root * columns, noise, rcond=None)[0]
    probe = el.kernels.rig_irradiance(NORMALS, [0.1] * 3, LAMPS, COLOURS) + noise / root
    covariance = np.linalg.inv((root * columns).T @ (root * columns))
    return probe, np.sqrt(np.diag(covariance)[1:])


def trials(probe, jitter):
    """The probe at 1000 scales, each time rounded a little differently."""
    rng = np.random.default_rng(0)
    for scale in 10 ** rng.uniform(-3, 6, 1000):
        yield scale, scale * probe * (1 + jitter * rng.normal(size=probe.shape))


def test_figures_of_lights_that_rounding_orders_name_the_right_light():
    # Different weights left and right: the lamps have standard errors of their own.
    weights = SOLID_ANGLES * np.where(NORMALS[:, 0] > 0, 1.0, 4.0)
    probe, uncertainty = a_probe_that_fits(weights)
    assert uncertainty[0] > 1.2 * uncertainty[1]
    orders = set()
    for number, (scale, measured) in enumerate(trials(probe, jitter=5e-15)):
        given = [0, 1] if number % 2 else [1, 0]
        rig = el.fit_probe(NORMALS, measured, 2, weights=weights, fixed=LAMPS[given])
        rows = list(rig.report.fixed)
        orders.add(tuple(np.array(given)[rows]))
        np.testing.assert_array_equal(rig.lights.direction[rows], LAMPS[given])
        np.testing.assert_allclose(rig.lights.irradiance[rows], scale * COLOURS[given], rtol=1e-9)
        errors = np.array(rig.report.irradiance_errors)[rows]
        relative = errors / errors.sum(axis=0)
        wanted = (uncertainty / uncertainty.sum())[given]
        np.testing.assert_allclose(relative, np.stack([wanted] * 3, axis=1), rtol=1e-6)
        assert rig.report.direction_errors == (0.0, 0.0)
    assert orders == {(0, 1), (1, 0)}  # rounding did decide


def test_the_fixed_one_of_two_lights_that_are_alike_is_named():
    probe, _ = a_probe_that_fits(SOLID_ANGLES)
    rows = set()
    for number, (_, measured) in enumerate(trials(probe, jitter=3e-3)):
        lamp = LAMPS[[number % 2]]
        rig = el.fit_probe(NORMALS, measured, 2, weights=SOLID_ANGLES, fixed=lamp)
        (row,) = rig.report.fixed
        rows.add(row)
        np.testing.assert_array_equal(rig.lights.direction[[row]], lamp)
        assert rig.report.direction_errors[row] == 0.0 < rig.report.direction_errors[1 - row]
    assert rows == {0, 1}


def test_what_is_in_order_stays_when_it_is_sorted_again():
    rng = np.random.default_rng(2)
    for count in range(2, 40):
        # Equal luminance up to rounding, each row at another place than before.
        share = rng.dirichlet(np.ones(3), size=count)
        irradiance = share / LUMINANCE * 10 ** rng.uniform(-6, 6)
        once = irradiance[brightest_first(irradiance)]
        np.testing.assert_array_equal(brightest_first(once), np.arange(count))
        np.testing.assert_array_equal(
            el.Lights(np.tile([0, 1, 0], (count, 1)), once).irradiance, once
        )


def test_equals_keep_their_order():
    assert brightest_first(np.ones((5, 3))).tolist() == [0, 1, 2, 3, 4]
    assert brightest_first(np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0.0]])).tolist() == [2, 1, 0]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"direction": [[0, 2, 0]]}, "direction 0 has length 2"),
        ({"irradiance": [[1, -1, 1]]}, "not negative"),
        ({"solid_angle": [1, 2]}, r"solid_angle must have a row for each light \(1\); got 2"),
    ],
)
def test_detected_lights_are_checked_as_others_are(change, message):
    lamp = el.synthetic.Disc((1, 0, 0), 5.0, (9, 9, 9))
    world = el.synthetic.scene(64, background=[0.1] * 3, shapes=[lamp])
    lights = el.detect(world.radiance)
    with pytest.raises(el.EnvLightsError, match=message):
        replace(lights, **change)
