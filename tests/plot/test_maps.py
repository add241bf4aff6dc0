"""Pictures of a map with its lights: what they take, and that any notebook shows them."""

import io
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.image import imread

import envlights as el
from envlights import plot
from envlights._srgb import decode_srgb, encode_srgb

HALL = el.EnvMap(el.synthetic.hall(64).radiance)


@pytest.mark.parametrize(
    ("draw", "lights"),
    [(plot.picture, el.fit(HALL, lights=2)), (plot.detection_picture, el.detect(HALL))],
)
def test_a_picture_of_an_array_is_that_of_its_map(draw, lights):
    of_map, of_array = draw(HALL, lights), draw(np.array(HALL.radiance), lights)
    pixels = [imread(io.BytesIO(each._repr_png_())) for each in (of_map, of_array)]
    np.testing.assert_array_equal(*pixels)
    assert pixels[0].std() > 0.05  # something is drawn


def test_the_title_says_which_normals_the_error_is_of():
    title = plot.picture(HALL, el.fit(HALL, lights=1, normals="upper")).get_suptitle()
    assert "on 5120 upward normals" in title
    rig = el.Rig([1, 1, 1], el.Lights([[0, 1, 0]], [[1, 1, 1]]), error=0.5)
    assert (
        "ambient + 1 light: relative RMS error 50 %, as given"
        in plot.picture(HALL, rig).get_suptitle()
    )


def test_the_title_has_the_error_with_shadows_where_it_was_measured():
    rig = el.fit(HALL, lights=1)
    told = replace(rig, report=replace(rig.report, shadow_error=0.0312))
    assert "normals, with shadows 3.12 %" in plot.picture(HALL, told).get_suptitle()


def test_over_a_floor_the_probe_is_compared_with_the_map_that_the_floor_cuts():
    """A map that is bright below the horizon, and the rig that its upper half asks for."""
    radiance = np.full((64, 128, 3), 0.5)
    radiance[32:] = 9
    rig = el.fit(radiance, lights=0, floor=True)
    assert rig.floor
    for floor, most in ((True, 0.5), (False, 1e3)):
        _, _, _, difference, _ = plot.picture(radiance, replace(rig, floor=floor)).axes
        greatest = np.nanmax(np.abs(difference.images[0].get_array()))
        assert greatest < most
    assert greatest > 50


@pytest.mark.parametrize("direction", [(0, 0, 1), (0, 0, -1), (0, 1, 0), (0.6, 0, 0.8)])
def test_the_rim_of_a_light_is_drawn_where_it_is(direction):
    lights = el.Lights([direction], [[1, 1, 1]], [0.4])
    on_map = plot.picture(HALL, el.Rig([1, 1, 1], lights, error=0.5)).axes[0]
    (rim,) = (line.get_xydata() for line in on_map.lines)
    seen = rim[~np.isnan(rim).any(axis=1)]
    assert len(seen) > 350
    towards = el.kernels.uv_to_direction((seen - (0, 90)) / (360, -180))
    np.testing.assert_allclose(towards @ direction, np.cos(0.4), atol=1e-9)
    # No line runs across the map.
    assert np.nanmax(np.abs(np.diff(rim[:, 0]))) < 180


def test_outlines_run_along_the_borders_of_pixels():
    radiance = np.full((32, 64, 3), 0.1, np.float32)
    radiance[5:9, 20:26] = 9
    figure = plot.detection_picture(radiance, el.detect(radiance, extent=0.5))
    (outline,) = (each for each in figure.axes[0].collections if each.get_paths())
    at = np.concatenate([path.vertices for path in outline.get_paths()])
    degrees = 180 / 32
    np.testing.assert_allclose(at.min(axis=0), [20 * degrees, 90 - 9 * degrees])
    np.testing.assert_allclose(at.max(axis=0), [26 * degrees, 90 - 5 * degrees])


def test_probes_stand_where_their_titles_say_and_lights_where_they_are():
    """A lamp at azimuth 90 degrees, elevation 30, and a rig of another colour."""
    lamp = el.synthetic.Disc((np.cos(np.pi / 6), 0.5, 0), 6, (9, 9, 9))
    env = el.EnvMap(el.synthetic.scene(64, background=[0.1] * 3, shapes=[lamp]).radiance)
    red = el.Rig([0, 0, 0], el.Lights([[np.cos(np.pi / 6), 0.5, 0]], [[1, 0, 0]]), error=0.5)
    on_map, under_map, under_rig, difference, _ = plot.picture(env, red).axes
    np.testing.assert_allclose([line.get_xydata()[0] for line in on_map.lines], [[90, 30]])
    middle = slice(60, 100), slice(60, 100)
    for axes, title, is_grey in ((under_map, "map", True), (under_rig, "rig", False)):
        pixels = axes.images[0].get_array()[middle]
        assert title in axes.get_title()
        assert np.allclose(pixels[..., 0], pixels[..., 1], atol=1e-3) == is_grey
    assert difference.images[0].get_array()[middle].mean() < 0  # the rig is darker


def test_encoded_values_are_those_of_the_standard():
    """IEC 61966-2-1: its codes of black, of the linear part, of a middle grey and of white."""
    linear = [-1.0, 0.0, 0.001, 0.2140411, 1.0, 7.0]
    np.testing.assert_allclose(encode_srgb(np.array(linear)), [0, 0, 0.01292, 0.5, 1, 1], atol=1e-6)


@pytest.mark.parametrize("codes", [256, 65536])
def test_decoding_inverts_encoding(codes):
    coded = np.arange(codes) / (codes - 1)
    again = encode_srgb(decode_srgb(coded).astype(np.float64))
    np.testing.assert_array_equal(np.round(again * (codes - 1)), np.arange(codes))
