"""Gaps between lights, and windows joined from panes."""

import numpy as np
import pytest

import envlights as el
from envlights import synthetic
from envlights.synthetic import Rectangle, scene


@pytest.mark.parametrize("tilt_deg", [0, 50, 90])
@pytest.mark.parametrize(
    "direction",
    [(0, 0, 1), (0, 0.1, -1), (1, 2, 0), (0.05, 1, 0.05), (0, -1, 0)],
    ids=["equator", "seam", "63 degrees", "86 degrees", "pole"],
)
@pytest.mark.parametrize(
    ("bar_deg", "gap_deg", "count"), [(0.75, 0.8, 1), (2.1, 0.8, 1), (2.1, 0, 2), (3.2, 0.8, 2)]
)
def test_a_bar_divides_by_its_angle_wherever_it_is(direction, tilt_deg, bar_deg, gap_deg, count):
    """2.5 degrees is the limit between panes, none without a gap.

    That is to two pixels of 0.35 degrees: near a pole, rows lead around the bar, not across it.
    """
    panes = {"panes": (2, 1), "bar_deg": bar_deg, "tilt_deg": tilt_deg}
    window = Rectangle(direction, 14, 8, (9, 9, 9), **panes)
    radiance = scene(512, background=[0.1] * 3, shapes=[window]).radiance
    assert len(el.detect(radiance, gap_deg=gap_deg)) == count


def test_an_opening_holds_all_flux_of_its_panes_and_the_report_says_what_was_joined():
    window = Rectangle((1, 0.4, 0), 30, 20, (9, 9, 9), panes=(3, 2), bar_deg=1.5)
    radiance = scene(512, background=[0.1] * 3, shapes=[window]).radiance
    panes, opening = el.detect(radiance, gap_deg=0), el.detect(radiance)
    assert (len(panes), len(opening)) == (6, 1)
    np.testing.assert_allclose(opening.flux[0], panes.flux.sum(axis=0), rtol=1e-12)
    (note,) = opening.report.notes
    assert note.startswith("the light at azimuth 90")
    assert note.endswith("is a window joined from 6 panes")


@pytest.mark.slow
def test_openings_are_one_light_each_and_lamps_of_a_row_stay_apart():
    worlds = [synthetic.openings(seed) for seed in range(24)]
    for kind in ("window", "skylight", "sky behind", "row"):
        some = [world for world in worlds if kind in world.note]
        found = [el.detect(world.radiance) for world in some]
        results = zip(some, found, strict=True)
        score = synthetic.evaluate([(world, e.direction, e.flux) for world, e in results])
        assert score.known >= 6
        assert score.f1 >= 0.95, (kind, score)


@pytest.mark.parametrize("tilt_deg", [0, 90])
@pytest.mark.parametrize("height", [256, 300, 512, 1024])
def test_the_gap_is_what_the_option_says(height, tilt_deg):
    """To a pixel, of the working image: its height is 0.35 to 0.7 degrees."""
    pane = {"panes": (2, 1), "bar_deg": 6.0, "tilt_deg": tilt_deg}
    window = Rectangle((0, 0, 1), 24, 14, (9, 9, 9), **pane)
    radiance = scene(height, background=[0.1] * 3, shapes=[window]).radiance
    pixel = 180 / min(height, 512)
    gaps = (0, 6 - 1.2 * pixel, 6 + 0.2 * pixel)
    assert [len(el.detect(radiance, gap_deg=gap)) for gap in gaps] == [2, 2, 1]


def test_suns_beside_each_other_are_joined_only_within_the_gap():
    """One pixel lit, k dark, one lit: the gap is k * 0.35 degrees."""
    for between, count in [(0, 1), (1, 1), (2, 1), (3, 2)]:
        radiance = np.full((512, 1024, 3), 0.1, np.float32)
        radiance[256, [1023, between]] = 100
        assert len(el.detect(radiance)) == count, between
