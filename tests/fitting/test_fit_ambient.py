"""Lights only where they pay, and the environment that leaves the fewest to be needed."""

import numpy as np
import pytest

import envlights as el
from envlights import kernels


def gradient(slope=0.8):
    """A sky whose radiance is linear in the height: harmonics of order 1 are all of it."""
    height = kernels.pixel_directions(64, 128)[..., 1:2]
    return (1 + slope * height) * [0.8, 0.9, 1.0]


def suns_before(background):
    suns = [el.synthetic.Disc(d, 3, (90, 80, 70)) for d in ((0.6, 0.8, 0.0), (-0.5, 0.6, 0.6))]
    return el.synthetic.scene(128, background=[background] * 3, shapes=suns).radiance


@pytest.mark.parametrize("rows", [64, 128, 256, 512, 1024, 2048])
@pytest.mark.parametrize("ambient", ["constant", "auto"])
def test_a_constant_map_has_no_light_at_any_size(rows, ambient):
    rig = el.fit(np.full((rows, 2 * rows, 3), np.float32(0.7)), ambient=ambient)
    assert len(rig.lights) == 0
    assert rig.report.ambient == "constant"
    np.testing.assert_allclose(rig.ambient, 0.7, rtol=1e-6)
    assert "0 of at most 4 lights used" in rig.report.fewer_lights


def test_no_light_is_added_below_the_error_of_the_rendering():
    """Waves of 1e-4 of the radiance, which lights could follow."""
    waves = 1 + 1e-4 * kernels.pixel_directions(128, 256)[..., :1] ** 3 * np.ones(3)
    rig = el.fit(waves, lights=8)
    assert len(rig.lights) == 0
    assert "the error is already below 1e-4" in rig.report.fewer_lights


@pytest.mark.parametrize("options", [{}, {"error": 0.02}, {"error": 0.001, "lights": 8}])
def test_a_gradient_is_harmonics_without_a_light(options):
    rig = el.fit(gradient(), ambient="auto", **options)
    assert len(rig.lights) == 0
    assert rig.ambient.shape == (9, 3)
    assert rig.error < 2e-4
    assert rig.report.ambient == "sh2"


@pytest.mark.parametrize(
    ("background", "options", "chosen"),
    [
        (0.0, {"error": 0.02}, "none"),
        (0.3, {"error": 0.02}, "sh2"),
        (0.3, {"error": 0.01}, "constant"),
        (0.3, {"error": 0.6}, "constant"),
        (0.3, {"lights": 2, "error": 1e-5}, "sh2"),
        (0.0, {"error": 0.02, "floor": True}, "none"),
        (0.3, {"lights": 2, "floor": True}, "constant"),
    ],
)
def test_the_fewest_lights_are_chosen_then_the_simplest(background, options, chosen):
    radiance = suns_before(background)
    options["sizes"] = False
    rig = el.fit(radiance, ambient="auto", **options)
    assert rig.report.ambient == chosen
    same = el.fit(radiance, ambient=chosen, **options)
    assert rig.to_dict()["lights"] == same.to_dict()["lights"]
    assert rig.to_dict()["ambient"] == same.to_dict()["ambient"]


@pytest.mark.parametrize("options", [{"error": 0.01}, {"lights": 3}, {"lights": 3, "error": 1e-3}])
def test_the_figures_of_each_are_those_of_its_own_fit(options):
    radiance = el.synthetic.hall(128).radiance
    rig = el.fit(radiance, ambient="auto", **options)
    alone = {
        name: el.fit(radiance, ambient=name, **options) for name in ("none", "constant", "sh2")
    }
    assert rig.report.ambients == {name: (len(r.lights), r.error) for name, r in alone.items()}
    if all(each.error > options.get("error", 0) for each in alone.values()):
        assert rig.error <= (1 + 1e-3) * min(each.error for each in alone.values())
    else:
        reached = [len(r.lights) for r in alone.values() if r.error <= options["error"]]
        assert len(rig.lights) == min(reached)
        assert rig.error <= options["error"]


def test_the_choice_is_printed_and_saved(tmp_path):
    rig = el.fit(gradient(), ambient="auto", error=0.05, lights=1)
    text = str(rig.report)
    assert "ambient term 'sh2' selected from  none: 1 light, " in text
    assert "  sh2: 0 lights, " in text
    rig.save(tmp_path / "rig.json")
    assert el.Rig.load(tmp_path / "rig.json").report == rig.report


def test_over_a_floor_harmonics_are_not_tried():
    rig = el.fit(gradient(), ambient="auto", floor=True)
    assert set(rig.report.ambients) == {"none", "constant"}


def test_what_was_asked_for_is_not_called_a_choice():
    rig = el.fit(gradient(), lights=1, ambient="none")
    assert rig.report.ambient == "none"
    assert rig.report.ambients == {}
    assert "chosen" not in str(rig.report)
    with pytest.raises(el.EnvLightsError, match="ambient must be 'none' or 'constant' or 'sh2';"):
        el.fit_probe(np.eye(3), np.eye(3), 0, ambient="auto")
