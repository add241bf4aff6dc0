"""Large places of low contrast: found by their rims, and told from all that has none."""

import sys

import numpy as np
import pytest

import envlights as el
from envlights.kernels import sphere
from envlights.synthetic import Disc, Rectangle, faint, judge, scene, suite
from tests.detection.test_detect import assert_same_lights, turned_by
from tests.detection.test_split import closure, left_over
from tests.helpers import angle_deg, printed_by_threads

#: Every fourth of the maps that no threshold was chosen by.
SEEDS = suite.JUDGING[::4]


def notes_of(lights):
    return [note for note in lights.report.notes if "low contrast" in note]


def ground(level, height=256):
    """A map without lights, from its luminance in each direction."""
    return sphere.over_map(height, lambda directions: level(directions)[..., None] * np.ones(3))


def world(*shapes, height=256):
    """Shapes before 1, with a broad glow opposite: the threshold is 7."""
    axis = -np.sum([shape.direction for shape in shapes], axis=0)
    glow = ground(lambda d: 1 + 6 * np.exp(-((off_axis(axis, d) / 40) ** 2)), height)
    return scene(height, background=glow, shapes=shapes)


def off_axis(axis, directions):
    return np.rad2deg(
        np.arccos(np.clip(directions @ (np.array(axis) / np.linalg.norm(axis)), -1, 1))
    )


def test_known_places_are_found_and_measured():
    found = [(world, el.detect(world.radiance)) for world in map(faint, SEEDS)]
    score = judge([(world, lights.direction, lights.irradiance) for world, lights in found])
    assert score.f1 >= 0.97
    assert score.false_on_lightless == 0
    assert np.median(score.angles_deg) < 0.03
    assert np.median(score.flux_errors) < 0.005
    assert np.percentile(score.flux_errors, 95) < 0.02


def test_nothing_is_found_on_the_grounds_alone(monkeypatch):
    monkeypatch.setattr(sys.modules["envlights.synthetic.faint"], "_places", lambda *_: [])
    assert sum(len(el.detect(faint(seed).radiance)) for seed in SEEDS) == 0


@pytest.mark.parametrize("direction", [(0, 0, -1), (0, 1, 0.02), (0.1, -1, 0.2), (1, 0.6, 0.3)])
@pytest.mark.parametrize("tilt_deg", [0, 30])
def test_a_place_is_found_wherever_it_is(direction, tilt_deg):
    window = Rectangle(direction, 12, 36, [2.5] * 3, tilt_deg=tilt_deg)
    for known in (world(Disc(direction, 12, [2.5] * 3)), world(window)):
        lights = el.detect(known.radiance)
        assert len(lights) == len(notes_of(lights)) == 1
        assert angle_deg(lights.direction, known.lights.direction) < 0.1
        # The pixels of the rim count whole or not at all, and a window has few kinds of them.
        np.testing.assert_allclose(lights.irradiance, known.irradiance_with_background, rtol=0.03)
        np.testing.assert_allclose(lights.solid_angle, known.solid_angle, rtol=0.05)


def test_the_report_says_what_was_found_by_its_rim():
    places = [Disc((1, 0, 0), 12, [2.8] * 3), Disc((0, 0, 1), 14, [2.5] * 3)]
    (note,) = notes_of(el.detect(world(*places).radiance))
    assert note.startswith("2 lights large, of low contrast and found by a sharp rim, at azimuth")
    assert "azimuth 180°, elevation 0°" in note
    bright = el.detect(world(Disc((1, 0, 0), 12, [30.0] * 3)).radiance)
    assert len(bright) == 1
    assert notes_of(bright) == []


@pytest.mark.parametrize("seed", [1003, 1008, 1010, 1015])
@pytest.mark.parametrize("columns", [1, 333, 512])
def test_a_turned_map_has_turned_places(seed, columns):
    radiance = faint(seed).radiance
    turned = el.detect(np.ascontiguousarray(np.roll(radiance, columns, axis=1)))
    assert notes_of(turned)
    assert_same_lights(turned, el.detect(radiance), turned_by(columns, radiance.shape[1]))


