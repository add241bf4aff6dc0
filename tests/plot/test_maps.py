"""Pictures of a map with its lights: arguments, and display in notebooks."""

import io
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.image import imread

import envlights as el
from envlights import plot
from envlights._common.srgb import decode_srgb, encode_srgb
from envlights.plot.ball import ball
from envlights.plot.markers import draw_discs, draw_numbers
from envlights.plot.outlines import outlines

HALL = el.EnvMap(el.synthetic.hall(64).radiance)


@pytest.mark.parametrize(
    ("draw", "lights"),
    [
        (plot.picture, el.fit(HALL, lights=2)),
        (plot.detection_picture, el.detect(HALL)),
        (plot.split_picture, el.split(HALL)),
    ],
)
def test_a_picture_of_an_array_is_that_of_its_map(draw, lights):
    of_map, of_array = draw(HALL, lights), draw(np.array(HALL.radiance), lights)
    pixels = [imread(io.BytesIO(each._repr_png_())) for each in (of_map, of_array)]
    np.testing.assert_array_equal(*pixels)
    assert pixels[0].std() > 0.05  # something is drawn


def test_the_title_says_which_normals_the_error_is_of():
    title = plot.picture(HALL, el.fit(HALL, lights=1, floor=True)).get_suptitle()
    assert " % over a floor" in title
    rig = el.Rig([1, 1, 1], el.Lights([[0, 1, 0]], [[1, 1, 1]]), error=0.5)
    assert "ambient + 1 light: relative RMS error 50 %" in plot.picture(HALL, rig).get_suptitle()


def test_no_light_and_no_number_hides_the_eye():
    on_map = plot.picture(HALL, el.fit(HALL, lights=4)).axes[0]
    *others, eye = on_map.collections
    assert len(eye.get_offsets()) == 1
    assert len(on_map.texts) == 4
    assert eye.zorder > max(each.zorder for each in (*others, *on_map.texts))


def test_the_title_names_harmonics():
    rig = el.fit(HALL, lights=1, ambient="sh2")
    assert plot.picture(HALL, rig).get_suptitle().startswith("harmonics + 1 light: ")


def test_the_title_has_the_error_with_shadows_where_it_was_measured():
    rig = el.fit(HALL, lights=1)
    told = replace(rig, report=replace(rig.report, shadow_error=0.0312))
    assert " %, with shadows 3.12 %" in plot.picture(HALL, told).get_suptitle()


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
    (rim,) = (each for each in on_map.collections if isinstance(each, LineCollection))
    parts = [path.vertices for path in rim.get_paths()]
    seen = np.concatenate(parts)
    assert len(seen) > 350
    towards = el.kernels.uv_to_direction((seen - (0, 90)) / (360, -180))
    np.testing.assert_allclose(towards @ direction, np.cos(0.4), atol=1e-9)
    # No line runs across the map.
    assert max(np.abs(np.diff(part[:, 0])).max() for part in parts) < 180


def test_outlines_run_along_the_borders_of_pixels():
    radiance = np.full((32, 64, 3), 0.1, np.float32)
    radiance[5:9, 20:26] = 9
    figure = plot.detection_picture(radiance, el.detect(radiance, extent=0.5))
    (outline,) = (each for each in figure.axes[0].collections if isinstance(each, LineCollection))
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
    # The disc with its ring, and the eye.
    ring, disc, eye = (each.get_offsets() for each in on_map.collections)
    np.testing.assert_allclose([*ring, *disc], [[90, 30], [90, 30]])
    np.testing.assert_allclose(eye, [[150, 5.4]], atol=0.01)
    middle = slice(72, 120), slice(72, 120)
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


