"""Error of a rig on shiny metal: its closed form, and fits that reach it."""

import pickle
from itertools import pairwise

import numpy as np
import pytest
from scipy.special import sph_harm_y

import envlights as el
from envlights.kernels.gloss import spectrum
from tests.conftest import real_maps
from tests.reference.ggx import gloss_error


@pytest.fixture(scope="module")
def hall():
    return el.EnvMap(el.synthetic.hall(128).radiance)


def sun(direction, radius):
    """Sky of one radiance with a disc."""
    disc = el.synthetic.Disc(direction, radius, (300, 280, 260))
    return el.synthetic.scene(64, background=(0.5, 0.6, 0.8), shapes=[disc])


@pytest.mark.parametrize("roughness", [0.33, 0.5])
def test_the_gloss_error_is_that_of_direct_sums(hall, roughness):
    """A quick version with few pixels of the ball: they leave 1 % of noise."""
    rig = el.fit(hall, 4)
    expected = gloss_error(hall, rig, roughness, 4000)
    assert rig.report.gloss_error(roughness) == pytest.approx(expected, rel=0.03)


@pytest.mark.slow
def test_the_gloss_error_is_that_of_many_direct_sums():
    """At 1e5 pixels and sides of the ball."""
    env = el.EnvMap(el.synthetic.hall(64).radiance)
    rig = el.fit(env, 4)
    expected = gloss_error(env, rig, 0.4, 100_000)
    assert rig.report.gloss_error(0.4) == pytest.approx(expected, rel=0.01)


def test_one_disc_against_another_is_their_direct_integral():
    """The rig's only light stays in a wrong direction."""
    env = sun((0.6, 0.8, 0), 6.0)
    rig = el.fit(env, fixed=[[0.48, 0.8, 0.36]])
    expected = gloss_error(env, rig, 0.4, 4000, finer=2)
    assert rig.report.gloss_error(0.4) == pytest.approx(expected, rel=0.02)


def energies(radiance, degree=24):
    """Energy of a map in each degree, by SciPy's harmonics at the centres of its pixels."""
    height, width, _ = radiance.shape
    theta = np.pi * (np.arange(height) + 0.5) / height
    power = radiance * el.kernels.pixel_solid_angles(height, width)[..., None]
    waves = np.fft.rfft(power, axis=1)[:, : degree + 1]
    return [
        sum(
            (2 if m else 1)
            * (abs(sph_harm_y(degree, m, theta, 0.0).conj() @ waves[:, m]) ** 2).sum()
            for m in range(degree + 1)
        )
        for degree in range(degree + 1)
    ]


@pytest.mark.parametrize(
    ("ambient", "floor"),
    [("none", False), ("constant", False), ("sh2", False), ("none", True), ("constant", True)],
)
def test_the_energies_are_those_of_the_drawn_rig(hall, ambient, floor):
    rig = el.fit(hall, 2, ambient=ambient, floor=floor)
    above = np.arange(256)[:, None, None] < 128
    truth = hall.radiance.repeat(2, axis=0).repeat(2, axis=1)
    seen = rig.to_map(256).radiance
    if ambient == "sh2":
        # A map has no negative radiance, which the harmonics have in some directions.
        directions = el.kernels.pixel_directions(256, 512).reshape(-1, 3)
        harmonics = el.kernels.harmonic_radiance(directions) @ rig.ambient
        lights = el.Rig([0, 0, 0], rig.lights, rig.error).to_map(256).radiance
        seen = lights + harmonics.reshape(lights.shape)
    truth, seen = (np.where(above | (not floor), each, 0) for each in (truth, seen))
    whole, off = np.array(energies(truth)), np.array(energies(seen - truth))
    # Beyond degree 24, metal of roughness 0.5 keeps less than 1e-4 of the energy.
    for roughness in (0.5, 1.0):
        factors = spectrum(roughness, 24)
        expected = np.sqrt(factors @ off / (factors @ whole))
        assert rig.report.gloss_error(roughness) == pytest.approx(expected, rel=0.005)


