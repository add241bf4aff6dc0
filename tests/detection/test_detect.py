"""Detection by the component tree."""

import json

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from envlights.kernels.image import LUMINANCE
from envlights.synthetic import Disc, PixelSun, Rectangle, scene, suite
from tests.detection.worlds import family
from tests.helpers import angle_deg

# Known lights


@pytest.mark.parametrize(("name", "least"), [("plain", 0.98), ("hard", 0.97)])
def test_known_lights_are_found_and_measured(name, least):
    found = [(world, el.detect(world.radiance)) for world in family(name)]
    score = el.synthetic.evaluate(
        [(world, lights.direction, lights.flux) for world, lights in found]
    )
    assert score.f1 >= least
    assert score.false_on_lightless == 0
    assert np.median(score.angles_deg) < 0.01
    assert np.percentile(score.angles_deg, 95) < 0.1
    assert np.median(score.flux_errors) < 0.005


def test_a_disc_is_what_it_is():
    world = scene(512, background=[0.1] * 3, shapes=[Disc((1, 0.3, 0.2), 4.0, (9, 6, 3))])
    (lights, known) = el.detect(world.radiance), world.lights
    assert len(lights) == 1
    assert angle_deg(lights.direction, known.direction) < 1e-3
    # The edge is cut by pixels; the truth counts their share of the background.
    np.testing.assert_allclose(lights.flux, world.irradiance_with_background, rtol=2e-3)
    # The solid angle of even radiance, F^2 / sum L^2: the edge weighs it by up to a few percent.
    np.testing.assert_allclose(lights.solid_angle, world.solid_angle, rtol=0.05)
    np.testing.assert_allclose(np.rad2deg(lights.angular_radius), 4.0, rtol=0.03)
    np.testing.assert_allclose(lights.elongation, 1.0, atol=0.01)
    np.testing.assert_allclose(lights.peak_luminance, [9, 6, 3] @ LUMINANCE, rtol=1e-6)


@pytest.mark.parametrize("direction", [(0, 0.1, 1), (0.05, 0.2, -1), (0.3, 1, 0.1)])
@pytest.mark.parametrize("tilt_deg", [0, 35, 90])
def test_a_long_light_says_how_long_and_which_way(direction, tilt_deg):
    lamp = Rectangle(direction, 24, 4, (9, 9, 9), tilt_deg=tilt_deg)
    lights = el.detect(scene(512, background=[0.1] * 3, shapes=[lamp]).radiance)
    assert len(lights) == 1
    # A flat rectangle on the sphere: its far ends look a little smaller.
    np.testing.assert_allclose(lights.elongation, 6.0, rtol=0.03)
    along = lights.orientation[0]
    assert abs(along @ lights.direction[0]) < 1e-9
    share = lamp.coverage(512) * kernels.pixel_solid_angles(512, 1024)
    covered = kernels.pixel_directions(512, 1024)[share > 0]
    weights = share[share > 0] / share.sum()
    offsets = covered - weights @ covered
    _, axes = np.linalg.eigh((offsets * weights[:, None]).T @ offsets)
    assert abs(along @ axes[:, -1]) > 0.9999


@pytest.mark.parametrize("row", [0, 1, 100, 255])
def test_a_sun_of_one_pixel_is_at_its_centre(row):
    direction = kernels.pixel_directions(256, 512)[row, 511]
    sun = scene(256, background=[0.1] * 3, shapes=[PixelSun(direction, (1e5, 9e4, 8e4))])
    lights = el.detect(sun.radiance)
    assert len(lights) == 1
    assert angle_deg(lights.direction, direction[None]) < 1e-9
    wanted = sun.radiance[row, 511] * kernels.pixel_solid_angles(256, 512)[row, 511]
    np.testing.assert_allclose(lights.flux, wanted[None], rtol=1e-6)


def add_disc(radiance, direction, radius_deg, value):
    """Draw a small disc into a map, sixteen samples a pixel; its flux, background included."""
    height, width, _ = radiance.shape
    ((u, v),) = kernels.direction_to_uv([direction])
    reach = 2 + int(radius_deg / 180 * height / np.sqrt(1 - direction[1] ** 2))
    rows = int(v * height) + np.arange(-reach, reach + 1)
    columns = int(u * width) + np.arange(-reach, reach + 1)
    fine = (np.arange(4) + 0.5) / 4
    y, x = (rows[:, None] + fine).ravel() / height, (columns[:, None] + fine).ravel() / width
    towards = kernels.uv_to_direction(np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2))
    inside = towards @ direction >= np.cos(np.deg2rad(radius_deg))
    share = inside.reshape(len(rows), 4, len(columns), 4).mean(axis=(1, 3))[..., None]
    at = np.ix_(rows, columns % width)
    flux = share * value * kernels.pixel_solid_angles(height, width)[at][..., None]
    radiance[at] = radiance[at] * (1 - share) + share * value
    return flux.sum(axis=(0, 1))


