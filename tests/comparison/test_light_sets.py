"""Comparison of two sets of lights."""

import json
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import envlights as el
from tests.conftest import real_maps
from tests.helpers import angle_deg

WHITE = [1.0, 1.0, 1.0]


def at(azimuth, elevation):
    """Direction of an azimuth and an elevation in degrees."""
    azimuth, elevation = np.deg2rad([azimuth, elevation])
    x, z = np.sin(azimuth) * np.cos(elevation), -np.cos(azimuth) * np.cos(elevation)
    return np.array([x, np.sin(elevation), z])


def lamp(azimuth, elevation, colour=WHITE, radius=0.0):
    return el.Lights([at(azimuth, elevation)], [colour], [np.deg2rad(radius)])


def together(*sets):
    arrays = zip(
        *((each.direction, each.irradiance, each.angular_radius) for each in sets), strict=True
    )
    return el.Lights(*(np.concatenate(each) for each in arrays))


def some_lights(seed, count):
    """Lights of random brightness on the corners of a cube and around: 50 degrees apart."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 3**0.5
    rng = np.random.default_rng(seed)
    return el.Lights(corners[:count], rng.random((count, 3)), rng.random(count) / 9)


def scattered_lights(seed, count):
    """Lights in random directions: no two plans have the same mean angle."""
    rng = np.random.default_rng(seed)
    directions = Rotation.random(count, random_state=seed).as_matrix()[:, 0]
    return el.Lights(directions, rng.random((count, 3)), rng.random(count))


def turn(axis, degrees):
    return Rotation.from_rotvec(np.deg2rad(degrees) * np.asarray(axis, float)).as_matrix()


SUN_AND_LAMPS = together(lamp(40, 50, [9, 8, 7], 0.3), lamp(200, 10, [1, 2, 3], 5), lamp(300, -20))


def test_a_set_does_not_differ_from_itself():
    difference = el.comparison.compare_lights(SUN_AND_LAMPS, SUN_AND_LAMPS)
    numbers = difference.to_dict()
    assert [(row["truth"], row["guess"]) for row in numbers.pop("plan")] == [(0, 0), (1, 1), (2, 2)]
    assert numbers.pop("notes") == []
    assert numbers == pytest.approx(dict.fromkeys(numbers, 0.0), abs=1e-6)


@pytest.mark.parametrize("elevation", [0, 40, -75])
def test_lamps_on_either_side_of_the_seam_are_near(elevation):
    difference = el.comparison.compare_lights(lamp(0.1, elevation), lamp(359.9, elevation))
    expected = angle_deg(at(0.1, elevation), at(-0.1, elevation))
    assert difference.angle == pytest.approx(expected, abs=1e-9)
    assert difference.peak_angle == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("pole", [1, -1])
def test_lamps_on_either_side_of_a_pole_are_near(pole):
    difference = el.comparison.compare_lights(lamp(30, pole * 89), lamp(210, pole * 89))
    assert difference.angle == pytest.approx(2, abs=1e-9)
    assert difference.rotation == pytest.approx(2, abs=1e-9)


def test_a_missing_lamp_costs_its_share_times_its_angle():
    both = together(lamp(0, 0, [3, 3, 3]), lamp(139, 0))
    difference = el.comparison.compare_lights(both, lamp(0, 0, [3, 3, 3]))
    assert difference.angle == pytest.approx(139 / 4, abs=1e-9)
    assert difference.unmatched == pytest.approx(1 / 4, abs=1e-12)
    assert difference.flux_ratio == pytest.approx(np.log2(3 / 4), abs=1e-12)
    assert difference.plan[1] == (1, 0, pytest.approx(0.25), pytest.approx(139))


@pytest.mark.parametrize(("degrees", "unmatched"), [(29.9, 0.0), (30.1, 1.0)])
def test_flux_that_moves_more_than_30_degrees_is_unmatched(degrees, unmatched):
    assert el.comparison.compare_lights(lamp(5, 0), lamp(5 + degrees, 0)).unmatched == unmatched


@pytest.mark.parametrize("seed", range(4))
def test_lamps_that_move_along_their_row_all_move(seed):
    """The first one could also move to the end, past the others, at the same mean angle."""
    rng = np.random.default_rng(seed)
    row = together(*(lamp(10 * k, 0) for k in rng.permutation(8)))
    moved = together(*(lamp(10 * k + 10, 0) for k in rng.permutation(8)))
    difference = el.comparison.compare_lights(row, moved)
    assert difference.angle == pytest.approx(10, abs=1e-9)
    assert difference.unmatched == 0
    assert difference.rotation == pytest.approx(10, abs=1e-9)


def test_equal_lamps_may_be_exchanged():
    row = together(*(lamp(10 * k, 0) for k in range(4)))
    shuffled = el.comparison.compare_lights(row, row[[2, 0, 3, 1]])
    assert shuffled.angle == pytest.approx(0, abs=1e-9)


def test_colours_are_compared_at_equal_luminance_of_any_amount():
    difference = el.comparison.compare_lights(lamp(0, 0, [1, 0, 0]), lamp(0, 0, [0, 8, 0]))
    assert difference.colour_angle == pytest.approx(90)
    assert el.comparison.compare_lights(
        lamp(0, 0, [1, 1, 0]), lamp(0, 0, [2, 0, 0])
    ).colour_angle == (pytest.approx(45))


def test_size_is_the_mean_difference_of_the_radii_over_the_plan():
    truth = together(lamp(0, 0, [3, 3, 3], 5), lamp(180, 0, WHITE, 2))
    guess = together(lamp(0, 0, [3, 3, 3], 4), lamp(180, 0, WHITE, 6))
    assert el.comparison.compare_lights(truth, guess).size == pytest.approx(3 / 4 * 1 + 1 / 4 * 4)


@given(
    seed=st.integers(0, 99),
    count=st.integers(2, 8),
    axis=st.integers(0, 99),
    degrees=st.floats(0, 20),
)
def test_a_rotated_set_gives_its_movement_and_its_rotation(seed, count, axis, degrees):
    lights = some_lights(seed, count)
    matrix = turn(Rotation.random(random_state=axis).as_matrix()[0], degrees)
    moved = lights.rotated(matrix)
    movements = angle_deg(lights.direction, lights.direction @ matrix.T)
    difference = el.comparison.compare_lights(lights, moved)
    assert difference.angle == pytest.approx(movements @ lights.fraction, abs=1e-6)
    assert difference.peak_angle == pytest.approx(movements[0], abs=1e-6)
    assert difference.rotation == pytest.approx(degrees, abs=1e-6)
    assert [(row.truth, row.guess) for row in difference.plan] == [(k, k) for k in range(count)]
    assert difference.size == pytest.approx(0, abs=1e-9)
    assert difference.flux_ratio == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("tilt", [0, 90])
@pytest.mark.parametrize("degrees", [0.3, 7.0, 25.0])
def test_a_set_over_the_seam_or_a_pole_is_no_special_case(tilt, degrees):
    """A cross of lights on the seam, or around the north pole, that moves across it."""
    points = [(-0.1, 0), (60, 0), (-60, 0), (0, 60), (0, -60)]
    cross = together(*(lamp(*point, [k + 1.0] * 3) for k, point in enumerate(points)))
    cross = cross.rotated(turn([1, 0, 0], tilt))
    matrix = turn([0.6, 0.8, 0], degrees)
    movements = angle_deg(cross.direction, cross.direction @ matrix.T)
    difference = el.comparison.compare_lights(cross, cross.rotated(matrix))
    assert difference.angle == pytest.approx(movements @ cross.fraction, abs=1e-6)
    assert difference.rotation == pytest.approx(degrees, abs=1e-6)


def test_one_lamp_gives_the_smallest_rotation():
    assert el.comparison.compare_lights(lamp(10, 20), lamp(10, 55)).rotation == pytest.approx(
        35, abs=1e-9
    )
    # Opposite lamps lie on one line too.
    line = together(lamp(0, 0, [2, 2, 2]), lamp(180, 0))
    moved = line.rotated(turn([0, 1, 0], 12) @ turn(line.direction[0], 77))
    assert el.comparison.compare_lights(line, moved).rotation == pytest.approx(12, abs=1e-6)


def test_lamps_in_balance_have_no_best_rotation():
    """Half of the light goes to one pole, half to the other, all from the horizon."""
    difference = el.comparison.compare_lights(together(lamp(0, 90), lamp(0, -90)), lamp(0, 0))
    assert difference.rotation is None
    assert difference.angle == pytest.approx(90, abs=1e-9)
    assert "best common rotation       none" in str(difference)


def test_the_strongest_lights_are_matched_and_the_others_reported():
    truth = together(lamp(0, 0, [6, 6, 6]), lamp(90, 0, [3, 3, 3]), lamp(180, 0))
    difference = el.comparison.compare_lights(truth, truth, strongest=2)
    assert difference.left_out == pytest.approx(0.1)
    assert sum(row.fraction for row in difference.plan) == pytest.approx(1)
    assert difference.notes[0] == (
        "of the truth, the 2 strongest of 3 lights are matched; the others hold 10 % of its flux"
    )
    # Totals count all lights.
    assert el.comparison.compare_lights(truth, truth[:2], strongest=2).flux_ratio == pytest.approx(
        np.log2(0.9)
    )


NOTHING = el.Lights(np.zeros((0, 3)), np.zeros((0, 3)))


@pytest.mark.parametrize("empty", [NOTHING, lamp(0, 0, [0, 0, 0])])
def test_numbers_of_a_set_without_light_do_not_exist(empty):
    for truth, guess, name in [(empty, SUN_AND_LAMPS, "truth"), (SUN_AND_LAMPS, empty, "guess")]:
        difference = el.comparison.compare_lights(truth, guess)
        numbers = difference.to_dict()
        assert numbers.pop("notes") == [f"the {name} has no light, so there is nothing to move"]
        assert numbers.pop("left_out") == 0
        assert numbers.pop("plan") == []
        assert set(numbers.values()) == {None}
        assert str(difference) == f"note: {difference.notes[0]}"
        assert repr(difference) == "<LightSetDifference: no lights to compare>"


def test_black_lights_among_others_take_no_part():
    truth = together(lamp(0, 0), lamp(90, 0, [0, 0, 0]))
    assert el.comparison.compare_lights(truth, lamp(0, 0)).angle == pytest.approx(0, abs=1e-9)


def lights_of_a_disc(azimuth=90.0):
    shape = el.synthetic.Disc(tuple(at(azimuth, 0)), 5.0, (9, 6, 3))
    return el.detect(el.synthetic.scene(128, background=[0.1] * 3, shapes=[shape]).radiance)


def test_detected_lights_are_compared_at_their_peaks():
    one, other = lights_of_a_disc(90), lights_of_a_disc(100)
    difference = el.comparison.compare_lights(one, other)
    assert difference.peak_angle == angle_deg(one.peak_direction[0], other.peak_direction[0])
    assert difference.angle == pytest.approx(10, abs=0.05)
    # A rig has no peaks.
    assert el.comparison.compare_lights(one, other.discs()).peak_angle == pytest.approx(
        angle_deg(one.direction[0], other.direction[0]), abs=1e-9
    )


def test_lights_of_a_rig_are_compared_with_detected_ones():
    env = el.EnvMap(el.synthetic.hall(64).radiance)
    difference = el.comparison.compare_lights(el.detect(env), el.fit(env, lights=4).lights)
    assert sum(row.fraction for row in difference.plan) == pytest.approx(1, abs=1e-12)
    assert 0 < difference.angle < 180


def test_clipped_lights_and_other_units_are_noted():
    clipped = el.detect(el.EnvMap(np.minimum(el.synthetic.hall(64).radiance, 1), clip_level=1.0))
    assert clipped.is_clipped.any()
    calibrated = el.Lights([[0, 1, 0]], [WHITE], units="cd/m2")
    notes = el.comparison.compare_lights(clipped, calibrated).notes
    assert any("clipped in the truth" in note for note in notes)
    assert notes[-1] == ("the truth is in the map's own scale, the guess in cd/m2; see flux_ratio")


def test_the_difference_is_symmetric_but_for_the_ratio():
    one, other = scattered_lights(1, 8), scattered_lights(2, 5)
    forward, back = (
        el.comparison.compare_lights(one, other),
        el.comparison.compare_lights(other, one),
    )
    for name in ("angle", "peak_angle", "colour_angle", "size", "unmatched", "rotation"):
        assert getattr(forward, name) == pytest.approx(getattr(back, name), abs=1e-6), name
    assert forward.flux_ratio == pytest.approx(-back.flux_ratio)


def test_the_result_is_text_json_and_a_value():
    difference = el.comparison.compare_lights(some_lights(1, 8), some_lights(2, 8))
    assert json.loads(json.dumps(difference.to_dict())) == difference.to_dict()
    assert pickle.loads(pickle.dumps(difference)) == difference
    assert difference != el.comparison.compare_lights(some_lights(1, 8), some_lights(1, 8))
    assert "truth  guess" in difference.verbose()
    assert "<table>" in difference._repr_html_()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"truth": "hall.exr"}, "truth must be Lights, as of rig.lights or .*; got 'hall.exr'"),
        ({"guess": np.eye(3)}, "guess must be Lights"),
        ({"strongest": 0}, "strongest must be a whole number, 1 or more; got 0"),
    ],
)
def test_bad_input_is_refused_by_name(arguments, message):
    with pytest.raises(el.EnvLightsError, match=message):
        el.comparison.compare_lights(**{"truth": SUN_AND_LAMPS, "guess": SUN_AND_LAMPS} | arguments)


@real_maps("hdr/*.hdr", "exr/*.exr", "ldr/*.png")
def test_a_rolled_map_has_rolled_lights(path):
    env = el.EnvMap.open(path)
    columns = env.width // 32
    matrix = turn([0, -1, 0], 360 * columns / env.width)
    lights = el.detect(env)
    rolled = el.detect(env.with_radiance(np.roll(env.radiance, columns, axis=1), ()))
    difference = el.comparison.compare_lights(lights, rolled)
    strongest = lights.luminance.argmax()
    peak = lights.peak_direction[strongest]
    assert difference.peak_angle == pytest.approx(angle_deg(peak, matrix @ peak), abs=0.01)
    # Equal lamps may be exchanged, so that the flux never moves farther than the lights.
    movements = angle_deg(lights.direction, lights.direction @ matrix.T)
    mean = movements @ lights.luminance / lights.luminance.sum()
    exact = el.comparison.compare_lights(lights, lights.rotated(matrix)).angle
    assert exact <= mean + 1e-6
    if detects_the_same_lights(lights, rolled, matrix):
        assert difference.angle == pytest.approx(exact, abs=0.01)


def detects_the_same_lights(lights, rolled, matrix):
    """True if the detector cuts both maps into the same lights, up to 0.01 degrees."""
    if len(lights) != len(rolled):
        return False
    return bool((angle_deg(lights.rotated(matrix).direction, rolled.direction) < 0.01).all())