def test_a_rolled_map_has_the_same_error(hall):
    """The map and its lights turn by a quarter about the vertical."""
    rolled = el.EnvMap(np.roll(hall.radiance, hall.width // 4, axis=1))
    one, other = el.fit(hall, 3).report, el.fit(rolled, 3).report
    assert other.gloss_error() == pytest.approx(one.gloss_error(), rel=1e-4)


def test_a_map_that_the_rig_explains_has_no_error():
    assert el.fit(np.ones((32, 64, 3))).report.gloss_error() < 1e-6
    assert el.fit(np.zeros((32, 64, 3))).report.gloss_error() == 0
    assert el.fit(sun((0.6, 0.8, 0), 10.0), 1).report.gloss_error() < 0.02


def test_rougher_objects_and_more_lights_have_less_error(hall):
    reports = [el.fit(hall, lights).report for lights in (1, 4, 8)]
    for report in reports:
        errors = [report.gloss_error(roughness) for roughness in (0.3, 0.33, 0.5, 1.0)]
        assert all(rough < smooth for smooth, rough in pairwise(errors))
    for material in ("metal", "plastic"):
        errors = [report.gloss_error(material=material) for report in reports]
        assert all(more < fewer for fewer, more in pairwise(errors))


def test_the_report_shows_keeps_and_saves_the_error(hall, tmp_path):
    rig = el.fit(hall, 3)
    words = f"on metal of roughness 0.33 {100 * rig.report.gloss_error():.3g} %"
    assert words in str(rig)
    assert words in rig.report.verbose()
    assert words in rig._repr_html_()
    assert rig.to_dict()["report"]["gloss_error"] == rig.report.gloss_error()
    rig.save(tmp_path / "rig.json")
    for again in (el.Rig.load(tmp_path / "rig.json"), pickle.loads(pickle.dumps(rig))):
        assert again.report.gloss_error(0.5, "plastic") == rig.report.gloss_error(0.5, "plastic")
    assert len(pickle.dumps(rig.report)) < 5000


def test_a_rig_without_a_map_has_no_gloss_error():
    normals = el.kernels.icosphere(80)[0]
    rig = el.fit_probe(normals, np.maximum(normals[:, 1:2], 0) * np.ones(3), 1)
    assert rig.report.gloss_error() is None
    assert "metal" not in str(rig)


@pytest.mark.parametrize("bad", [0.2, 1.1, "rough", None, np.nan])
def test_an_impossible_roughness_is_refused(hall, bad):
    for call in (
        lambda: el.rigs.FitReport().gloss_error(bad),
        lambda: el.fit(hall, gloss_error=0.1, roughness=bad),
        lambda: el.error_curve(hall, [1], roughness=bad),
    ):
        with pytest.raises(el.EnvLightsError, match="roughness must be"):
            call()


@pytest.mark.parametrize("bad", [-0.1, 1.5, "small"])
def test_an_impossible_gloss_error_is_refused(hall, bad):
    with pytest.raises(el.EnvLightsError, match="gloss_error must be"):
        el.fit(hall, gloss_error=bad)


def check_fewest(env, most, **options):
    """The requested error is reached, and one light fewer misses it."""
    rig = el.fit(env, gloss_error=most, **options)
    if rig.report.stop_reason is el.rigs.StopReason.ERROR_NOT_REACHED:
        assert rig.report.gloss_error() > most
        return None
    assert rig.report.gloss_error() <= most
    if len(rig.lights):
        fewer = el.fit(env, len(rig.lights) - 1, gloss_error=most, **options)
        assert fewer.report.gloss_error() > most
        assert fewer.report.stop_reason is el.rigs.StopReason.ERROR_NOT_REACHED
    return rig


def test_the_fewest_lights_reach_the_gloss_error(hall):
    counts = [len(check_fewest(hall, most).lights) for most in (0.7, 0.1)]
    assert counts[0] < counts[1]
    assert len(check_fewest(sun((0.6, 0.8, 0), 10.0), 0.05).lights) == 1


def test_all_requested_errors_are_reached(hall):
    rig = el.fit(hall, error=0.02, shadow_error=0.1, gloss_error=0.25)
    assert rig.error <= 0.02
    assert rig.report.shadow_error <= 0.1
    assert rig.report.gloss_error() <= 0.25


@pytest.mark.slow
@real_maps("hdr/*.hdr")
def test_the_fewest_lights_reach_the_gloss_error_on_real_maps(path):
    check_fewest(el.EnvMap.open(path), 0.2)


def test_an_error_curve_has_the_errors_of_the_fits(hall):
    curve = el.error_curve(hall, [0, 2], roughness=0.5)
    rigs = [el.fit(hall, lights) for lights in (0, 2)]
    assert curve.probe == tuple(rig.error for rig in rigs)
    assert curve.shadows == tuple(rig.report.shadow_error for rig in rigs)
    assert curve.gloss == tuple(rig.report.gloss_error(0.5) for rig in rigs)
    assert curve.used == (0, 2)
    assert curve.rigs == tuple(rigs)
    assert curve.to_dict()["gloss"] == list(curve.gloss)
    assert str(curve).splitlines()[0].split() == [
        *("lights", "used", "objective", "shading", "shadows", "gloss")
    ]
    assert "roughness 0.5" in curve._repr_html_()
    assert pickle.loads(pickle.dumps(curve)) == curve


def test_an_error_curve_is_a_data_frame(hall):
    pytest.importorskip("pandas")
    curve = el.error_curve(hall, [0, 1])
    frame = curve.to_frame()
    assert list(frame["lights"]) == [0, 1]
    assert tuple(frame["gloss"]) == curve.gloss


def test_an_error_curve_needs_a_number_of_lights(hall):
    with pytest.raises(el.EnvLightsError, match="at least one number"):
        el.error_curve(hall, [])


def test_a_gloss_error_that_first_lights_raise_is_reached_by_more():
    """Small lights for a wide sky raise the gloss error until enough of them cover it."""
    sky = el.synthetic.Disc((0.3, 0.9, 0.3), 60.0, (3, 3, 3))
    world = el.synthetic.scene(64, background=(0.1, 0.1, 0.1), shapes=[sky]).radiance
    errors = [el.fit(world, n, max_radius=0.2).report.gloss_error() for n in range(3)]
    assert errors[0] < min(errors[1:])
    rig = el.fit(world, gloss_error=0.5, max_radius=0.2)
    assert rig.report.gloss_error() <= 0.5
    assert len(rig.lights) > 3


def test_a_row_of_a_table_holds_the_gloss_error_and_nan_where_none_was_measured():
    report = el.fit(el.synthetic.hall(16).radiance, 1).report
    assert report.row()["gloss_error"] == report.gloss_error()
    assert np.isnan(el.rigs.FitReport().row()["gloss_error"])