def test_forty_small_suns_survive_the_reduction():
    rng = np.random.default_rng(7)
    radiance = np.full((2048, 4096, 3), 0.2, np.float32)
    # Even places, away from the poles, where a window of whole pixels is no square.
    places = kernels.uniform_sphere(kernels.hammersley(40) * (0.9, 1) + (0.05, 0))
    radii = rng.uniform(0.03, 0.25, 40)
    fluxes = [
        add_disc(radiance, place, radius, np.array([900, 800, 700]))
        for place, radius in zip(places, radii, strict=True)
    ]
    lights = el.detect(radiance)
    assert len(lights) == 40
    for place, flux in zip(places, fluxes, strict=True):
        angles = angle_deg(lights.direction, place)
        assert angles.min() < 0.03
        np.testing.assert_allclose(lights.flux[angles.argmin()], flux, rtol=0.03)


@pytest.mark.parametrize("width", [1440, 3000])
def test_widths_that_are_no_multiple_of_the_working_width_do_as_well(width):
    lamps = [Disc((0, 0.2, -1), 3, (9, 9, 9)), Disc((0.2, -1, 0), 2, (5, 6, 7))]
    world = scene(width // 2, background=[0.1] * 3, shapes=lamps)
    lights = el.detect(world.radiance)
    assert len(lights) == 2
    assert angle_deg(lights.direction, world.lights.direction).max() < 0.01
    np.testing.assert_allclose(lights.flux, world.irradiance_with_background, rtol=5e-3)


# Independent methods


def test_separate_lights_are_connected_components():
    measure = pytest.importorskip("skimage.measure")
    for world in family("plain")[:6]:
        lights = el.detect(world.radiance, gap_deg=0)
        luminance = world.radiance @ LUMINANCE.astype(np.float32)
        labels = measure.label(luminance > lights.report.threshold, connectivity=2)
        for i in range(len(lights)):
            rows, columns = lights.members.pixel[lights.members.light == i].T
            touched = set(labels[rows, columns]) - {0}
            is_cut = 0 in columns or 1023 in columns or 0 in rows or 511 in rows
            assert is_cut or len(touched) == 1


# One light or two


@pytest.mark.parametrize(("bar_deg", "count"), [(0.4, 1), (3.0, 2)])
def test_a_narrow_bar_does_not_divide_a_window_and_a_wall_does(bar_deg, count):
    left = Rectangle((0, 0.3, 1), 10, 10, (9, 9, 9))
    bar = Rectangle((0, 0.3, 1), bar_deg, 20, (0.1, 0.1, 0.1))
    backdrop = scene(512, background=[0.1] * 3, shapes=[left]).radiance
    share = bar.coverage(512)[..., None]
    assert len(el.detect(backdrop * (1 - share) + 0.1 * share)) == count


@pytest.mark.parametrize(("depth", "count"), [(0.2, 2), (0.3, 1)])
def test_prominence_decides_between_one_light_and_two(depth, count):
    """Two lamps of 10 and 8 on a bridge: apart where it falls below a quarter of the dimmer."""
    radiance = np.full((256, 512, 3), 0.1)
    radiance[100:110, 100:140] = 8 * depth
    radiance[100:110, 90:104] = 10
    radiance[100:110, 136:150] = 8
    assert len(el.detect(radiance)) == count


def test_merging_keeps_the_flux_and_the_members():
    radiance = suite.hard(1002).radiance
    whole = el.detect(radiance)
    assert len(whole) > 2
    for most in range(1, len(whole) + 1):
        merged = el.detect(radiance, max_lights=most)
        assert len(merged) == most
        np.testing.assert_allclose(merged.flux.sum(0), whole.flux.sum(0), rtol=1e-12)
        assert len(merged.members.light) == len(whole.members.light)
        assert set(merged.members.light) == set(range(most))


# Properties of each light


def test_a_flat_top_at_the_maximum_is_clipped():
    lamps = [Disc((1, 0, 0), 5, (3, 3, 3)), Disc((0, 0, 1), 5, (0.9, 0.9, 0.9))]
    radiance = scene(256, background=[0.05] * 3, shapes=lamps).radiance
    clipped = el.detect(np.minimum(radiance, 1))
    assert clipped.is_clipped.tolist() == [True, False]
    sun = el.detect(
        scene(256, background=[0.1] * 3, shapes=[PixelSun((1, 0, 0), (9, 9, 9))]).radiance
    )
    assert sun.is_clipped.tolist() == [False]


def test_a_slice_keeps_members_and_order():
    lights = el.detect(suite.hard(1002).radiance)
    first = lights[:2]
    assert len(first) == 2
    np.testing.assert_array_equal(first.flux_fraction, lights.flux_fraction[:2])
    assert set(first.members.light) == {0, 1}
    flux = lights.flux @ LUMINANCE
    assert (np.diff(flux) <= 0).all()
    assert lights.flux_fraction.sum() <= 1 + 1e-6
    assert set(lights.to_dict()) >= {"direction", "irradiance", "solid_angle", "is_clipped"}
    assert lights.to_dict()["report"]["threshold"] == lights.report.threshold
    assert json.loads(json.dumps(lights.to_dict())) == lights.to_dict()


def test_the_report_says_the_threshold_and_what_was_skipped():
    report = el.detect(
        scene(256, background=[0.2] * 3, shapes=[Disc((1, 0, 0), 5, (9,) * 3)]).radiance
    )
    assert report.report.threshold == pytest.approx(0.4, rel=0.05)  # the width of a bin
    assert report.report.reason == "2 x the 90 % quantile"
    assert str(report.report) == f"threshold {report.report.threshold:.3g} (2 x the 90 % quantile)"
    assert "of 512 tiles" not in str(report)
    assert "of 512 tiles" in report.verbose()


def test_a_threshold_of_the_caller_is_used_as_it_is():
    lamps = [Disc((1, 0, 0), 5, (9,) * 3), Disc((0, 0, 1), 5, (0.7,) * 3)]
    radiance = scene(256, background=[0.2] * 3, shapes=lamps).radiance
    chosen, fixed = el.detect(radiance, rise=1), el.detect(radiance, rise=1, threshold=0.8)
    assert (len(chosen), len(fixed)) == (2, 1)
    assert (fixed.report.threshold, fixed.report.reason) == (0.8, "set by the caller")
    # That of the map itself changes nothing.
    same = el.detect(radiance, rise=1, threshold=chosen.report.threshold)
    assert same.direction.tolist() == chosen.direction.tolist()
    picture = np.minimum(radiance, 1).astype(np.float32)
    clipped = el.detect(picture, clip_level=1.0)
    again = el.detect(picture, clip_level=1.0, threshold=clipped.report.threshold)
    np.testing.assert_allclose(again.report.threshold, clipped.report.threshold, rtol=1e-5)
    assert len(again) == len(clipped)
    with pytest.raises(el.EnvLightsError, match="threshold must be"):
        el.detect(radiance, threshold=-1)


@pytest.mark.parametrize("radius_deg", [3.0, 40.0, 70.0])
@pytest.mark.parametrize("background", [[0.0] * 3, [0.3, 0.2, 0.1]])
def test_the_irradiance_of_a_disc_is_that_of_a_surface_facing_it(radius_deg, background):
    """In closed form ``pi sin(a)^2 (L - B)``, with the ambient as background."""
    radiance = np.array([9.0, 6.0, 3.0])
    lamp = Disc((1, 0.3, 0.2), radius_deg, radiance)
    env = el.EnvMap(scene(512, background=background, shapes=[lamp]).radiance)
    (light,) = el.detect(env)
    wanted = np.pi * np.sin(np.deg2rad(radius_deg)) ** 2 * (radiance - background)
    np.testing.assert_allclose(light.irradiance, wanted, rtol=5e-3)
    solid_angle = 2 * np.pi * (1 - np.cos(np.deg2rad(radius_deg)))
    np.testing.assert_allclose(light.flux, solid_angle * radiance, rtol=5e-3)
    if radius_deg < 60:
        rig = el.Rig(background, el.detect(env), error=0.0)
        normals = np.array([light.direction])
        np.testing.assert_allclose(rig.probe(normals), env.probe(normals), rtol=5e-3)


def test_the_report_says_where_a_bright_sky_is_itself_light():
    """The cut divides light from background, and the report gives the numbers of that rule."""
    radiance = np.where(np.arange(64)[:, None, None] < 20, 100.0, 1.0) * np.ones((64, 128, 3))
    report = el.detect(radiance).report
    assert report.reason == "2 x the 95 % quantile of all but the brightest parts"
    (detail, _) = report.details
    assert detail.startswith("the brightest 10 % of the sphere counts as light")


# Worst cases


@pytest.mark.parametrize("value", [0.0, 1e-30, 0.5, 1e30])
def test_an_even_map_has_no_light(value):
    lights = el.detect(np.full((64, 128, 3), value))
    assert len(lights) == 0
    assert "no lights: nothing is much brighter than the threshold" in str(lights.report)


@pytest.mark.parametrize("size", [(2, 4), (3, 6), (17, 34), (512, 1024)])
@pytest.mark.parametrize("row", [0, 1, -1])
def test_one_lit_pixel_in_the_dark_is_one_light(size, row):
    height, width = size
    radiance = np.zeros((height, width, 3), np.float32)
    radiance[row, 0] = 65504
    lights = el.detect(radiance)
    assert len(lights) == 1
    wanted = kernels.pixel_directions(height, width)[row, 0]
    assert angle_deg(lights.direction, wanted[None]) < 1e-6
    np.testing.assert_allclose(lights.flux_fraction, 1.0, rtol=1e-6)


def test_two_equal_suns_opposite_each_other_are_two():
    suns = [PixelSun((1, 0, 0), (1e5,) * 3), PixelSun((-1, 0, 0), (1e5,) * 3)]
    lights = el.detect(scene(128, background=[0.1] * 3, shapes=suns).radiance)
    assert len(lights) == 2
    merged = el.detect(scene(128, background=[0.1] * 3, shapes=suns).radiance, max_lights=1)
    np.testing.assert_allclose(np.linalg.norm(merged.direction, axis=1), 1.0)


def test_unusable_samples_are_cleaned_and_a_map_of_nothing_else_is_refused():
    world = scene(128, background=[0.1] * 3, shapes=[Disc((1, 0, 0), 5, (9, 9, 9))])
    damaged = world.radiance.copy()
    damaged[:20] = np.nan
    damaged[-20:] = -1
    damaged[64, 64] = np.inf  # in the lamp: above all finite samples
    lights = el.detect(damaged)
    assert len(lights) == 1
    assert "15360 NaN samples set to" in str(lights.report)
    assert "negative samples set to 0" in str(lights.report)
    with pytest.raises(el.EnvLightsError, match="no finite sample"):
        el.detect(np.full((64, 128, 3), np.nan))


def test_white_noise_is_answered():
    noise = np.random.default_rng(0).exponential(size=(256, 512, 3)) ** 3
    lights = el.detect(noise)
    assert np.isfinite(lights.flux).all()
    assert len(el.detect(noise, max_lights=5)) == 5


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"max_lights": 0}, "max_lights must be a whole number, 1 or more"),
        ({"min_flux_fraction": 2}, "min_flux_fraction must be a finite number, from 0 to 1"),
        ({"rise": 0.5}, "rise must be a finite number, 1 or more"),
        ({"prominence": 0.5}, "prominence must be a finite number, 1 or more"),
        ({"gap_deg": -1}, "gap_deg"),
        ({"extent": 2}, "extent"),
        ({"working_width": 3}, "working_width"),
    ],
)
def test_bad_options_are_refused_by_name(options, message):
    with pytest.raises(el.EnvLightsError, match=message):
        el.detect(np.ones((8, 16, 3)), **options)


def test_options_of_the_other_method_are_refused():
    with pytest.raises(TypeError, match="blur_px"):
        el.detect(np.ones((8, 16, 3)), blur_px=0.8)


# Detected lights as the start of a fit


def test_a_fit_that_starts_at_the_lamps_stays_with_them():
    lamps = [Disc((1, 1, 0), 4, (30, 30, 30)), Disc((-1, 0.5, 0.3), 3, (40, 30, 20))]
    world = scene(256, background=[0.2] * 3, shapes=lamps)
    rig = el.fit(world.radiance, lights=2, start="detect")
    assert angle_deg(rig.lights.direction, world.lights.direction).max() < 0.5
    assert rig.error < 0.01
    assert "start" in rig.report.seconds
