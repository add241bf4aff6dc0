"""What refusals show of what they were given."""

from pathlib import Path

import numpy as np
import pytest

from envlights._check import first_not_finite, shown


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
    assert shown(value) == text


def test_the_first_sample_that_is_not_finite_is_found_by_rows():
    image = np.zeros((3, 4, 3))
    assert first_not_finite(image) is None
    image[2, 0, 0], image[1, 3, 2] = np.nan, np.inf
    assert first_not_finite(image) == (1, 3, np.inf)
