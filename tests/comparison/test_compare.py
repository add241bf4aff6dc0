"""Exact comparison: closed forms against sums over pixels and normals."""

import pickle
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import envlights as el
from envlights.comparison import harmonics, spectra
from envlights.comparison.protocol import Material
from tests.comparison.worlds import even, rooms
from tests.helpers import cases
from tests.reference import shadows
from tests.reference import spheres as reference

SPHERES = ("diffuse", "matte", "mirror")


def test_a_map_against_itself_has_no_error():
    truth, _ = rooms()
    c = el.compare(truth, truth)
    for each in c.spheres.values():
        assert (each.rmse, each.si_rmse, each.angle, each.relative) == (0, 0, 0, 0)
    assert (c.probe_error, c.shadow_error, c.gloss_error()) == (0, 0, 0)


@pytest.mark.parametrize("gain", [2.0, 0.25])
def test_a_scaled_guess_has_only_an_error_of_scale(gain):
    truth, _ = rooms()
    c = el.compare(truth, gain * truth.radiance)
    for each in c.spheres.values():
        assert each.relative == pytest.approx(abs(gain - 1), rel=1e-6)
        assert each.si_relative < 1e-6
        assert each.angle < 1e-4
        assert each.scale == pytest.approx(1 / gain, rel=1e-6)
    assert c.gloss_error(0.5) == pytest.approx(abs(gain - 1), rel=1e-6)


@pytest.mark.parametrize(
    ("one", "other", "angle"),
    [((1, 0, 0), (1, 1, 0), 45), ((1, 1, 1), (1, 0, 0), 54.7356), ((2, 1, 0), (4, 2, 0), 0)],
)
def test_constant_colours_have_their_angle_and_their_difference(one, other, angle):
    c = el.compare(even(one), even(other))
    rms = np.sqrt(np.mean(np.subtract(one, other) ** 2.0))
    for name in SPHERES:
        assert c.spheres[name].angle == pytest.approx(angle, abs=1e-3)
    for name in ("diffuse", "mirror"):
        assert c.spheres[name].rmse == pytest.approx(rms, rel=1e-6)
    # Masking takes light from a rough metal, in truth and guess alike.
    assert 0.9 * rms < c.spheres["matte"].rmse <= rms + 1e-12


def test_the_diffuse_sphere_is_the_probe_over_all_normals():
    truth, guess = rooms()
    normals, weights = el.kernels.icosphere(5120)
    images = [env.probe(normals) / np.pi for env in (truth, guess)]
    square = (weights @ (images[1] - images[0]) ** 2).mean() / weights.sum()
    c = el.compare(truth, guess)
    assert c.spheres["diffuse"].rmse == pytest.approx(np.sqrt(square), abs=1e-5, rel=1e-4)
    expected = reference.numbers(*images)
    assert c.spheres["diffuse"].si_rmse == pytest.approx(expected[1], rel=2e-3)
    assert c.spheres["diffuse"].angle == pytest.approx(expected[2], rel=1e-2)


def test_the_matte_sphere_is_the_sum_over_pixels_from_all_sides():
    truth, guess = rooms(32)
    # Four points in each pixel, which the closed form integrates: 0.4 % more.
    fine = [np.repeat(np.repeat(env.radiance, 2, 0), 2, 1) for env in (truth, guess)]
    normals, views = reference.sides(40000)
    both = el.kernels.rough_reflection(np.concatenate(fine, axis=2), normals, views, 0.3271)
    expected = reference.numbers(both[:, :3], both[:, 3:])
    c = el.compare(truth, guess)
    # Samples of 40000 pixels differ by 1 %, those of the angle by 0.2 %.
    assert c.spheres["matte"].rmse == pytest.approx(expected[0], rel=0.02)
    assert c.spheres["matte"].si_rmse == pytest.approx(expected[1], rel=0.02)
    assert c.spheres["matte"].angle == pytest.approx(expected[2], rel=0.01)


