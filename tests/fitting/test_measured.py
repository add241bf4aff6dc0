"""Errors of rigs that nobody fitted: those of a fit, of dense quadrature, and of files."""

from dataclasses import replace

import numpy as np
import pytest

import envlights as el
from envlights.kernels.probe import relative_rms

NOT = "not measured"


def a_map(rows=64):
    return el.EnvMap(el.synthetic.hall(2 * rows).radiance)


def a_rig():
    return el.Rig.of([0.1, 0.1, 0.1], el.Lights([[0.6, 0.8, 0]], [[2, 2, 2]], [0.3]))


@pytest.mark.parametrize(
    ("floor", "ambient"), [(False, "constant"), (True, "constant"), (False, "sh2")]
)
def test_the_errors_of_a_fit_come_back(floor, ambient):
    """The fit measures on its reduced map, the other way is in closed form on the whole one."""
    env = a_map(128)
    rig = el.fit(env, 4, floor=floor, ambient=ambient)
    again = replace(rig, error=None, report=el.rigs.FitReport()).measured(env)
    ours, fitted = again.report, rig.report
    assert again.error == pytest.approx(rig.error, rel=5e-3)
    assert ours.channel_errors == pytest.approx(fitted.channel_errors, rel=5e-3)
    assert ours.shadow_error == pytest.approx(fitted.shadow_error, rel=1e-2)
    assert ours.gloss_error() == pytest.approx(fitted.gloss_error(), rel=1e-2)
    assert ours.max_error == pytest.approx(fitted.max_error, rel=5e-2)
    assert (ours.ambient, ours.measured_on) == (fitted.ambient, fitted.measured_on)


def test_another_map_and_moved_lights_have_errors_of_their_own():
    env, rig = a_map(), el.fit(a_map(), 2)
    moved = el.Rig.of(rig.ambient, rig.lights.moved(0, azimuth=0.3), 0.5 * env.radiance)
    normals, weights = el.kernels.icosphere(20480)
    expected = relative_rms(moved.probe(normals), 0.5 * env.probe(normals), weights)
    assert moved.error == pytest.approx(expected, rel=2e-3)
    assert not moved.report.search_errors


def test_a_map_that_is_seen_in_part_needs_a_fill():
    env = el.EnvMap(np.ones((32, 64, 3)), coverage=np.repeat([1.0, 0.0], 16)[:, None] * np.ones(64))
    with pytest.raises(el.EnvLightsError, match="fill"):
        a_rig().measured(env)
    rig = el.Rig.of([1, 1, 1], el.Lights(np.zeros((0, 3)), np.zeros((0, 3))))
    assert rig.measured(env, fill=1.0).error == pytest.approx(0, abs=1e-6)
    assert rig.measured(env, fill=1.0).report.coverage_fraction == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("env", "words"),
    [
        (np.zeros((8, 16, 3)), "must have light"),
        (el.EnvMap(np.ones((8, 16, 3))).calibrated(lux=1000), "the same units"),
        ("no-file.exr", "no-file"),
    ],
)
def test_a_rig_cannot_be_measured_on(env, words):
    with pytest.raises(el.EnvLightsError, match=words):
        a_rig().measured(env)


def test_an_error_that_was_not_measured_says_so():
    rig = a_rig()
    assert rig.error is None
    assert NOT in repr(rig)
    assert f"relative RMS error {NOT}" in str(rig)
    assert NOT in rig._repr_html_()
    assert np.isnan(el.rigs.rigs_to_frame([rig])["error"][0])
    assert NOT in el.plot.error_picture(rig).axes[0].get_legend().get_texts()[-1].get_text()
    assert el.view(rig, title="A rig") is not None


@pytest.mark.parametrize("name", ["rig.json", "rig.csv"])
def test_a_file_keeps_that_nothing_was_measured(name, tmp_path):
    a_rig().save(tmp_path / name)
    assert el.Rig.load(tmp_path / name) == a_rig()


def test_programs_state_the_change_alone(tmp_path):
    rig = a_rig()
    assert rig.error_in("blender") == 0
    assert rig.error_in("three") == pytest.approx(replace(rig, error=0.0).error_in("three"))
    with pytest.warns(UserWarning, match="the irradiance changes by"):
        rig.save(tmp_path / "rig.three.json")


def test_variations_of_a_rig_without_error_have_none():
    (varied,) = el.vary([a_rig(), replace(a_rig(), error=0.1)], 1, mix=0.5)
    assert varied.rig.error is None
