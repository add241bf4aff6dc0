"""Pictures of overlays, and of the still life in closed form."""

import importlib.util

import numpy as np
import pytest

import envlights as el
from envlights import plot
from envlights.scene.still_life import closed_still

LIGHTS = el.Lights([[0.48, 0.8, 0.36], [-0.6, 0.64, -0.48]], [[3, 2, 1], [1, 1.5, 2]], [0.05, 0.4])
RIG = el.Rig([0.1, 0.2, 0.3], LIGHTS, error=0.0)
MAP = np.ones((4, 8, 3))


def test_titles_hold_the_errors_of_blending():
    overlay = el.scene.shadow_overlay(RIG, el.scene.Ball((0, 0.5, 0), 0.5), columns=32)
    titles = [axes.get_title() for axes in plot.overlay_picture(overlay).axes]
    assert titles[:4] == ["all shadows", "ambient alone", "light 1 alone", "light 2 alone"]
    for name, (_, largest) in overlay.code_errors().items():
        assert f"{name}: largest error {largest:.1f}" in titles


def test_only_pictures_are_drawn():
    rows = el.scene.shadow_overlay(RIG, el.scene.Ball((0, 0.5, 0), 0.5), [[0, 0, 0]])
    with pytest.raises(el.EnvLightsError, match="only the overlay of a picture can be drawn"):
        plot.overlay_picture(rows)
    with pytest.raises(el.EnvLightsError, match="overlay must be ShadowOverlay; got Rig"):
        plot.overlay_picture(RIG)


def test_without_mitsuba_the_scene_is_drawn_in_closed_form(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    drawn, requested = (plot.scene(MAP, RIG, RIG, **which) for which in ({}, CLOSED))
    assert [axes.get_title() for axes in drawn.axes] == ["ambient + 2 lights with sizes"] * 2
    for one, other in zip(drawn.axes, requested.axes, strict=True):
        np.testing.assert_array_equal(one.images[0].get_array(), other.images[0].get_array())


CLOSED = {"renderer": "closed form"}


def test_lights_add_up_and_the_view_turns_with_the_azimuth():
    sky = el.Rig(RIG.ambient, LIGHTS[:0], error=0.0)
    alone = [el.Rig([0, 0, 0], LIGHTS[k : k + 1], error=0.0) for k in (0, 1)]
    parts = sum(closed_still(rig, 0.4) for rig in (sky, *alone))
    np.testing.assert_allclose(parts, closed_still(RIG, 0.4), rtol=1e-9)
    turn = 0.9
    about_y = [[np.cos(turn), 0, -np.sin(turn)], [0, 1, 0], [np.sin(turn), 0, np.cos(turn)]]
    turned = closed_still(RIG.rotated(about_y), 0.4 + turn)
    np.testing.assert_allclose(turned, closed_still(RIG, 0.4), rtol=1e-6)


def test_what_has_no_closed_form_is_refused():
    harmonics = el.Rig(np.ones((9, 3)), LIGHTS, error=0.0)
    with pytest.raises(el.EnvLightsError, match="needs a rig with a constant ambient term"):
        plot.scene(MAP, harmonics, **CLOSED)
    with pytest.raises(el.EnvLightsError, match="renderer must be"):
        plot.scene(MAP, RIG, renderer="blender")


@pytest.mark.slow
@pytest.mark.mitsuba
def test_the_closed_form_is_near_a_path_tracer():
    pytest.importorskip("mitsuba")
    from envlights.scene.still_life import Still, still_life

    truth = still_life(RIG, 1.0, 64, 0)
    image = closed_still(RIG, 1.0)
    assert Still(image, image).error(truth) < 0.05