@pytest.mark.parametrize("place", [0, 1, 2, 3])
def test_the_matte_angle_of_a_small_coloured_lamp_is_that_of_dense_sides(place):
    """The angle is 0 but in a few percent of the pixels, where sparse ones miss the lamp."""
    towards = np.random.default_rng(place).normal(size=3)
    towards /= np.linalg.norm(towards)
    dark = el.Lights(np.zeros((0, 3)), np.zeros((0, 3)))
    lamp = el.Lights([towards], [[1.5, 0, 0]], [0.08])
    truth, guess = (el.Rig([0.3] * 3, each, error=0.0).to_map(64) for each in (lamp, dark))
    normals, views = reference.sides(40000, seed=1)
    stack = np.concatenate([truth.radiance, guess.radiance], axis=2)
    both = el.kernels.rough_reflection(stack, normals, views, 0.3271)
    expected = reference.numbers(both[:, :3], both[:, 3:])[2]
    angle = el.compare(truth, guess).spheres["matte"].angle
    assert angle == pytest.approx(expected, rel=0.03)


def test_the_mirror_is_the_area_weighted_difference_of_the_maps():
    truth, guess = rooms()
    _, angles = reference.pixels(64)
    pair = [env.radiance.reshape(-1, 3).astype(float) for env in (truth, guess)]
    square = (angles @ (pair[1] - pair[0]) ** 2).mean() / (4 * np.pi)
    c = el.compare(truth, guess)
    assert c.spheres["mirror"].rmse == pytest.approx(np.sqrt(square), rel=1e-6)


def test_errors_do_not_depend_on_the_order_but_for_their_scale():
    truth, guess = rooms()
    one, other = el.compare(truth, guess), el.compare(guess, truth)
    for name in SPHERES:
        assert one.spheres[name].rmse == pytest.approx(other.spheres[name].rmse, rel=1e-9)
        assert one.spheres[name].angle == pytest.approx(other.spheres[name].angle, rel=1e-6)


def test_a_turn_by_columns_changes_nothing():
    truth, guess = rooms()
    turned = [np.roll(env.radiance, 11, axis=1) for env in (truth, guess)]
    one, other = el.compare(truth, guess), el.compare(*turned)
    for name in SPHERES:
        assert other.spheres[name].rmse == pytest.approx(one.spheres[name].rmse, rel=1e-9)
        assert other.spheres[name].si_rmse == pytest.approx(one.spheres[name].si_rmse, rel=1e-9)
    # Angles of the diffuse ball are integrated, those of the matte ball are a sampled mean.
    assert other.spheres["mirror"].angle == pytest.approx(one.spheres["mirror"].angle, rel=1e-6)
    assert other.spheres["diffuse"].angle == pytest.approx(one.spheres["diffuse"].angle, rel=2e-2)
    assert other.spheres["matte"].angle == pytest.approx(one.spheres["matte"].angle, rel=0.1)


def test_a_rig_has_the_errors_of_its_report():
    truth, _ = rooms(128)
    rig = el.fit(truth, lights=3)
    c = el.compare(truth, rig)
    assert c.probe_error == pytest.approx(rig.error, rel=0.02)
    assert c.shadow_error == pytest.approx(rig.report.shadow_error, rel=0.05)


def sun_of_pixels(rows, row, parts=12):
    """Uniform sky with a sun of 3 pixels, and the points of the sun with their fluxes."""
    columns, light = np.array([5, 6, 6]), np.array([20000, 50000, 9000.0])
    at = np.array([row, row, row + 1])
    radiance = np.ones((rows, 2 * rows, 3))
    radiance[at, columns] += light[:, None]
    down, right = (np.indices((parts, parts)).reshape(2, 1, -1) + 0.5) / parts
    v, u = (at[:, None] + down) / rows, (columns[:, None] + right) / (2 * rows)
    points = el.kernels.uv_to_direction(np.stack([u.ravel(), v.ravel()], axis=-1))
    cells = np.cos(np.pi * at / rows) - np.cos(np.pi * (at + 1) / rows)
    flux = light * cells * np.pi / rows / parts**2
    return radiance.astype(np.float32), points, flux.repeat(parts**2)


