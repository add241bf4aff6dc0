"""Form factors by rays: closed forms, hidden points, and refusals."""

import numpy as np
import pytest

import envlights as el
from envlights.scene.gather import gather
from envlights.scene.mitsuba.chart_rays import texel_hits
from envlights.scene.triangles import Triangles
from envlights.synthetic.room import room_charts
from tests.reference.rooms import room_prior, room_surface

FLOOR = el.scene.Surface(
    np.concatenate([np.mgrid[:16, :16] / 16 + 1 / 32, np.zeros((1, 16, 16))])[[0, 2, 1]]
    .swapaxes(0, 2)
    .copy(),
    np.tile([0.0, 1.0, 0.0], (16, 16, 1)),
    np.full((16, 16, 3), 0.5),
)


def always(answer):
    return lambda origins, directions: np.full(len(origins), answer)


def lid(origins, directions):
    """A disc of radius 1, 1 above the middle of the floor, seen as texel 3."""
    ends = origins + (1 - origins[:, 1:2]) / directions[:, 1:2] * directions
    inside = np.hypot(ends[:, 0] - 0.5, ends[:, 2] - 0.5) < 1
    return np.where(inside, 3, -1)


def test_the_form_factor_of_a_disc_is_that_of_its_closed_form():
    """At the distance a from the axis of a disc (Howell, B-13)."""
    prior = gather(FLOOR, FLOOR, lid, rays=4096, size=2)
    x, _, z = FLOOR.position.reshape(-1, 3).T
    square = (x - 0.5) ** 2 + (z - 0.5) ** 2
    # Radius and height are 1.
    whole = 2 + square
    truth = (1 - square / np.sqrt(whole**2 - 4 * square)) / 2
    np.testing.assert_allclose(prior.hits[:, 3] / prior.rays, truth, atol=0.01)
    assert not prior.hits[:, :3].any()


def test_an_open_floor_receives_nothing():
    prior = gather(FLOOR, FLOOR, always(-1), rays=16)
    assert not prior.predict(np.ones((16, 16, 3))).any()
    np.testing.assert_array_equal(prior.visible, 1)


def test_rays_to_triangles_of_the_room_count_the_hits_of_rays_to_rectangles():
    """The room's rectangles as two triangles each, by the kernel; NumPy traces the others."""
    corners, flipped = [], []
    for chart in room_charts():
        one, three = chart.origin + chart.columns, chart.origin + chart.rows
        two = one + chart.rows
        corners += [[chart.origin, one, two], [chart.origin, two, three]]
        flipped += 2 * [np.cross(chart.columns, chart.rows) @ chart.normal < 0]
    uv = np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]], float)
    shape = np.repeat(np.arange(16), 2)
    room = Triangles(np.array(corners), np.tile(uv, (16, 1, 1)), shape, np.array(flipped))
    lightmap, points = (el.scene.Surface(*room_surface(width)) for width in (16, 128))
    prior = gather(lightmap, points, texel_hits(room.hits, 16, 128, 16), irradiance=True)
    expected = room_prior(16)
    np.testing.assert_array_equal(prior.hits, expected.hits)
    np.testing.assert_array_equal(prior.between, expected.between)


def test_points_that_see_only_backs_are_hidden():
    def half(origins, directions):
        return np.where(origins[:, 0] < 0.5, -2, 0)

    prior = gather(FLOOR, FLOOR, half, rays=16, size=2)
    np.testing.assert_array_equal(prior.visible, [0, 1, 0, 1])
    assert not prior.between[[0, 2]].any()
    np.testing.assert_allclose(prior.between[[1, 3], 0], 1)


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (always(4), "texel from 0 to 3, .*; got the dtype int64 .* from 4 to 4"),
        (always(-3), "from -3 to -3"),
        (always(0.5), "got the dtype float64"),
        (lambda origins, directions: np.zeros(3, int), r"the shape \(3,\)"),
    ],
)
def test_answers_of_a_ray_tracer_that_are_no_texels_are_refused(answer, message):
    with pytest.raises(el.EnvLightsError, match=message):
        gather(FLOOR, FLOOR, answer, rays=4, size=2)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"rays": 70000}, "rays must be"),
        ({"size": 3}, "multiple of 3 rows and columns; got 16x16"),
        ({"irradiance": 2}, "irradiance must be"),
    ],
)
def test_options_out_of_range_are_refused(options, message):
    with pytest.raises(el.EnvLightsError, match=message):
        gather(FLOOR, FLOOR, always(-1), **{"rays": 4, "size": 2, **options})