def segments(number):
    """Unit edges between pixels of different numbers, by their own borders."""
    height, width = number.shape
    found = set()
    for row in range(height):
        for column in range(width):
            here = number[row, column]
            left = number[row, column - 1] if column else 0
            above = number[row - 1, column] if row else 0
            if here != left:
                found.add((column, row, column, row + 1))
            if here != above:
                found.add((column, row, column + 1, row))
            if column == width - 1 and here:
                found.add((width, row, width, row + 1))
            if row == height - 1 and here:
                found.add((column, height, column + 1, height))
    return found


def test_outlines_are_the_edges_between_pixels_of_different_lights():
    number = np.random.default_rng(3).integers(0, 3, (7, 9))
    drawn = set()
    for (x, y), (to_x, to_y) in outlines(number).astype(int):
        assert (x == to_x) != (y == to_y)
        assert to_x >= x
        assert to_y >= y
        if x == to_x:
            drawn |= {(x, row, x, row + 1) for row in range(y, to_y)}
        else:
            drawn |= {(column, y, column + 1, y) for column in range(x, to_x)}
    assert drawn == segments(number)
    assert len(outlines(np.zeros((3, 4), int))) == 0


def crowd(count):
    """Detected lights beside each other, as a city at night has them."""
    radiance = np.full((256, 512, 3), 0.1, np.float32)
    rows, columns = np.divmod(np.arange(count), 40)
    radiance[90 + 14 * rows, 8 + 12 * columns] = 9 + np.arange(count)[:, None]
    return el.EnvMap(radiance)


def test_numbers_neither_overlap_nor_leave_the_map_and_the_brightest_have_one():
    env = crowd(160)
    lights = el.detect(env)
    assert len(lights) == 160
    figure = plot.detection_picture(env, lights)
    figure.canvas.draw()
    (axes,) = figure.axes
    frame = axes.get_window_extent()
    boxes = [text.get_window_extent() for text in axes.texts]
    assert "1" in [text.get_text() for text in axes.texts]
    assert len(boxes) > 5
    for number, box in enumerate(boxes):
        assert frame.x0 <= box.x0 <= box.x1 <= frame.x1
        assert frame.y0 <= box.y0 <= box.y1 <= frame.y1
        assert not any(box.overlaps(other) for other in boxes[:number])


def test_the_picture_of_loghin_links_each_sample_to_its_light():
    found = el.papers.loghin.detect(HALL)
    (axes,) = plot.detection_picture(HALL, found).axes
    (links,) = (each for each in axes.collections if isinstance(each, LineCollection))
    assert 0 < len(links.get_segments()) <= len(found.members.pixel)
    assert "samples, linked to their light" in [
        text.get_text() for text in axes.get_legend().get_texts()
    ]


def test_numbers_cover_no_disc_with_or_without_a_number():
    rng = np.random.default_rng(4)
    at = np.stack([rng.uniform(0, 360, 300), rng.uniform(-30, 30, 300)], axis=1)
    figure = plot.map_picture(HALL)
    (axes,) = figure.axes
    draw_discs(axes, at, np.full(300, 14.0), np.ones((300, 3)))
    draw_numbers(axes, at, np.full(300, 14.0))
    figure.canvas.draw()
    rings = axes.collections[0]
    middle = axes.transData.transform(rings.get_offsets())
    radius = np.sqrt(rings.get_sizes() / np.pi)[:, None] * figure.dpi / 72
    assert len(axes.texts) > 5
    for box in (text.get_window_extent() for text in axes.texts):
        apart = np.abs(middle - (box.p0 + box.p1) / 2) - (box.p1 - box.p0) / 2
        assert (apart > radius).any(axis=1).all()


def test_every_light_is_one_entry_of_the_same_few_artists():
    """Time and memory do not grow with an artist for each light."""
    one, many = (plot.detection_picture(crowd(n), el.detect(crowd(n))) for n in (1, 160))
    kinds = [type(each) for each in one.axes[0].collections]
    assert [type(each) for each in many.axes[0].collections] == kinds
    assert len(many.axes[0].texts) <= 40