@pytest.mark.parametrize(("rows", "row"), [(512, 200), (512, 60), (256, 60), (100, 40)])
def test_a_sun_of_pixels_is_compared_with_a_disc_as_sums_over_their_points(rows, row):
    """Double sums of the kernels over points: no series of shadows, no reduced map."""
    radiance, points, flux = sun_of_pixels(rows, row)
    middle = flux @ points / np.linalg.norm(flux @ points)
    light = 1.003 * np.linalg.norm(flux @ points)
    radius = 0.8 * np.pi / rows
    rig = el.Rig(np.ones(3), el.Lights([middle], [[light] * 3], [radius]), error=0.0)
    at, spread = shadows.points_of_disc(middle, [light], radius, rings=10)
    everywhere, signed = np.concatenate([points, at]), np.append(-flux, spread)
    spectrum = el.kernels.gloss.spectrum(0.33, 100)
    series = spectrum * (2 * np.arange(101) + 1) / (4 * np.pi)
    c = el.compare(el.EnvMap(radiance), rig)
    kernels = (
        (shadows.kernel, c.shadow_error),
        (lambda x: shadows.kernel(x) / (1 - np.arccos(np.clip(x, -1, 1)) / np.pi), c.probe_error),
        (lambda x: np.polynomial.legendre.legval(x, series), c.gloss_error(0.33)),
    )
    nodes, weights = np.polynomial.legendre.leggauss(200)
    for kernel, stated in kernels:
        of_sky = 2 * np.pi * weights @ kernel(nodes)
        difference = signed @ kernel(everywhere @ everywhere.T) @ signed
        of_sun = flux @ kernel(points @ points.T) @ flux
        whole = of_sky * (4 * np.pi + 2 * flux.sum()) + of_sun
        # Points in place of squares add up to 2 % of their error.
        assert stated == pytest.approx(np.sqrt(difference / whole), rel=0.02)


def test_two_rigs_are_compared_without_pixels():
    """A turn of a point by less than a pixel is an error of its own size."""
    one = el.Rig([0, 0, 0], el.Lights([[0, 0, 1]], [[1, 1, 1]]), error=0.0)
    angle = 0.004
    turned = el.Lights([[np.sin(angle), 0, np.cos(angle)]], [[1, 1, 1]])
    c = el.compare(one, el.Rig([0, 0, 0], turned, error=0.0))
    # The irradiance of a point is a cosine in front of it, whose slope has the same mean square:
    # mean of sin^2 cos^2(azimuth) over half a sphere, over that of cos^2.
    # Degrees beyond 100 hold 0.5 % of the squared slope of the clamped cosine.
    assert c.probe_error == pytest.approx(angle, rel=4e-3)


def test_lights_of_a_file_are_those_of_the_object(tmp_path):
    truth, _ = rooms(32)
    rig = el.fit(truth, lights=2)
    rig.save(tmp_path / "rig.json")
    truth.save(tmp_path / "map.exr")
    by_path = el.compare(tmp_path / "map.exr", tmp_path / "rig.json")
    assert by_path == el.compare(truth, rig)
    rig.lights.save(tmp_path / "lights.csv")
    assert el.compare(truth, tmp_path / "lights.csv") == el.compare(truth, rig.lights)


@settings(max_examples=cases(short=8, long=60), deadline=None)
@given(st.integers(2, 40), st.integers(2, 40), st.integers(0, 99))
def test_maps_of_any_sizes_are_compared_at_the_smaller_one(one, other, seed):
    rng = np.random.default_rng(seed)
    maps = [rng.random((height, 2 * height, 3)) ** 4 for height in (one, other)]
    c = el.compare(*maps)
    rows = min(one, other)
    has_note = any(f"to {2 * rows}x{rows} pixels" in note for note in c.notes)
    assert has_note == (one != other)
    assert all(np.isfinite(each.rmse) for each in c.spheres.values())
    # A convolution is a mean, so that errors fall with the width of the lobe.
    errors = [c.spheres[name].rmse for name in SPHERES]
    assert errors[0] <= errors[1] * 1.1 <= errors[2] * 1.3


