"""Pictures of several rigs, of errors, the sphere, the article's steps and the basis."""

from functools import cache, partial

import numpy as np
import pytest

import envlights as el
from envlights import plot
from tests.helpers import pairs_of_room

HALL = el.EnvMap(el.synthetic.hall(128).radiance)
EXACT = el.Rig([1, 1, 1], el.Lights(np.zeros((0, 3)), np.zeros((0, 3))), error=0.0)
room = partial(pairs_of_room, 24, 16)


@cache
def fitted_rigs():
    return [el.fit(HALL, lights=n) for n in (1, 3)]


@cache
def model():
    return el.TransferModel.fit(room().direct, room().indirect, rank=12)


def test_each_rig_has_a_row_with_its_error():
    figure = plot.rigs_picture(HALL, *fitted_rigs())
    titles = [axes.get_title() for axes in figure.axes]
    assert [title for title in titles if title.startswith("ambient")] == [
        rig.in_short() for rig in fitted_rigs()
    ]


def test_the_curve_is_that_of_the_report_and_the_ring_the_rig():
    axes = plot.error_picture(*fitted_rigs()).axes[0]
    for rig, curve, ring in zip(fitted_rigs(), axes.lines[::2], axes.lines[1::2], strict=True):
        tried = np.array(list(rig.report.search_errors.items()))
        np.testing.assert_allclose(curve.get_xydata(), tried * (1, 100))
        np.testing.assert_allclose(ring.get_xydata(), [[len(rig.lights), 100 * rig.error]])
    assert plot.error_picture(EXACT)._repr_png_()


@pytest.mark.parametrize(
    ("given", "seen"),
    [((), "none"), ((HALL,), "EnvMap"), ((EXACT, None), "NoneType"), (([EXACT],), "list")],
)
def test_what_is_no_rig_is_refused(given, seen):
    for draw in (plot.error_picture, partial(plot.rigs_picture, HALL)):
        with pytest.raises(
            el.EnvLightsError, match=f"one rig or more, each an argument; got {seen}"
        ):
            draw(*given)


def test_every_light_is_on_one_side_of_the_sphere():
    lights = el.detect(HALL)
    sides = [axes.collections[-1].get_offsets() for axes in plot.sphere_picture(HALL, lights).axes]
    assert sum(map(len, sides)) == len(lights)
    assert all((np.hypot(*at.T) <= 1).all() for at in sides)
    assert plot.sphere_picture(HALL, lights[:0])._repr_png_()


def test_the_map_lies_on_the_sphere_as_it_is_seen_from_outside():
    """A sphere that is red towards +x and blue towards -x, from +z: +x is at the right."""
    towards = el.kernels.pixel_directions(64, 128)
    radiance = np.stack([towards[..., 0] > 0, 0 * towards[..., 0], towards[..., 0] < 0], axis=2)
    figure = plot.sphere_picture(radiance.astype(float), el.Lights([[0, 0.0, 1]], [[1.0, 1, 1]]))
    pixels = figure.axes[0].images[0].get_array()
    middle = len(pixels) // 2
    assert pixels[middle, -30, 0] > 0.5 > pixels[middle, -30, 2]
    assert pixels[middle, 30, 2] > 0.5 > pixels[middle, 30, 0]


def test_the_steps_of_loghin_count_what_the_detector_found():
    lights = el.papers.loghin.detect(HALL)
    figure = plot.loghin_picture(HALL)
    titles = [axes.get_title() for axes in figure.axes]
    assert titles[1].startswith(f"2. bright samples: {len(lights.members.pixel)},")
    assert titles[3].startswith(f"4. lights: {len(lights)}")
    few = plot.loghin_picture(HALL, lights=1)
    assert few.axes[3].get_title().startswith("4. lights: 1")
    dark = plot.loghin_picture(np.full((16, 32, 3), 0.01))
    assert dark.axes[3].get_title().startswith("4. lights: 0")


def test_the_spectrum_tells_how_many_directions_hold_a_share():
    shares = [
        [float(text.get_text().split(" %")[0]), text.get_text().split(": ")[1].split()[0]]
        for text in plot.spectrum_picture(model()).axes[0].get_legend().get_texts()
    ]
    for percent, needed in shares:
        enough = el.TransferModel.fit(room().direct, room().indirect, rank=percent / 100)
        assert needed == (str(enough.report.rank) if enough.report.rank <= 12 else "more")


def test_the_basis_is_drawn_direction_by_direction():
    images = [
        axes.images[0] for axes in plot.basis_picture(model(), directions=5).axes if axes.images
    ]
    assert len(images) == 5
    for image, wanted in zip(images, model().directions(5), strict=True):
        np.testing.assert_array_equal(image.get_array(), wanted)
        low, high = image.get_clim()
        assert low == -high


def test_a_number_stands_beside_its_disc_on_the_small_map_of_a_row():
    figure = plot.rigs_picture(HALL, *fitted_rigs())
    figure.draw_without_rendering()
    rows = [axes for axes in figure.axes if axes.get_title().startswith("ambient")]
    for axes, rig in zip(rows, fitted_rigs(), strict=True):
        discs = axes.collections[-1]
        assert len(axes.texts) == len(rig.lights)
        for text, at, area in zip(axes.texts, discs.get_offsets(), discs.get_sizes(), strict=True):
            box = text.get_window_extent()
            middle = axes.transData.transform(at)
            nearest = np.clip(middle, box.min, box.max)
            radius = np.sqrt(area / np.pi) * figure.dpi / 72
            assert np.hypot(*(nearest - middle)) >= radius


def test_all_probes_of_a_picture_are_seen_from_one_place():
    one, other = (
        [
            axes
            for axes in plot.rigs_picture(HALL, *rigs).axes
            if "under the map" in axes.get_title()
        ]
        for rigs in (fitted_rigs(), fitted_rigs()[:1])
    )
    for axes in one:
        np.testing.assert_array_equal(axes.images[0].get_array(), other[0].images[0].get_array())
