"""Descriptions of projections: constructors, axes and refusals."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import envlights as el
from envlights.environment.layouts import picture_layout as layouts
from envlights.environment.layouts.picture_layout import FRONT, MIRRORED, PBRT, PictureLayout
from tests.layouts.worlds import BASES


def test_defaults_are_those_of_the_kernels():
    layout = PictureLayout("cube", 6, 1)
    assert layout[3:] == (False, None, (0, 0), 0.0, None, "", 0.0, None, FRONT)
    assert layouts.equirectangular(4).is_whole_sphere
    assert not layouts.crop(30, 60, field_of_view=math.pi).is_whole_sphere
    assert layouts.octahedral(7, equal_area=True)[:3] == ("octahedral-equal-area", 7, 7)
    assert layouts.cube(8, border_sampled=True)[:4] == ("cube", 48, 8, True)


def test_the_smallest_panorama_has_2_rows():
    layout = layouts.equirectangular(2)
    assert (layout.height, layout.width) == (2, 4)
    assert layouts.equirectangular(2, 2).width == 2


def test_axes_are_orthonormal_and_handed_as_the_picture():
    for axes, handed in ((FRONT, -1), (MIRRORED, 1), (PBRT, 1)):
        rows = np.array(axes)
        np.testing.assert_array_equal(rows @ rows.T, np.eye(3))
        assert np.linalg.det(rows) == pytest.approx(handed)


@given(st.tuples(*[st.floats(-9, 9)] * 3))
def test_a_camera_that_looks_somewhere_is_level(towards):
    if np.linalg.norm(towards) < 1e-3:
        return
    forward, right, up = np.array(layouts.looking(towards))
    np.testing.assert_allclose(
        [forward, right, up] @ np.array([forward, right, up]).T, np.eye(3), atol=1e-12
    )
    np.testing.assert_allclose(forward, np.array(towards) / np.linalg.norm(towards), atol=2e-9)
    assert np.linalg.det([forward, right, up]) == pytest.approx(-1)
    assert abs(right[1]) < 1e-12
    assert up[1] >= -1e-12


def test_cameras_that_look_along_an_axis_are_the_faces_of_a_cube():
    for forward, right, up in BASES:
        np.testing.assert_array_equal(layouts.looking(forward), [forward, right, up])


def test_a_crop_has_the_scale_of_its_panorama():
    layout = layouts.crop(40, 60, field_of_view=math.radians(60), horizon=10)
    assert layout.whole == (180, 360)
    assert layout.corner == (80, 150)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: layouts.equirectangular(1), "height must be a whole number, 2 or more"),
        (lambda: layouts.equirectangular(2, 1), "width must be a whole number, 2 or more"),
        (lambda: layouts.octahedral(7), "an even number of columns; got 7"),
        (lambda: layouts.octahedral(0), "n must be a whole number, 2 or more"),
        (lambda: layouts.fisheye(8, "mercator", 1.0), "mapping must be 'equidistant' or"),
        (lambda: layouts.fisheye(8, "orthographic", 4.0), "from 0.05 to 180"),
        (
            lambda: layouts.fisheye(8, "stereographic", 6.28),
            "fov must be a finite number, from 0.05 to",
        ),
        (
            lambda: layouts.planar(4, 4, field_of_view=math.pi),
            "fov must be a finite number, from 0.05 to",
        ),
        (lambda: layouts.cylinder(4, 4, field_of_view=7), "from 0.05 to 360"),
        (lambda: layouts.cylinder(4, 4, field_of_view=1, horizon=math.nan), "horizon must be"),
        (lambda: layouts.crop(9, 9, field_of_view=6), "reaches beyond a pole"),
        (
            lambda: layouts.looking((0, math.inf, 0)),
            "forward must be three finite numbers, and not all 0",
        ),
        (lambda: layouts.looking((1, 0)), "three finite numbers"),
    ],
)
def test_values_without_a_meaning_are_refused(make, words):
    with pytest.raises(el.EnvLightsError, match=words):
        make()