def test_a_border_sampled_map_is_compared_by_its_cells():
    radiance = el.synthetic.hall(33).radiance
    border = el.EnvMap(radiance, layout=el.io.Layout(registration="border-sampled"))
    c = el.compare(el.EnvMap(border.cells()), border)
    assert all(each.rmse == 0 for each in c.spheres.values())


def test_unseen_pixels_are_filled_and_noted():
    truth = el.EnvMap(even((1, 2, 3)))
    seen = np.ones((16, 32))
    seen[14:] = 0
    c = el.compare(truth, el.EnvMap(truth.radiance, coverage=seen))
    assert all(each.relative < 1e-3 for each in c.spheres.values())
    assert any("of the sphere is not seen and was filled" in note for note in c.notes)


def test_the_harmonics_of_a_map_have_its_energy():
    """The sums of squares of the coefficients, for pixels of 2.8 degrees."""
    height = 64
    directions, angles = reference.pixels(height)
    smooth = (2 + directions[:, :1] + directions[:, 1:2] * directions[:, 2:]) * np.ones(3)
    coefficients = harmonics.of_map(smooth.reshape(height, 2 * height, 3))
    energy = harmonics.products(coefficients, coefficients)
    assert energy.sum() == pytest.approx((angles @ smooth**2).sum(), rel=1e-3)
    # Degrees 0, 1 and 2: 4 pi 2^2, 4 pi / 3 and 4 pi / 15 in each channel.
    expected = 3 * 4 * np.pi * np.array([4, 1 / 3, 1 / 15])
    np.testing.assert_allclose(energy[:3], expected, rtol=2e-3)


def test_the_harmonics_of_a_disc_are_those_of_its_map():
    lights = el.Lights([[0.48, 0.6, 0.64]], [[3, 2, 1]], [0.4])
    drawn = harmonics.of_map(lights.to_map(256).radiance.astype(float))
    discs = harmonics.Discs(lights.direction, lights.irradiance, lights.angular_radius)
    exact = discs.harmonics()
    low = np.abs(drawn - exact)[:20, :20].max()
    # Pixels of 0.7 degrees draw the rim.
    assert low < 1e-3 * np.abs(exact).max()


def test_the_lambertian_spectrum_is_that_of_a_clamped_cosine():
    factors = spectra.lambertian()
    cosines, weights = np.polynomial.legendre.leggauss(400)
    # The integral over half of the interval, where the cosine is not clamped.
    x, w = (1 + cosines) / 2, weights / 2
    for degree in (0, 1, 2, 3, 4, 10, 40):
        series = np.polynomial.legendre.Legendre.basis(degree)
        assert factors[degree] == pytest.approx((2 * (w * x) @ series(x)) ** 2, abs=1e-12)


def test_the_spectrum_of_shadows_sums_to_the_kernel_at_zero():
    """K(0) = pi / 3; the degrees beyond 2000 hold 0.02 % of it."""
    degrees = np.arange(harmonics.FINE_DEGREE + 1)
    total = ((2 * degrees + 1) * spectra.shadows()).sum() / (4 * np.pi)
    assert total == pytest.approx(np.pi / 3, rel=3e-4)


def test_lights_and_irradiance_vectors_are_those_of_their_own_functions():
    truth, guess = rooms(32)
    c = el.compare(truth, guess)
    assert c.vector_angle == pytest.approx(el.comparison.vector_angle(truth, guess), rel=1e-6)
    assert c.lights == el.comparison.compare_lights(el.detect(truth), el.detect(guess))
    rig = el.fit(truth, lights=2)
    of_sets = el.comparison.compare_lights(el.detect(truth), rig.lights)
    assert el.compare(truth, rig).lights == replace(of_sets, flux_ratio=None)
    # A uniform map has no vector and no light.
    assert el.compare(even((1, 1, 1)), even((1, 1, 1))).vector_angle is None


def test_irradiance_vectors_of_rigs_need_no_pixels():
    turn = 0.003
    one = el.Lights([[0, 0, 1]], [[1, 1, 1]])
    other = el.Lights([[0, np.sin(turn), np.cos(turn)]], [[1, 1, 1]])
    assert el.compare(one, other).vector_angle == pytest.approx(np.degrees(turn), rel=1e-6)


