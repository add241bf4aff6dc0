"""The kernels against closed forms and independent libraries."""

import os
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import qmc

import envlights as el
from envlights import _native, kernels
from envlights.environment.reading import apply_to_map


def test_radical_inverse_of_base_2_and_3_is_scipys_van_der_corput():
    for base in (2, 3, 7):
        ours = [kernels.radical_inverse(i, base) for i in range(200)]
        # The first axis of a Halton sequence is base 2, the next 3, 5, 7.
        axis = [2, 3, 5, 7].index(base)
        theirs = qmc.Halton(4, scramble=False).random(200)[:, axis]
        np.testing.assert_allclose(ours, theirs, atol=1e-15)


def test_halton_is_scipys_and_hammersley_its_first_axis():
    theirs = qmc.Halton(2, scramble=False).random(3145)
    np.testing.assert_allclose(kernels.halton(3145), theirs, atol=1e-15)
    np.testing.assert_allclose(kernels.hammersley(3145)[:, 1], theirs[:, 0], atol=1e-15)


def test_hammersley_on_the_sphere_covers_caps_in_proportion():
    """A cap of height h holds the share h / 2 of the sphere (Archimedes)."""
    directions = kernels.uniform_sphere(kernels.hammersley(4096))
    for pole in np.eye(3):
        for cosine in (-0.5, 0.0, 0.9):
            share = (directions @ pole > cosine).mean()
            # A tilted cap's edge crosses the rows of points: log2(4096) = 12 of them may be off,
            # 3e-3 of all. At the worst of these caps 9 are.
            assert share == pytest.approx((1 - cosine) / 2, abs=4e-3)


@pytest.mark.parametrize("count", [0, 1, 2, 9, 64])
def test_even_directions_are_hammersley_points_half_a_step_in(count):
    points = kernels.hammersley(count) + np.array([0.5 / max(count, 1), 0.0])
    even = _native.even_sphere(count)
    np.testing.assert_allclose(even, kernels.uniform_sphere(points), atol=1e-15)
    assert (np.abs(even[:, 1]) < 1).all()  # none on a pole


@pytest.mark.parametrize("border_sampled", [False, True])
@pytest.mark.parametrize("height", [2, 64, 1024])
def test_solid_angles_sum_to_the_sphere(height, border_sampled):
    total = kernels.pixel_solid_angles(height, 2 * height, border_sampled=border_sampled).sum()
    assert total == pytest.approx(4 * np.pi, rel=1e-12)


def test_frame_is_the_one_of_openexr():
    directions = kernels.uv_to_direction([[0.5, 0.5], [0.25, 0.5], [0.3, 0.0], [0.0, 0.5]])
    expected = [[0, 0, 1], [1, 0, 0], [0, 1, 0], [0, 0, -1]]
    np.testing.assert_allclose(directions, expected, atol=1e-15)


def test_pixels_look_along_their_centres():
    x, y = 5, 3
    (direction,) = kernels.uv_to_direction([[(x + 0.5) / 16, (y + 0.5) / 8]])
    np.testing.assert_allclose(kernels.pixel_directions(8, 16)[y, x], direction, atol=1e-15)


@given(st.floats(0, 1, exclude_max=True), st.floats(0, 1))
def test_uv_survives_the_way_through_directions(u, v):
    direction = kernels.uv_to_direction([[u, v]])
    again = kernels.uv_to_direction(kernels.direction_to_uv(direction))
    np.testing.assert_allclose(again, direction, atol=1e-14)


def test_icosphere_has_the_papers_sizes_and_no_preferred_direction():
    for faces in (320, 5120):
        centroids, solid_angles = kernels.icosphere(faces)
        assert centroids.shape == (faces, 3)
        np.testing.assert_allclose(solid_angles @ centroids, 0, atol=1e-12)
        assert solid_angles.sum() == pytest.approx(4 * np.pi, rel=1e-12)


def test_rig_irradiance_is_equations_4_to_6():
    rng = np.random.default_rng(1)
    normals, _ = kernels.icosphere(80)
    directions = kernels.uniform_sphere(rng.uniform(size=(3, 2)))
    ambient, strength = rng.uniform(size=3), rng.uniform(size=(3, 3))
    expected = np.pi * ambient + np.maximum(normals @ directions.T, 0) @ strength
    received = kernels.rig_irradiance(normals, ambient, directions, strength)
    np.testing.assert_allclose(received, expected, rtol=1e-13)


