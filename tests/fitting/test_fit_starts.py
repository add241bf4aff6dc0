"""Starts of a fit, and lights with fixed directions."""

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from tests.fitting.worst_cases import known_rig
from tests.helpers import NORMALS, SOLID_ANGLES
from tests.reference.peers import even


@pytest.mark.parametrize("start", ["greedy", "detect", "even"])
def test_every_start_gives_lights_none_negative(start):
    rig = el.fit(el.synthetic.hall(256).radiance, lights=4, start=start)
    assert 1 <= len(rig.lights) <= 4
    assert (rig.lights.irradiance >= 0).all()
    assert rig.error < 0.03


def test_named_starts_are_those_places():
    """On a map where they end elsewhere than the search."""
    env = el.EnvMap(el.synthetic.hall(128).radiance)
    places = {"even": even(6), "detect": el.detect(env, max_lights=6).direction}
    searched = el.fit(env, lights=6)
    for start, directions in places.items():
        lights = el.Lights(directions, np.linspace(2, 1, len(directions))[:, None] * [1, 1, 1])
        named, given = el.fit(env, lights=6, start=start), el.fit(env, lights=6, start=lights)
        assert named.to_dict()["lights"] == given.to_dict()["lights"]
        assert named.report.steps == given.report.steps
        assert named.to_dict()["lights"] != searched.to_dict()["lights"]


def test_an_earlier_rig_is_followed():
    """A frame later the sun has moved by a degree: each light stays the one it was."""
    suns = [(0.6, 0.8, 0.0), (-0.5, 0.6, 0.6)]
    turned = [(0.6 * np.cos(0.02), 0.8, 0.6 * np.sin(0.02)), suns[1]]

    def frame(directions):
        discs = [el.synthetic.Disc(d, 3, (90, 80, 70)) for d in directions]
        return el.synthetic.scene(128, background=[0.2] * 3, shapes=discs).radiance

    before = el.fit(frame(suns), lights=2, sizes=False)
    after = el.fit(frame(turned), lights=2, start=before, sizes=False)
    fresh = el.fit(frame(turned), lights=2, sizes=False)
    assert after.error <= fresh.error * (1 + 1e-6)
    # A search reports the steps of the best start alone.
    assert after.report.steps < 10
    moved = np.rad2deg(np.arccos((after.lights.direction * before.lights.direction).sum(axis=1)))
    assert sorted(moved.round(1)) == pytest.approx([0.0, np.rad2deg(0.02) * 0.6], abs=0.3)


def test_a_light_that_starts_where_it_is_black_starts_again():
    two = el.Rig([0.1] * 3, el.Lights([[0, 1, 0], [1, 0, 0]], [[1] * 3, [0.5] * 3]), 0)
    start = el.Rig([0] * 3, el.Lights([[0, 1, 0], [0, -1, 0]], np.ones((2, 3))), 0)
    found = el.fit_probe(NORMALS, two.probe(NORMALS), start=start, weights=SOLID_ANGLES)
    assert found.error < 1e-9
    np.testing.assert_allclose(found.lights.direction, two.lights.direction, atol=1e-9)


# Fixed directions


def test_fixed_lights_stay_and_get_their_radiances():
    rig = known_rig()
    fixed = rig.lights.direction
    found = el.fit_probe(NORMALS, rig.probe(NORMALS), fixed=fixed)
    np.testing.assert_array_equal(found.lights.direction, fixed)
    np.testing.assert_allclose(found.lights.irradiance, rig.lights.irradiance, rtol=1e-9)
    assert found.report.direction_errors == (0.0, 0.0, 0.0)
    away = el.fit_probe(NORMALS, rig.probe(NORMALS), lights=3, fixed=[[0.6, -0.8, 0.0]])
    assert len(away.lights) >= 3
    assert (away.lights.direction == [0.6, -0.8, 0.0]).all(axis=1).any()


@pytest.mark.parametrize("ambient", ["constant", "sh2"])
def test_a_normal_on_the_horizon_of_a_fixed_light_tells_how_bright_it_is(ambient):
    """Each of these normals is on the horizon of one of three lights along the axes."""
    angle = np.linspace(0.1, 6.2, 12)
    ring = np.column_stack([np.zeros(12), np.cos(angle), np.sin(angle)])
    normals = np.concatenate([ring, np.roll(ring, 1, axis=1), np.roll(ring, 2, axis=1)])
    strength = np.array([[3, 2, 1], [1, 2, 3], [1, 1, 1]])
    seen = kernels.rig_irradiance(normals, [0.1, 0.1, 0.1], np.eye(3), strength)
    found = el.fit_probe(normals, seen, fixed=np.eye(3), ambient=ambient)
    np.testing.assert_allclose(found.lights.irradiance, strength, rtol=1e-12)
    assert found.report.condition < 100
    assert np.max(found.report.irradiance_errors) < 1e-12


def test_the_report_says_which_lights_were_fixed():
    """Given with the weakest first, and with one that is found between them."""
    rig = known_rig()
    given = rig.lights.direction[[2, 0]]
    found = el.fit_probe(NORMALS, rig.probe(NORMALS), lights=3, fixed=given)
    rows = list(found.report.fixed)
    assert rows == [2, 0]
    np.testing.assert_array_equal(found.lights.direction[rows], given)
    assert el.fit_probe(NORMALS, rig.probe(NORMALS), lights=3).report.fixed == ()


def test_lights_are_taken_where_directions_are():
    rig = known_rig()
    seen = rig.probe(NORMALS)
    held = el.fit_probe(NORMALS, seen, fixed=rig.lights)
    np.testing.assert_array_equal(held.lights.direction, rig.lights.direction)
    started = el.fit_probe(NORMALS, seen, start=rig.lights)
    assert started.to_dict()["lights"] == el.fit_probe(NORMALS, seen, start=rig).to_dict()["lights"]


def test_a_fixed_light_that_is_not_needed_comes_back_black():
    one = known_rig().lights[:1]
    rig = el.Rig([0, 0, 0], one, 0)
    found = el.fit_probe(NORMALS, rig.probe(NORMALS), fixed=[one.direction[0], -one.direction[0]])
    np.testing.assert_allclose(found.lights.irradiance[1], 0, atol=1e-12)
    assert len(found.lights) == 2


def test_fixed_lights_come_back_from_a_black_map():
    found = el.fit(np.zeros((16, 32, 3)), fixed=[[0, 1, 0], [1, 0, 0]], error=0.1)
    assert len(found.lights) == 2
    assert not found.lights.irradiance.any()
    assert found.report.stop_reason is el.rigs.StopReason.NOTHING_TO_FIT
