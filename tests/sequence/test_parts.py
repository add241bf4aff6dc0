"""Parts of `follow`: assignment, window, identities, steps, frames."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.optimize import linear_sum_assignment

import envlights as el
from envlights._common.srgb import decode_srgb
from envlights._native import assignment
from envlights.fitting.map_fit import MapSamples
from envlights.sequence.frames import frames_of, read_frames
from envlights.sequence.identity import Identities, rotation_vector, turn
from envlights.sequence.light_tracks import tracks_of
from envlights.sequence.steadiness import window_frames, window_weights
from envlights.sequence.steps import Steps
from envlights.sequence.window import FrameFit, average, thin
from tests.sequence import shows
from tests.sequence.shows import towards

SQUARES = st.integers(1, 8).flatmap(
    lambda size: arrays(float, (size, size), elements=st.floats(-10, 10))
)


@given(SQUARES)
def test_the_assignment_costs_as_little_as_that_of_scipy(costs):
    columns = assignment(costs)
    assert sorted(columns) == [*range(len(costs))]
    least = costs[linear_sum_assignment(costs)].sum()
    assert costs[np.arange(len(costs)), columns].sum() == pytest.approx(least, abs=1e-9)


@pytest.mark.parametrize("costs", [np.zeros((2, 3)), np.array([[np.nan]])])
def test_only_a_square_table_of_finite_costs_has_an_assignment(costs):
    with pytest.raises(el.EnvLightsError, match="costs must"):
        assignment(costs)


@given(st.integers(0, 40))
def test_a_window_leaves_straight_lines_as_they_are(half):
    weights = window_weights(half)
    assert weights.sum() == pytest.approx(1)
    assert weights @ np.arange(-half, half + 1) == pytest.approx(0, abs=1e-12)
    assert (weights > 0).all()


def test_seconds_become_frames():
    assert window_frames("0.5s", 24.0) == 12
    assert window_frames(" 0.25 s ", 60.0) == 15


@given(st.integers(0, 2**32))
def test_the_shortest_rotation_leads_from_one_direction_to_the_other(seed):
    start, end = np.random.default_rng(seed).normal(size=(2, 3))
    start, end = start / np.linalg.norm(start), end / np.linalg.norm(end)
    np.testing.assert_allclose(turn(start, rotation_vector(start, end)), end, atol=1e-9)


def lamps(*places, flux=(1.0, 1.0, 1.0)):
    irradiance = np.repeat(np.array(flux[: len(places)])[:, None], 3, axis=1)
    return el.Lights([towards(*place) for place in places], irradiance)


def test_lights_that_cross_between_two_frames_go_on_by_their_motion():
    identities = Identities()
    for k in range(-6, 7):
        # At k = 0 each light is where the other one was: the nearest light is the wrong one.
        lights = lamps((2 * k - 1, 0), (1 - 2 * k, 0))
        ids = identities.follow(lights)
        left = ids[int(np.argmin(lights.direction[:, 0]))]
        assert left == (0 if k <= 0 else 1)


def test_a_light_far_away_is_another_one():
    identities = Identities()
    assert identities.follow(lamps((0, 0), (90, 0))) == (0, 1)
    assert identities.follow(lamps((1, 0), (120, 0))) == (0, 2)
    # The light that vanished is remembered.
    assert identities.follow(lamps((2, 0), (90, 0))) == (0, 1)


def test_flux_decides_between_lights_that_are_nearly_as_near():
    identities = Identities()
    identities.follow(lamps((-2, 0), (2, 0), flux=(9, 1)))
    # The bright one is now nearer to where the other one was.
    assert identities.follow(lamps((0.5, 1), (-0.5, -1), flux=(9, 1))) == (0, 1)


def test_a_rig_is_the_weighted_mean_of_the_fits_around_it():
    fluxes, weights = [1.0, 2.0, 4.0, 8.0, 16.0], window_weights(2)
    fits = [
        FrameFit(
            k,
            el.Rig([0, 0, flux], lamps((3 * k, 0), flux=(flux,)), 0.5),
            (7,),
            samples(1),
            False,
            False,
        )
        for k, flux in enumerate(fluxes)
    ]
    # The light of the last frame is another one.
    fits[4] = fits[4]._replace(ids=(8,))
    rig = average(fits)
    assert (rig.frame, rig.fit_error) == (2, 0.5)
    assert rig.ambient[2] == pytest.approx(weights @ fluxes)
    assert rig.flux(7) == pytest.approx(weights[:4] @ fluxes[:4])
    assert rig.flux(8) == pytest.approx(weights[4] * fluxes[4])
    parts = weights[:4] * fluxes[:4] @ [towards(3 * k, 0) for k in range(4)]
    expected = parts / np.linalg.norm(parts)
    np.testing.assert_allclose(rig.light(7).direction[0], expected, atol=1e-12)


def test_a_light_whose_directions_cancel_is_left_out():
    def fit(frame, direction, flux):
        lights = el.Lights([direction], [[0, 0, flux]])
        return FrameFit(frame, el.Rig([0, 0, 0], lights, 0.5), (7,), samples(1), False, False)

    rows = [([1, 0, 0], 1.0), ([0, 1, 0], 0.0), ([-1, 0, 0], 1.0)]
    rig = average([fit(frame, *row) for frame, row in enumerate(rows)])
    assert len(rig.lights) == 0


def samples(level):
    irradiance = np.full((20, 3), float(level))
    return MapSamples(np.tile([0.0, 1.0, 0.0], (20, 1)), np.ones(20), irradiance)


def test_a_step_is_far_above_the_usual_change():
    steps = Steps()
    levels = [1, 1.01, 1.0, 1.01, 1.02, 1.2, 1.21, 1.3]
    assert [steps.is_step(samples(level)) for level in levels] == [False] * 5 + [True, False, True]


def test_a_resting_scene_has_no_step():
    steps = Steps()
    assert not any(steps.is_step(samples(1)) for _ in range(9))


def test_a_seventh_of_the_normals_measures_nearly_the_same_error():
    env = next(shows.crossing(1, height=64))
    alone = el.follow([env], lights=1).sequence()
    assert alone.error[0] == pytest.approx(alone.fit_error[0], rel=0.01)
    whole = MapSamples(np.zeros((5120, 3)), np.zeros(5120), np.zeros((5120, 3)))
    assert len(thin(whole).normals) == 732


def test_files_come_in_natural_order(tmp_path):
    for number in (10, 9, 1):
        el.EnvMap(np.full((4, 8, 3), float(number))).save(tmp_path / f"f{number}.exr")
    (tmp_path / "notes.txt").write_text("no map")
    for source in (tmp_path, str(tmp_path / "f*.exr")):
        found = frames_of(source)
        assert found.number == 3
        assert [el.EnvMap.open(path).radiance[0, 0, 0] for path in found.maps] == [1, 9, 10]


def test_frame_rigs_have_an_identity_for_each_light():
    with pytest.raises(el.EnvLightsError, match="ids must be 1 different numbers"):
        el.sequence.FrameRig([0, 0, 0], lamps((0, 0)), 0.0)
    with pytest.raises(el.EnvLightsError, match="ids must be 2 different numbers"):
        el.sequence.FrameRig([0, 0, 0], lamps((0, 0), (9, 0)), 0.0, ids=(1, 1))


def test_frames_must_be_in_order():
    rigs = [el.sequence.FrameRig([0, 0, 0], lamps((0, 0)), 0.0, frame=k, ids=(0,)) for k in (1, 0)]
    with pytest.raises(el.EnvLightsError, match="rising order"):
        el.sequence.RigSequence(rigs)


def test_flicker_is_the_standard_deviation_of_independent_noise():
    noise = 1 + 0.01 * np.random.default_rng(1).standard_normal(4000)
    rigs = [
        el.sequence.FrameRig([0, 0, 0], el.Lights([[0, 1, 0]], [[a, a, a]]), 0.0, frame=k, ids=(0,))
        for k, a in enumerate(noise)
    ]
    assert el.sequence.RigSequence(rigs).flicker == pytest.approx(0.01, rel=0.05)


def test_flicker_leaves_out_steps_and_constant_changes():
    flux = [1, 2, 3, 4, 9, 10, 11, 12]
    rigs = [
        el.sequence.FrameRig(
            [0, 0, 0], el.Lights([[0, 1, 0]], [[a] * 3]), 0.0, frame=k, ids=(0,), is_step=k == 4
        )
        for k, a in enumerate(flux)
    ]
    assert el.sequence.RigSequence(rigs).flicker == pytest.approx(0, abs=1e-12)
    rigs[4] = el.sequence.FrameRig([0, 0, 0], rigs[4].lights, 0.0, frame=4, ids=(0,))
    assert el.sequence.RigSequence(rigs).flicker > 0.1


def test_a_video_is_decoded_frame_by_frame(tmp_path):
    av = pytest.importorskip("av", reason="needs PyAV")
    path = str(tmp_path / "lamps.mkv")
    with av.open(path, "w") as file:
        stream = file.add_stream("ffv1", rate=25)
        stream.width, stream.height, stream.pix_fmt = 64, 32, "bgr0"
        for level in (50, 100, 200):
            codes = np.full((32, 64, 3), level, np.uint8)
            file.mux(stream.encode(av.VideoFrame.from_ndarray(codes, format="rgb24")))
        file.mux(stream.encode(None))
    found = read_frames(path, None, None)
    assert found.fps == 25
    maps = list(found.maps)
    levels = [float(env.radiance[0, 0, 0]) for env in maps]
    np.testing.assert_allclose(levels, decode_srgb(np.array([50, 100, 200]) / 255), rtol=1e-5)
    assert "a frame of a video" in maps[0].notes[0]
    (first, *_) = read_frames(path, {"lux": 900}, None).maps
    assert first.units == "cd/m2"
    assert "a frame of a video" in first.notes[0]
    assert el.follow(path, lights=1).sequence().fps == 25


def test_a_damaged_video_is_refused(tmp_path):
    pytest.importorskip("av", reason="needs PyAV")
    (tmp_path / "no.mp4").write_bytes(b"no video")
    with pytest.raises(el.io.DamagedFileError, match="is not a video that PyAV reads"):
        el.follow(tmp_path / "no.mp4")


def test_without_pyav_a_video_is_refused(tmp_path, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(el.EnvLightsError, match=r"pip install 'envlights\[video\]'"):
        el.follow(tmp_path / "lamps.mp4")


def frames_of_lamps(levels):
    """Irradiance on six sides under lamps on three axes, for rows of their levels."""
    sides = np.concatenate([np.eye(3), -np.eye(3)])
    weights = np.full(6, 1 / 6)
    for row in np.atleast_2d(levels):
        light = np.maximum(sides @ np.diag(row), 0).sum(axis=1) + 0.2
        yield MapSamples(sides, weights, light[:, None] * np.ones(3))


def steps_of(frames, gains=None):
    steps = Steps()
    gains = np.ones((len(frames), 1)) if gains is None else np.reshape(gains, (len(frames), -1))
    scaled = (f._replace(irradiance=g * f.irradiance) for f, g in zip(frames, gains, strict=True))
    return [k for k, each in enumerate(scaled) if steps.is_step(each)]


RNG = np.random.default_rng(0)
NOISE = RNG.uniform(0.9, 1.1, 40)


@pytest.mark.parametrize("lamp", [0.15, 0.5, 2.0])
@pytest.mark.parametrize(
    "gains",
    [
        np.tile([1, 0.93, 1.07, 1], 10),
        NOISE,
        RNG.uniform(0.95, 1.05, (40, 3)),  # of the white balance
        1.02 ** np.arange(40),
        np.where(np.arange(40) % 2, 0.8, 1.0),
    ],
)
def test_a_switch_inside_a_flicker_is_a_step(gains, lamp):
    levels = np.ones((40, 3))
    levels[20:, 0] += lamp
    assert steps_of(list(frames_of_lamps(levels)), gains) == [20]


@pytest.mark.parametrize("gains", [NOISE, np.tile([1, 0.93], 20), 1.02 ** np.arange(40)])
def test_a_flicker_alone_has_no_step(gains):
    assert steps_of(list(frames_of_lamps(np.ones((40, 3)))), gains) == []


@pytest.mark.parametrize("first", [0, 1, 2, 3, 5])
@pytest.mark.parametrize("last", [0, 1, 2])
def test_both_ends_of_a_flash_in_the_first_frames_are_steps(first, last):
    end = first + last + 1
    levels = np.ones((30, 3))
    levels[first:end, 1] = 9
    levels[20:, 0] = 1.5  # a later switch is not hidden by the flash
    expected = [*([first] if first else []), end, 20]
    assert steps_of(list(frames_of_lamps(levels))) == expected


def test_fast_motion_from_the_first_frame_is_no_row_of_steps():
    turns = [(1 + np.cos(k), 1 + np.sin(k), 1) for k in range(30)]
    assert set(steps_of(list(frames_of_lamps(turns)))) <= {1, 2, 3}


def test_tracks_take_memory_in_proportion_to_the_frames():
    """The distance of each frame from each other one would take 512 MB."""
    lights = el.Lights([[0, 1, 0], [1, 0, 0]], [[1, 1, 1], [2, 2, 2]], [0.1, 0.1])
    rigs = [el.sequence.FrameRig([0.1] * 3, lights, 0.0, frame=k, ids=(0, 1)) for k in range(8000)]
    tracemalloc.start()
    tracks = tracks_of(rigs, "gltf", None)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 30e6
    assert tracks.lights[1].intensity.tolist() == [rigs[0].light(1).irradiance.max()] * 8000


def test_a_light_rests_as_in_the_nearest_frame_where_it_is_absent():
    """Frames 2, 3 and 6 of 8 have it; of two equally near frames the earlier one counts."""
    lamp = el.Lights([[0, 0.6, 0.8]], [[2.0, 1, 0]], [0.1])
    turned = el.Lights([[0, 1, 0]], [[0, 3.0, 0]], [0.2])
    rigs = []
    for k in range(8):
        here = {2: lamp, 3: lamp, 6: turned}.get(k, lamp[:0])
        ids = (7,) if len(here) else ()
        rigs.append(el.sequence.FrameRig([0.1] * 3, here, 0.0, frame=k, ids=ids))
    (track,) = tracks_of(rigs, "gltf", None).lights
    assert track.intensity.tolist() == [0, 0, 2, 2, 0, 0, 3, 0]
    assert track.radius.tolist() == [0.1] * 5 + [0.2] * 3
    assert track.colour[:5].tolist() == [[1, 0.5, 0]] * 5
    np.testing.assert_array_equal(track.direction[5:], [[0, 1, 0]] * 3)


@pytest.mark.parametrize(
    ("folder", "pattern"),
    [
        ("renders [v2]", "f*.exr"),
        ("renders [v2]", "f[12].exr"),
        ("renders", "f*[[]a].exr"),
        ("renders", "f*[a].exr"),
        ("renders", "f?[a].exr"),
        ("[x]", "**/f*.exr"),
    ],
)
def test_brackets_in_names_are_found(folder, pattern, tmp_path):
    name = "f{}[a].exr" if "a]" in pattern else "f{}.exr"
    (tmp_path / folder).mkdir()
    even = el.EnvMap(np.full((8, 16, 3), 0.5, np.float32))
    for k in (1, 2):
        even.save(tmp_path / folder / name.format(k))
    path = str(tmp_path / folder / pattern)
    assert len(el.follow(path, lights=0, steadiness=0).sequence()) == 2
    assert len(el.batch(path, lights=0, jobs=1)) == 2
    one = str(tmp_path / folder / name.format(1))
    assert len(el.follow(one, lights=0, steadiness=0).sequence()) == 1


def test_lamps_of_two_colours_that_pass_each_other_keep_their_identities():
    """The second frame has the lamps where the others were, but for 6 degrees."""
    identities = Identities()
    red, blue = [1.0, 0.1, 0.1], [0.1, 0.1, 1.0]
    here, there = towards(-3, 10), towards(3, 10)
    before = identities.follow(el.Lights([here, there], [red, blue]))
    after = identities.follow(el.Lights([here, there], [blue, red]))
    # Red is brighter, and the first of each frame.
    assert before == after == (0, 1)