def test_the_exposure_is_stated_and_leaves_the_lamps_brighter_than_the_sky():
    figure = plot.map_picture(el.synthetic.hall(64).radiance)
    assert "white is luminance" in figure.get_suptitle()
    pixels = figure.axes[0].images[0].get_array()
    assert 0.005 < (pixels >= 250).any(axis=2).mean() < 0.05


def test_stops_count_powers_of_two_from_white():
    radiance = np.full((32, 64, 3), 1.0)
    radiance[:8], radiance[24:] = 1 / 4, 0
    drawn = plot.map_picture(radiance, stops=True).axes[0].images[0].get_array()
    # White is 2.5 times the median.
    np.testing.assert_allclose(2.0 ** drawn[[0, 16], 0], [0.1, 0.4], rtol=1e-6)
    assert drawn[31, 0] < -100
    with pytest.raises(el.EnvLightsError, match="stops must be True or False; got 1"):
        plot.map_picture(radiance, stops=1)


def test_rims_of_probes_are_smooth():
    """A ball covers pi / 4 of its square, in parts of pixels."""
    seen = ball(np.array([0.6, 0.0, 0.8]))
    size = len(seen.inside)
    np.testing.assert_allclose(seen.cover.sum() / size**2, np.pi / 4, rtol=1e-3)
    assert ((seen.cover > 0.1) & (seen.cover < 0.9)).sum() > size
    np.testing.assert_allclose(np.linalg.norm(seen.normals, axis=1), 1)
    assert (seen.normals @ [0.6, 0, 0.8] >= -1e-12).all()


def test_a_long_reason_does_not_cover_the_map():
    lights = el.detect(HALL)
    figure = plot.detection_picture(
        HALL, replace(lights, report=replace(lights.report, reason="brightest of all " * 20))
    )
    figure.draw_without_rendering()
    (axes,) = figure.axes
    assert figure.get_suptitle().endswith("is darker")
    assert figure._suptitle.get_window_extent().y0 >= axes.get_tightbbox().y1


@pytest.mark.parametrize(
    ("draw", "given", "told"),
    [
        (plot.picture, el.Lights([[0, 1, 0]], [[1, 1, 1]]), "rig must be Rig; got Lights"),
        (plot.detection_picture, None, "lights must be DetectedLights; got NoneType"),
        (plot.sphere_picture, HALL, "lights must be Lights; got EnvMap"),
        (plot.split_picture, HALL, "parts must be Split; got EnvMap"),
    ],
)
def test_something_else_in_place_of_lights_is_refused(draw, given, told):
    with pytest.raises(el.EnvLightsError, match=told):
        draw(HALL, given)


def test_only_figures_are_saved(tmp_path):
    for given in ("map.png", HALL):
        with pytest.raises(el.EnvLightsError, match="figure must be Figure; got "):
            plot.save(given, tmp_path / "map.png")
    assert not list(tmp_path.iterdir())


def test_false_colours_say_which_luminance_is_white():
    figure = plot.map_picture(HALL, stops=True)
    white = float(figure.get_suptitle().split()[-1])
    exposed = plot.map_picture(HALL).get_suptitle()
    assert f"white is luminance {white:.3g};" in exposed
    # A pixel at white lies at 0 stops.
    (image,) = figure.axes[0].images
    luminance = HALL.radiance @ np.array([0.2126, 0.7152, 0.0722])
    np.testing.assert_allclose(image.get_array(), np.log2(luminance / white), atol=0.01)


def test_a_split_says_how_bright_the_map_was_and_is():
    parts = el.split(HALL)
    titles = [axes.get_title() for axes in plot.split_picture(HALL, parts).axes]
    for title, env in zip(titles, (HALL, parts.remainder), strict=False):
        largest = (env.radiance @ np.array([0.2126, 0.7152, 0.0722])).max()
        assert float(title.rsplit(" ", 1)[1]) == pytest.approx(largest, rel=5e-3)