def test_black_pixels_have_no_angle():
    truth = even((1, 2, 3))
    truth[:8] = 0
    c = el.compare(truth, even((1, 2, 3)))
    assert c.spheres["mirror"].black == pytest.approx(0.5)
    assert c.spheres["mirror"].angle == pytest.approx(0, abs=1e-6)
    assert any("black pixels are left out" in note for note in c.notes)
    assert el.compare(even((1, 1, 1)), even((0, 0, 0))).spheres["mirror"].angle is None


def test_the_text_names_the_choices():
    truth, guess = rooms(32)
    c = el.compare(truth, guess.calibrated(ev100=10))
    text = str(c)
    assert "only angles and scale-invariant errors have a meaning" in text
    assert "linear maps, not scaled" in text
    assert all(name in text for name in SPHERES)
    assert "<table" in c._repr_html_()
    assert c.to_dict()["spheres"]["matte"]["rmse"] == c.spheres["matte"].rmse
    assert pickle.loads(pickle.dumps(c)) == c


@pytest.mark.parametrize(
    ("truth", "guess", "message"),
    [
        (even((0, 0, 0)), even((1, 1, 1)), "truth must have light; it is black"),
        (np.ones((4, 9, 3)), even((1, 1, 1)), "truth: "),
        ("none.exr", even((1, 1, 1)), "truth: .*none.exr"),
        (even((1, 1, 1)), "none.json", "guess: cannot read none.json"),
    ],
)
def test_bad_lightings_are_refused_by_name(truth, guess, message):
    with pytest.raises(el.EnvLightsError, match=message):
        el.compare(truth, guess)


def test_unknown_reading_options_are_refused_whatever_the_sides_are():
    array, rig = even((1, 1, 1)), el.Rig([1, 1, 1], el.Lights([[0, 1, 0]], [[1, 1, 1]]))
    for side in (array, el.EnvMap(array), rig, rig.lights):
        with pytest.raises(el.EnvLightsError, match=r"reading must hold options.* got 'bogus'"):
            el.compare(side, side, reading={"bogus": 1})


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("emlight", "never published"),
        ("envmapnet", "blue channel alone"),
        ("Gardner", "no code of its evaluation"),
        ("lpips", "protocol must be 'exact' or 'stylelight' or 'diffusionlight'; got 'lpips'"),
        (3, "protocol must be"),
    ],
)
def test_protocols_that_cannot_be_reproduced_say_what_is_missing(name, message):
    with pytest.raises(el.EnvLightsError, match=message):
        el.compare(even((1, 1, 1)), even((1, 1, 1)), name)


@pytest.mark.parametrize("roughness", [0.1, 1.1, -1, float("nan"), "rough"])
def test_a_gloss_error_needs_a_roughness_within_its_degrees(roughness):
    c = el.compare(even((1, 1, 1)), even((1, 1, 1)))
    with pytest.raises(el.EnvLightsError, match="roughness must be"):
        c.gloss_error(roughness)


def test_materials_without_closed_form_are_refused():
    with pytest.raises(el.EnvLightsError, match=r"only for specular=0\.04"):
        spectra.of_material(Material(base=0.5, specular=0.1, roughness=0.5))


def with_gain(rig, gain):
    """Rig whose light is all multiplied by `gain`."""
    lights = el.Lights(
        rig.lights.direction, gain * rig.lights.irradiance, rig.lights.angular_radius
    )
    return el.Rig(gain * rig.ambient, lights, error=0.0)


@pytest.mark.parametrize("gain", [0.5, 3.0])
@pytest.mark.parametrize("sides", ["map rig", "rig map", "map map", "rig rig", "lights lights"])
@pytest.mark.parametrize("protocol", ["exact", "diffusionlight"])
def test_brightness_is_the_scale_of_the_diffuse_sphere_of_the_linear_maps(gain, sides, protocol):
    truth, _ = rooms(32)
    rig = el.fit(truth, lights=4)
    other = {"map": gain * truth.radiance, "rig": with_gain(rig, gain)}
    other["lights"] = with_gain(rig, gain).lights
    one = {"map": truth, "rig": rig, "lights": rig.lights}
    first, second = sides.split()
    c = el.compare(one[first], other[second], protocol)
    assert c.scale == pytest.approx(1 / gain, rel=0.02)
    assert f"the guess is {1 / c.scale:.3g} times as bright as the truth" in str(c)
    # No other number of the text looks like a brightness.
    assert not re.search(r"flux of|flux x|\bx \d", str(c))
    assert c.to_dict()["scale"] == c.scale


