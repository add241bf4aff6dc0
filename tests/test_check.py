"""Values in the messages of refusals."""

from pathlib import Path

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from envlights._common.check import describe, first_not_finite, float_image, reals, whole_numbers

MAP = np.random.default_rng(0).random((8, 16, 3), dtype=np.float32)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (3, "3"),
        (np.float32(0.5), "0.5"),
        (None, "None"),
        ("even", "'even'"),
        (Path("room/a.exr"), "'room/a.exr'"),
        ((3, "x"), "(3, 'x')"),
        ((slice(0.5), slice(2, None)), "(:0.5, 2:)"),
        (["a"] * 5, "an object of the type list"),
        ({"a": 1}, "an object of the type dict"),
    ],
)
def test_a_refusal_shows_no_python_repr(value, text):
    assert describe(value) == text


def test_the_first_sample_that_is_not_finite_is_found_by_rows():
    image = np.zeros((3, 4, 3))
    assert first_not_finite(image) is None
    image[2, 0, 0], image[1, 3, 2] = np.nan, np.inf
    assert first_not_finite(image) == (1, 3, np.inf)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: kernels.irradiance(MAP, np.eye(3), border_sampled=1),
            "border_sampled must be True",
        ),
        (lambda: kernels.pixel_directions(2, 4, border_sampled="x"), "border_sampled must be True"),
        (
            lambda: kernels.neighbour_maximum(MAP[..., 0], [[0, 0]], 1, sphere=1),
            "sphere must be True",
        ),
        (lambda: kernels.halton(3, 2), "bases must be a sequence of whole numbers; got 2"),
        (
            lambda: kernels.halton(3, "23"),
            "bases must be a sequence of whole numbers; got '23'",
        ),
        (lambda: kernels.halton(3, [2.5]), "bases must be a whole number"),
        (lambda: el.EnvMap(MAP, notes=5), "notes must be text; got 5"),
        (lambda: el.EnvMap(MAP, notes=["seen", None]), "notes must be text; got None"),
        (
            lambda: el.papers.madsen.fit(MAP, 2, k_a=1e300),
            r"k_a must be .* from 0 to 1e\+100; got 1e\+300",
        ),
        (
            lambda: el.papers.madsen.fit(MAP, 2, k_d=1e300),
            r"k_d must be .* from 0 to 1e\+100; got 1e\+300",
        ),
        (
            lambda: el.papers.madsen.fit(MAP, 2, C=(1, 1e300, 1)),
            r"C must be at most 1e\+100; got 1e\+300",
        ),
    ],
)
def test_what_is_of_another_kind_is_refused_in_a_sentence(call, message):
    with pytest.raises(el.EnvLightsError, match=message):
        call()


@pytest.mark.parametrize("k_a", [1e-100, 1e100])
def test_the_strongest_reflection_that_is_taken_has_a_finite_error(k_a):
    assert np.isfinite(el.papers.madsen.fit(MAP, 1, k_a=k_a, k_d=1e100).error)


@pytest.mark.parametrize(
    ("check", "dtype"),
    [
        (lambda array: reals("x", array, 2), np.float64),
        (lambda array: float_image("x", array, 2), np.float32),
        (lambda array: whole_numbers("x", array.ravel()), np.int64),
        (lambda array: el.EnvMap(array.reshape(2, 4, 3)).radiance, np.float32),
    ],
)
def test_kernels_get_no_number_at_an_odd_address(check, dtype):
    bytes_ = np.zeros(1 + 24 * np.dtype(dtype).itemsize, np.uint8)
    odd = bytes_[1:].view(dtype).reshape(2, 12)
    assert not odd.flags.aligned
    assert check(odd).flags.aligned


@pytest.mark.parametrize("angles", [90, [0, 90, 0]])
def test_angles_are_no_rotation(angles):
    with pytest.raises(el.EnvLightsError, match=r"a rotation of the shape \(3, 3\), not angles"):
        el.EnvMap(np.ones((4, 8, 3))).rotated(angles)