def test_sum_over_sources_is_equations_1_to_3():
    rng = np.random.default_rng(2)
    normals, _ = kernels.icosphere(80)
    directions, solid_angles = kernels.icosphere(320)
    radiance = rng.uniform(size=(320, 3))
    cosine = np.maximum(normals @ directions.T, 0)
    expected = 0.5 * np.array([1, 2, 3]) * (cosine @ (radiance * solid_angles[:, None]))
    received = kernels.sum_over_sources(
        normals, directions, radiance, solid_angles, k_d=0.5, C=(1, 2, 3)
    )
    np.testing.assert_allclose(received, expected, rtol=1e-12)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: kernels.icosphere(100), r"20 \* 4\^k faces .* got 100"),
        (lambda: kernels.radical_inverse(1, 1), r"base of at least 2; got 1"),
        (lambda: kernels.radical_inverse(-1), r"index must be a whole number, 0 or more; got -1"),
        (lambda: kernels.direction_to_uv([[0, 2, 0]]), r"direction 0 has length 2; .* unit vector"),
        (lambda: kernels.direction_to_uv([[0, 1]]), r"shape \(n, 3\); got \[1, 2\]"),
        (lambda: kernels.uv_to_direction([[0, np.nan]]), r"uv must be finite; row 0 holds NaN"),
        (lambda: kernels.uv_to_direction([["a", "b"]]), r"uv must hold real numbers; got .*<U1"),
        (lambda: kernels.pixel_directions(1, 2), r"at least 2 rows and 2 columns; got 1 rows of 2"),
        (lambda: kernels.hammersley(2.5), r"n must be a whole number, 0 or more; got 2.5"),
        (
            lambda: kernels.sum_over_sources([[0, 1, 0]], [[0, 1, 0]], [[1, 1, 1]], [1, 1]),
            r"solid_angles must have as many rows as directions \(1\); got 2",
        ),
        (lambda: lit_up(k_d=np.nan), r"k_d must be a finite number, 0 or more; got nan"),
        (lambda: lit_up(C=(1, 1)), r"C must be three numbers; got the shape \(2,\)"),
        (lambda: under_rig([[1, 1]]), r"irradiance must have the shape \(n, 3\); got \[1, 2\]"),
        (lambda: under_rig([[1, 1, 1]] * 2), r"as many rows as directions \(1\); got 2"),
        (lambda: under_rig([[1, 1, np.nan]]), r"irradiance must be finite; row 0 holds NaN"),
        (
            lambda: kernels.relative_rms([[1, 1]], [[1, 1]], [1]),
            r"wanted must have the shape \(n, 3\)",
        ),
        (
            lambda: kernels.relative_rms(UP, UP, [-1]),
            r"weights must not be negative; row 0",
        ),
        (lambda: kernels.relative_rms(UP, [[0, np.inf, 0]], [1]), r"wanted must be finite; row 0"),
        (
            lambda: under_map(np.nan),
            r"finite and not negative; row 5 holds NaN.* 1 are NaN",
        ),
        (
            lambda: under_map(np.inf),
            r"radiance must be finite .* row 5 holds inf.* 0 are NaN, 1 inf",
        ),
        (
            # Smaller maps are summed in double precision.
            lambda: kernels.irradiance(np.tile(BRIGHTEST, (4, 4, 1)), UP),
            r"too large to be summed in single precision",
        ),
        (lambda: kernels.working_irradiance(BRIGHTEST, UP), r"too large to be summed"),
        (lambda: kernels.reduced_luminance(BRIGHTEST, 8), r"too large to be summed"),
        (
            lambda: kernels.working_irradiance(BRIGHTEST, UP, source_fraction=-1),
            r"source_fraction must be",
        ),
    ],
)
def test_bad_input_is_refused_by_name(call, message):
    with pytest.raises(el.EnvLightsError, match=message):
        call()


@pytest.mark.parametrize("kernel", [kernels.pixel_directions, kernels.pixel_solid_angles])
def test_an_array_beyond_memory_is_refused_as_numpy_does(kernel):
    with pytest.raises(MemoryError, match="no memory for an array of the shape"):
        kernel(2**28, 2**28)


UP = [[0, 1, 0]]
BRIGHTEST = np.full((16, 32, 3), np.finfo(np.float32).max)


def lit_up(**options):
    return kernels.sum_over_sources(UP, UP, [[1, 1, 1]], [1], **options)


def under_rig(irradiance):
    return kernels.rig_irradiance(UP, [0, 0, 0], UP, irradiance)


def under_map(sample):
    radiance = np.ones((16, 32, 3), np.float32)
    radiance[5, 7, 1] = sample
    return kernels.irradiance(radiance, UP)