def test_the_text_says_which_lights_were_found_on_which_side():
    truth, _ = rooms(32)
    rig = el.fit(truth, lights=3)
    number, fraction = len(el.detect(truth)), 100 * el.detect(truth).fraction.sum()
    found = f"{number} lights found by `detect` in the {{}}, with {fraction:.3g} % of its light"
    notes = el.compare(truth, rig).notes
    assert f"lights: {found.format('truth')}; 3 lights of the guess as given" in notes
    notes = el.compare(rig.lights, truth).notes
    assert f"lights: 3 lights of the truth as given; {found.format('guess')}" in notes
    assert el.compare(truth, rig).lights.flux_ratio is None
    assert el.compare(rig, rig.lights).lights.flux_ratio == 0


def test_a_black_guess_has_no_brightness():
    truth, _ = rooms(32)
    for guess in (0 * truth.radiance, with_gain(el.fit(truth, 1), 0)):
        c = el.compare(truth, guess)
        assert c.scale is None
        assert "brightness: the guess is black\n" in str(c)
        assert any(el.Note(note).code == "black" for note in c.notes)
        assert "e+02" not in str(c)


def test_a_floor_of_one_side_is_noted():
    hall = el.EnvMap(el.synthetic.hall(64).radiance)
    above, around = (el.fit(hall, 2, floor=floor) for floor in (True, False))
    words = "fitted over a floor"
    assert any(words in note for note in el.compare(hall, above).notes)
    assert not any(words in note for note in el.compare(hall, around).notes)
    assert not any(words in note for note in el.compare(above, above).notes)


@pytest.mark.parametrize("elevation", [84, 87])
def test_the_shadow_error_under_a_high_sun_is_that_of_a_fit(elevation):
    """Near a pole, the pixels of a sun are slivers; as discs, they made it 16 % too large."""
    sine, cosine = np.sin(np.radians(elevation)), np.cos(np.radians(elevation))
    sky = el.synthetic.clear_sky(256, [0.6 * cosine, sine, -0.8 * cosine])
    rig = el.fit(sky.radiance, 8)
    error = el.compare(sky.radiance, rig).shadow_error
    assert error == pytest.approx(rig.report.shadow_error, rel=0.04)


@pytest.mark.parametrize("fraction", [9e-4, 2e-4])
def test_a_dim_sun_that_moved_has_the_shadow_error_of_the_closed_form(fraction):
    """Two squares of one flux before an even sky; a dim sun is not expanded to high degrees."""
    radiance = np.ones((128, 256, 3), np.float32)
    angle = el.kernels.pixel_solid_angles(128, 256)[38, 70]
    radiance[38, 70] += fraction * 4 * np.pi / angle
    directions = el.kernels.pixel_directions(128, 256)[38]
    cosine = directions[70] @ directions[79]
    flux = fraction * 4 * np.pi
    itself = np.pi / 3 - shadows.MEAN_DISTANCE / 3 * np.sqrt(angle)
    # The mean of the kernel over the sphere: all of the sky, seen from one point of it.
    sky = 2 * np.pi**2 * shadows.gauss(lambda g: shadows.kernel(np.cos(g)) * np.sin(g), 0, np.pi)
    whole = 4 * np.pi * sky + 2 * sky * flux + flux**2 * itself
    exact = np.sqrt(2 * flux**2 * (itself - shadows.kernel(cosine)) / whole)
    moved = np.roll(radiance, 9, axis=1)
    assert el.compare(radiance, moved).shadow_error == pytest.approx(exact, rel=0.01)
    none = el.compare(radiance, np.ones_like(radiance)).shadow_error
    assert none == pytest.approx(flux * np.sqrt(itself / whole), rel=2e-3)
