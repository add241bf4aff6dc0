"""Matrices to linear Rec.709, against published values and the definition of white."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from envlights.environment.colour import primaries
from envlights.environment.colour.primaries import (
    ACES_AP0,
    ACES_AP1,
    ADOBE_RGB,
    DISPLAY_P3,
    PROPHOTO,
    REC709,
    REC2020,
    are_unsaid,
    columns_to_rec709,
    to_rec709,
    xyz_to_rec709,
)


@pytest.mark.parametrize(
    ("chromaticities", "colour", "expected"),
    [
        (DISPLAY_P3, [0.9, 0.1, 0.1], [1.080, 0.066, 0.084]),
        (ADOBE_RGB, [0.2, 0.6, 0.2], [0.041, 0.600, 0.183]),
        (REC2020, [1000, 500, 200], [1352, 440, 155]),
        (ACES_AP1, [200, 800, 300], [-258, 883, 238]),
    ],
)
def test_colours_become_their_published_values(chromaticities, colour, expected):
    found = to_rec709(chromaticities) @ np.asarray(colour)
    np.testing.assert_allclose(found[1:], expected[1:], rtol=0.01, atol=1e-3)
    assert found[0] < 0 if expected[0] < 0 else found[0] == pytest.approx(expected[0], rel=0.02)


def test_display_p3_has_the_matrix_that_apple_publishes():
    expected = [[1.2249, -0.2247, 0], [-0.0420, 1.0419, 0], [-0.0197, -0.0786, 1.0979]]
    np.testing.assert_allclose(to_rec709(DISPLAY_P3), expected, atol=4e-4)


@pytest.mark.parametrize("space", [DISPLAY_P3, ADOBE_RGB, REC2020, ACES_AP0, ACES_AP1, PROPHOTO])
def test_grey_stays_grey(space):
    np.testing.assert_allclose(to_rec709(space) @ np.ones(3), np.ones(3), atol=1e-12)


def test_primaries_near_rec709_need_no_matrix():
    assert to_rec709(REC709) is None
    assert to_rec709(np.array(REC709) + 9e-4) is None
    assert to_rec709(np.array(REC709) + 3e-3) is not None


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ((0.3, 0.3, 0.4, 0.4, 0.5, 0.5, 0.3127, 0.329), "line"),
        ((0.3,) * 8, "line"),
        ((*REC709[:6], 0.3127, 0.0), "luminance"),
        ((*REC709[:6], 0.9, 0.05), "outside"),
        ((*REC709[:7], np.nan), "finite"),
        (REC709[:6], "eight"),
    ],
)
def test_impossible_primaries_are_refused(values, reason):
    with pytest.raises(ValueError, match=reason):
        to_rec709(values)


def test_zeros_and_the_default_of_radiance_say_nothing():
    assert are_unsaid((0,) * 8)
    assert are_unsaid((0.64, 0.33, 0.29, 0.6, 0.15, 0.06, 0.333, 0.333))
    assert are_unsaid((0.64, 0.33, 0.29, 0.6, 0.15, 0.06, 0.3333, 0.3333))
    assert not are_unsaid(REC2020)
    assert not are_unsaid((0.64, 0.33, 0.29, 0.6, 0.15, 0.06, 0.3127, 0.329))


def test_xyz_of_d65_is_grey():
    x, y = REC709[6:]
    white = np.array([x / y, 1, (1 - x - y) / y])
    np.testing.assert_allclose(xyz_to_rec709() @ white, np.ones(3), atol=1e-12)


def test_columns_of_srgb_profiles_need_no_matrix():
    columns = np.array(
        [[0.4361, 0.3851, 0.1431], [0.2225, 0.7169, 0.0606], [0.0139, 0.0971, 0.7141]]
    )
    assert columns_to_rec709(columns) is None
    with pytest.raises(ValueError, match="white"):
        columns_to_rec709(-columns)
    with pytest.raises(ValueError, match="line"):
        columns_to_rec709(np.ones((3, 3)))


@given(st.lists(st.floats(-0.1, 1.1), min_size=8, max_size=8))
def test_any_primaries_give_a_finite_matrix_or_a_reason(values):
    try:
        matrix = to_rec709(values)
    except ValueError:
        return
    assert matrix is None or np.isfinite(matrix).all()


def test_named_primaries_are_eight_numbers():
    for name in ("REC709", "DISPLAY_P3", "DCI_P3", "ADOBE_RGB", "PROPHOTO"):
        assert len(getattr(primaries, name)) == 8