FORKED = """
import os, signal
import numpy as np
import envlights as el

env = el.EnvMap(np.ones((16, 32, 3)))
before = env.probe([[0, 1, 0]])
el.kernels.probe_model([1] * 8, [[0, 1, 0]])
child = os.fork()
if not child:
    signal.alarm(20)  # ends it where it waits for threads that it does not have
    el.fit(env, 1), el.detect(env), el.papers.loghin.detect(env, working_width=16)
    el.papers.madsen.fit(el.synthetic.hall(16).radiance, 1)
    el.kernels.probe_model([1] * 8, [[0, 1, 0]])
    el.kernels.sum_over_sources(*[[[0, 1, 0]]] * 3, [1])
    room = el.synthetic.room(4, width=16)
    model = el.TransferModel.fit(room.direct, room.indirect, rank=2)
    model.compressed(0.1).predict(room.direct)
    os._exit(0 if np.array_equal(env.probe([[0, 1, 0]]), before) else 3)
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_forked_process_has_threads_of_its_own():
    subprocess.run([sys.executable, "-c", FORKED], check=True)


def test_only_samples_that_no_light_can_have_are_cleaned():
    """A map is run again if it was cleaned, and not for any other refusal."""
    runs = []

    def work(env):
        runs.append(env)
        return kernels.working_irradiance(env.radiance, UP)

    with pytest.raises(el.EnvLightsError, match=r"too large to be summed"):
        apply_to_map(BRIGHTEST, work)
    assert len(runs) == 1
    damaged = np.ones((16, 32, 3), np.float32)
    damaged[5, 7] = np.nan, -1, 2
    env, (irradiance, _) = apply_to_map(damaged, work)
    assert len(runs) == 3
    assert np.isfinite(irradiance).all()
    assert env.notes == (
        "1 negative sample set to 0",
        "1 NaN sample set to the mean of the neighbours",
    )


def test_opposite_normals_differ_by_the_flux_of_the_working_map():
    radiance = np.random.default_rng(3).uniform(size=(32, 64, 3)).astype(np.float32)
    front = kernels.uniform_sphere(kernels.hammersley(40))
    both, _ = kernels.working_irradiance(radiance, np.concatenate([front, -front]))
    axes, _ = kernels.working_irradiance(radiance, np.concatenate([np.eye(3), -np.eye(3)]))
    flux = axes[:3] - axes[3:]
    np.testing.assert_allclose(both[:40] - both[40:], front @ flux, atol=1e-12)
    alone = np.concatenate([kernels.working_irradiance(radiance, [n])[0] for n in -front])
    np.testing.assert_allclose(both[40:], alone, rtol=1e-5)


@pytest.mark.parametrize("unit", [1e-300, 1e-160, 1, 1e160, 1e300])
def test_relative_rms_has_no_unit(unit):
    rng = np.random.default_rng(0)
    seen, wanted, weights = (rng.random(shape) for shape in [(5, 3), (5, 3), 5])
    squares = [(weights @ values**2).sum() for values in (seen - wanted, wanted)]
    error = np.sqrt(squares[0] / squares[1])
    found = [
        kernels.relative_rms(unit * seen, unit * wanted, weights),
        kernels.relative_rms(seen, wanted, unit * weights),
    ]
    np.testing.assert_allclose(found, error, rtol=1e-14)


def test_relative_rms_of_numbers_as_far_apart_as_floats_go():
    assert kernels.relative_rms(UP, [[0, 1e300, 0]], [1]) == 1
    assert kernels.relative_rms([[0, 1.7e308, 0]], [[0, -1.7e308, 0]], [1.7e308]) == 2
    assert kernels.relative_rms([[0, 1e100, 0]], [[0, 1e-100, 0]], [1]) == pytest.approx(1e200)
    # What has no weight counts for nothing, however large.
    one, other = [[1.5, 1.5, 1.5], [0, 0, 0]], [[1, 1, 1], [1e170, 0, 0]]
    assert kernels.relative_rms(one, other, [1, 0]) == pytest.approx(0.5)


def test_harmonic_irradiance_is_that_of_a_rig():
    normals, _ = kernels.icosphere(80)
    coefficients = np.random.default_rng(4).normal(size=(9, 3))
    nothing = np.zeros((0, 3))
    wanted = kernels.rig_irradiance(normals, coefficients, nothing, nothing)
    found = kernels.harmonic_irradiance(normals) @ coefficients
    np.testing.assert_allclose(found, wanted, rtol=1e-12, atol=1e-14)