@pytest.mark.parametrize("seed", [1003, 1008])
def test_exposure_and_mirrors_change_no_place(seed):
    radiance = faint(seed).radiance
    lights = el.detect(radiance)
    assert_same_lights(
        el.detect(np.ascontiguousarray(radiance[::-1])), lights, lambda d: d * (1, -1, 1)
    )
    for factor in (1e-6, 1e6):
        scaled = el.detect((radiance * factor).astype(np.float32))
        assert angle_deg(scaled.direction, lights.direction).max() < 1e-3
        np.testing.assert_allclose(scaled.irradiance, factor * lights.irradiance, rtol=1e-4)


@pytest.mark.parametrize("width_deg", [10, 20, 40])
def test_a_glow_is_no_place(width_deg):
    """A pool of light as bright as a place, with as much flux, and without a rim."""
    radiance = ground(lambda d: 1 + 3 * np.exp(-((off_axis((1, 0.3, 0.2), d) / width_deg) ** 2)))
    assert notes_of(el.detect(radiance)) == []


def test_a_rim_makes_a_place_of_a_glow():
    """The same step over 12 degrees and over one."""

    def slope(breadth_deg):
        def level(directions):
            share = (12 + breadth_deg / 2 - off_axis((1, 0.3, 0.2), directions)) / breadth_deg
            glow = 6 * np.exp(-((off_axis((-1, -0.3, -0.2), directions) / 40) ** 2))
            return 1 + glow + 2 * np.clip(share, 0, 1)

        return ground(level, 512)

    assert [len(el.detect(slope(breadth_deg))) for breadth_deg in (12, 1)] == [0, 1]


def test_a_wall_and_tiles_are_no_places():
    assert len(el.detect(world(Rectangle((1, 0, 0), 70, 50, [3.0] * 3)).radiance)) == 0
    row, column = np.arange(256) // 16, np.arange(512) // 16
    tiles = 1 + 2.0 * ((row[:, None] + column) % 2)
    assert len(el.detect(tiles[..., None] * np.ones(3))) == 0


def test_a_place_around_a_lamp_is_left_to_the_lamp():
    lamp, place = Disc((1, 0, 0), 2, [50.0] * 3), Disc((1, 0, 0), 12, [2.8] * 3)
    lights = el.detect(world(place, lamp).radiance)
    assert len(lights) == 1
    assert notes_of(lights) == []


def test_what_is_too_dim_or_too_little_is_no_place():
    for radius_deg, level in ((12, 2.0), (4, 2.6)):
        known = world(Disc((1, 0, 0), radius_deg, [level] * 3), height=512)
        assert len(el.detect(known.radiance)) == 0


def test_min_worth_and_max_lights_count_for_places_too():
    places = [Disc((1, 0, 0), 12, [2.8] * 3), Disc((0, 0, 1), 14, [2.5] * 3)]
    radiance = world(*places).radiance
    assert len(el.detect(radiance, min_worth=0.2)) == 0
    merged = el.detect(radiance, max_lights=1)
    assert len(merged) == 1
    assert notes_of(merged)


@pytest.mark.parametrize("seed", [1003, 1008])
def test_a_split_takes_places_out_and_closes(seed):
    env = el.EnvMap(faint(seed, 256).radiance)
    lights, rest = el.split(env)
    assert notes_of(lights)
    assert closure(env, lights, rest).max(initial=0.0) < 1e-6
    assert left_over(env, lights, rest).max() < 1e-6


def test_the_number_of_threads_changes_no_bit():
    code = (
        "import hashlib, envlights as el;"
        "lights = el.detect(el.synthetic.faint(1003).radiance);"
        "print(hashlib.sha256(str(lights.to_dict()).encode()).hexdigest())"
    )
    assert len(set(printed_by_threads(code))) == 1
