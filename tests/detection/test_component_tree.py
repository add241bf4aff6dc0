"""The component tree against plain references, closed forms and extreme maps."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import envlights as el
from envlights import kernels
from envlights.kernels.image import LUMINANCE
from envlights.synthetic import Disc, Rectangle, scene, suite
from tests.conftest import real_maps
from tests.detection.worlds import members, one_pixel_suns
from tests.helpers import angle_deg
from tests.reference import component_tree

REGISTRATIONS = pytest.mark.parametrize("registration", ["cell-centred", "border-sampled"])


def grey(luminance):
    return np.repeat(np.asarray(luminance, np.float32)[..., None], 3, axis=2)


# The reference of the tree


def smooth_noise(seed, height=48):
    """Hills of all heights, whole at the seam."""
    ndimage = pytest.importorskip("scipy.ndimage")
    noise = np.random.default_rng(seed).standard_normal((height, 2 * height))
    hills = ndimage.gaussian_filter(noise, 1.2, mode=["nearest", "wrap"])
    return np.exp(4 * hills / hills.std()).astype(np.float32)


def assert_as_reference(radiance, prominence=4.0):
    """Every light and every member, from the very luminance that the kernel sees.

    The reference joins no panes and lists all lights.
    """
    lights = el.detect(radiance, gap_deg=0, extent=0, prominence=prominence, min_worth=0)
    luminance = kernels.reduced_luminance(radiance, 1024)
    threshold = np.float32(lights.report.threshold)
    wanted = component_tree.lights(luminance, threshold, prominence, np.float32(2.5) * threshold)

    def within_the_edge(pixels):
        peak = float(max(luminance[pixel] for pixel in pixels))
        edge = np.float32(np.sqrt(lights.report.threshold / 2 * peak))
        return frozenset(pixel for pixel in pixels if luminance[pixel] >= edge)

    found = {frozenset((int(y), int(x)) for y, x in pixels) for pixels in members(lights)}
    assert found == {within_the_edge(pixels) for pixels in wanted}
    assert len(lights) == len(wanted)
    return lights


@pytest.mark.parametrize("prominence", [1.0, 1.5, 4.0, 30.0])
@pytest.mark.parametrize("seed", range(6))
def test_hills_fall_into_the_lights_of_the_reference(seed, prominence):
    assert len(assert_as_reference(grey(smooth_noise(seed, 40)), prominence)) > 1


@settings(max_examples=150)
@given(
    height=st.integers(2, 20),
    steep=st.floats(2, 12),
    prominence=st.sampled_from([1.0, 2.0, 4.0]),
    seed=st.integers(0, 2**32 - 1),
)
def test_noise_falls_into_the_lights_of_the_reference(height, steep, prominence, seed):
    """Down to two rows, both of them poles. All levels differ."""
    levels = np.random.default_rng(seed).permutation(2 * height**2) / (2 * height**2)
    assert_as_reference(grey(np.exp(steep * levels).reshape(height, 2 * height)), prominence)


@real_maps("hdr/*.hdr", "exr/*.exr", "openexr_envmaps/*LatLong.exr")
def test_a_real_map_falls_into_the_lights_of_the_reference(path):
    assert_as_reference(np.ascontiguousarray(el.EnvMap.open(path).radiance))


@pytest.mark.parametrize("rows", [slice(0, 2), slice(38, 40)])
def test_lamps_that_meet_only_at_a_pole_are_lights_of_the_reference(rows):
    """Spokes around a pole, each with its own peak: the pole row joins them."""
    luminance = 0.01 + 0.001 * np.random.default_rng(1).random((40, 80))
    spokes = slice(0, 10) if rows.start == 0 else slice(30, 40)
    luminance[spokes, ::8] = np.random.default_rng(2).uniform(1, 3, (10, 10))
    apart = assert_as_reference(grey(luminance))
    luminance[0 if rows.start == 0 else -1, ::8] = 1.0
    joined = assert_as_reference(grey(luminance + 1e-4 * np.random.default_rng(3).random((40, 80))))
    assert len(joined) <= len(apart)


# Measurements are sums over the map's own pixels


def lit_patch(size, rows, columns, border_sampled):
    """Coloured noise in one patch of a black map: nothing behind it, nothing to estimate."""
    height, width = size
    is_lit = np.zeros(size, bool)
    is_lit[np.ix_(rows, np.asarray(columns) % width)] = True
    colours = np.random.default_rng(5).uniform([0.5, 0.6, 0.2], [1.0, 0.9, 0.8], (*size, 3))
    radiance = np.where(is_lit[..., None], colours, 0).astype(np.float32)
    directions = kernels.pixel_directions(height, width, border_sampled=border_sampled)
    solid_angles = kernels.pixel_solid_angles(height, width, border_sampled=border_sampled)
    return radiance, radiance[is_lit].astype(float), directions[is_lit], solid_angles[is_lit]


@REGISTRATIONS
@pytest.mark.parametrize("block", [1, 2, 3])
@pytest.mark.parametrize(
    ("rows", "columns"),
    [(range(60, 72), range(100, 130)), (range(40, 50), range(-14, 17)), (range(9), range(256))],
    ids=["away", "seam", "pole"],
)
def test_a_light_is_the_sum_over_its_pixels(rows, columns, block, registration):
    is_border = registration == "border-sampled"
    radiance, colours, directions, solid_angles = lit_patch((128, 256), rows, columns, is_border)
    env = el.EnvMap(radiance, layout=el.io.Layout(registration=registration))
    lights = el.detect(env, working_width=-(-256 // block), extent=0)
    assert len(lights) == 1
    luminance = colours @ LUMINANCE
    np.testing.assert_allclose(lights.flux[0], solid_angles @ colours, rtol=1e-6)
    flux = luminance * solid_angles
    np.testing.assert_allclose(lights.flux_fraction, 1, rtol=1e-6)
    np.testing.assert_allclose(lights.solid_angle, flux.sum() ** 2 / (luminance @ flux), rtol=1e-6)
    np.testing.assert_allclose(lights.peak_luminance, luminance.max(), rtol=1e-6)
    centre = flux @ directions
    # The kernel takes the middle of a cell, which for the half cells of a border is not the sample.
    off = 0.1 if is_border else 1e-5
    assert angle_deg(lights.direction[0], centre / np.linalg.norm(centre)) < off


def test_two_lamps_as_one_are_as_long_as_both():
    """sqrt(S_along / S_across) with S = r^2/4 of each disc, and sin^2 of its way to the middle."""
    apart, radius = np.deg2rad([10, 3])
    towards = [(np.sin(side * apart), 0, np.cos(apart)) for side in (1, -1)]
    world = scene(512, background=[0.01] * 3, shapes=[Disc(d, 3, (9, 9, 9)) for d in towards])
    lights = el.detect(world.radiance, max_lights=1)
    wanted = np.sqrt(1 + 4 * np.sin(apart) ** 2 / radius**2)
    np.testing.assert_allclose(lights.elongation, wanted, rtol=0.02)  # flat discs, cut by pixels
    assert angle_deg(lights.orientation * np.sign(lights.orientation[:, :1]), [[1, 0, 0]]) < 0.1
    assert angle_deg(lights.direction, [[0, 0, 1]]) < 1e-3
    # The rim's dimmer pixels count for more than they are, as in one disc.
    np.testing.assert_allclose(lights.solid_angle, world.solid_angle.sum(), rtol=0.05)


@pytest.mark.parametrize("direction", [(0, 0, 1), (0, 0.02, -1), (0.02, 1, 0), (0, -1, 0)])
def test_a_disc_is_round_wherever_it_is(direction):
    world = scene(512, background=[0.1] * 3, shapes=[Disc(direction, 3, (9, 9, 9))])
    lights = el.detect(world.radiance)
    assert len(lights) == 1
    assert angle_deg(lights.direction, world.lights.direction) < 0.005
    assert lights.elongation[0] < 1.02
    # Around a pole the rim is one row, all of whose pixels are cut alike.
    np.testing.assert_allclose(lights.solid_angle, world.solid_angle, rtol=0.07)
    np.testing.assert_allclose(lights.flux, world.irradiance_with_background, rtol=5e-3)


@pytest.mark.parametrize("degrees", [0.4, 0.5, 0.8, 1.5, 3, 10])
def test_a_radius_is_that_of_the_disc_and_not_of_the_pixels_that_it_cuts(degrees):
    """From 1.1 pixels on; below 1.4 pixels the coverage of single pixels adds up to 6 %."""
    rng = np.random.default_rng(1)
    for _ in range(8 if degrees < 0.5 else 3):
        towards = (*rng.uniform(-0.6, 0.6, 2), 1)
        world = scene(512, background=[0.01] * 3, shapes=[Disc(towards, degrees, (90, 90, 90))])
        lights = el.detect(world.radiance)
        rtol = 0.06 if degrees < 0.5 else 0.05
        np.testing.assert_allclose(np.rad2deg(lights.angular_radius), degrees, rtol=rtol)


@pytest.mark.parametrize("direction", [(0, 0.1, -1), (1, -0.4, 0.3), (0.4, 1, 0.2), (-1, -1, -1)])
def test_the_radius_of_the_sun_is_right_at_2048_columns(direction):
    """1.5 pixels, on the seam too; moments know the coverage of single pixels to 3 %."""
    x, y, z = direction
    suns = [Disc(towards, 0.27, (9e3, 9e3, 9e3)) for towards in (direction, (-x, -y, -z - 1e-3))]
    lights = el.detect(scene(1024, background=[0.01] * 3, shapes=suns).radiance)
    np.testing.assert_allclose(np.rad2deg(lights.angular_radius), 0.27, rtol=0.03)


def test_the_radius_of_the_sun_is_right_in_the_mean():
    """The sun has 0.8 pixels; single radii are wrong by up to 10 %."""
    turns = np.linspace(0, 1, 12, endpoint=False) * 2 * np.pi / 1024
    found = []
    for step, turn in enumerate(turns):
        towards = (np.sin(turn), 0.3 + step * 0.7e-3, np.cos(turn))
        world = scene(512, background=[0.01] * 3, shapes=[Disc(towards, 0.27, (9e3, 9e3, 9e3))])
        found.append(np.rad2deg(el.detect(world.radiance).angular_radius[0]) / 0.27)
    assert np.mean(found) == pytest.approx(1, abs=0.05)
    assert np.abs(np.subtract(found, 1)).max() < 0.1


def test_members_and_peaks_lie_in_their_lights():
    for seed in suite.EVALUATION[:4]:
        lights = el.detect(suite.hard(seed).radiance)
        homes = members(lights)
        # No pixel has two lights.
        assert sum(map(len, homes)) == len(set().union(*homes)) == len(lights.members.light)
        uv = kernels.direction_to_uv(lights.peak_direction)
        for home, (u, v) in zip(homes, uv, strict=True):
            assert (int(v * 512), int(u * 1024) % 1024) in home


def test_the_members_of_a_reduced_map_are_pixels_of_the_working_image():
    world = scene(600, background=[0.1] * 3, shapes=[Disc((1, 0, 0), 8, (9, 9, 9))])
    lights = el.detect(world.radiance)
    assert lights.report.working_size == (300, 600)
    is_member = np.zeros((300, 600), bool)
    is_member[tuple(lights.members.pixel.T)] = True
    off = angle_deg(kernels.pixel_directions(300, 600), [1, 0, 0])
    # From the centre of a pixel of 0.6 degrees to its corners: only the rim may be either.
    assert is_member[off < 8 - 0.43].all()
    assert not is_member[off > 8 + 0.43].any()


def test_any_slice_brings_its_own_members():
    lights = el.detect(one_pixel_suns(6, 0))
    homes = members(lights)
    assert members(lights[1:5:2]) == [homes[1], homes[3]]
    assert members(lights[4:]) == homes[4:]
    # Lights are always sorted, also those of a slice from the back.
    assert members(lights[::-1]) == homes


def test_members_follow_their_lights_into_the_order_of_flux():
    lights = el.detect(one_pixel_suns(3, 0))
    turned = dataclasses.replace(lights, flux=lights.flux[[1, 2, 0]])
    homes = members(lights)
    assert members(turned) == [homes[2], homes[0], homes[1]]


# Notes and rare values


@pytest.mark.parametrize("direction", [(1, 0.4, 0), (0, 0.1, -1), (0, 1, 0.2)])
@pytest.mark.parametrize("registration", ["cell-centred", "border-sampled"])
def test_a_light_whose_peak_has_a_black_channel_is_noted(direction, registration):
    shapes = [Disc(direction, 3, (9, 8, 7)), Disc((0, -1, 1), 3, (9, 8, 7))]
    radiance = scene(128, background=[0.1] * 3, shapes=shapes).radiance
    env = el.EnvMap(radiance, layout=el.io.Layout(registration=registration))
    assert el.detect(env).report.notes == ()
    row, column = np.unravel_index(radiance[:64].sum(axis=2).argmax(), (64, 256))
    damaged = radiance.copy()
    damaged[row, column] = 30, 25, 0
    (note,) = el.detect(
        el.EnvMap(damaged, layout=el.io.Layout(registration=registration))
    ).report.notes
    assert "has no blue at its peak" in note
    damaged[row, column] = 0, 25, 0
    (note,) = el.detect(
        el.EnvMap(damaged, layout=el.io.Layout(registration=registration))
    ).report.notes
    assert "has no red and no blue at its peak" in note


def test_what_gives_little_and_stands_out_little_is_listed_only_when_all_are_wanted():
    """A lamp, a chink of six times its background, and a bright point."""
    shapes = [
        Rectangle((1, 0, 0), 10, 10, (9, 9, 9)),
        Rectangle((0, 0, 1), 0.7, 0.7, (6, 6, 6)),
        Disc((-1, 0, 0), 0.4, (60, 60, 60)),
    ]
    radiance = scene(512, background=[1.0] * 3, shapes=shapes).radiance
    assert [len(el.detect(radiance, min_worth=least)) for least in (0, 0.0005)] == [3, 2]
    assert "1 light is too weak" in str(el.detect(radiance).report)


def test_minus_zero_is_as_dark_as_zero():
    lamps = [Rectangle(towards, 8, 8, (9, 9, 9)) for towards in ((1, 0, 0), (0, 0, 1), (-1, 0, 0))]
    radiance = np.array(scene(32, background=[0] * 3, shapes=lamps).radiance)
    assert len(el.detect(radiance)) == 3
    assert len(el.detect(np.where(radiance == 0, np.float32(-0.0), radiance))) == 3


def test_pixels_may_be_as_few_as_one():
    """The rows of the map are wider than a block of the sum."""
    radiance = np.random.default_rng(5).gamma(1.0, size=(150, 300, 3)).astype(np.float32)
    mean = kernels.reduced_luminance(radiance, 1)
    solid_angles = kernels.pixel_solid_angles(150, 300)
    wanted = (kernels.luminance(radiance) * solid_angles).sum() / (4 * np.pi)
    np.testing.assert_allclose(mean, [[wanted]], rtol=1e-5)


# Invariances


@pytest.mark.parametrize("working_width", [256, 400, 700])
def test_a_smaller_working_image_shows_the_same_lights(working_width):
    lamps = [Disc((1, 0.3, 0), 5, (9, 9, 9)), Rectangle((0, -0.4, -1), 9, 14, (20, 18, 15))]
    world = scene(512, background=[0.2] * 3, shapes=lamps)
    lights = el.detect(world.radiance, working_width=working_width)
    assert len(lights) == 2
    # The lights are measured in the map's own pixels: only whole pixels at the rim may be missed.
    assert angle_deg(lights.direction, world.lights.direction).max() < 0.05
    np.testing.assert_allclose(lights.flux, world.irradiance_with_background, rtol=0.01)


def test_layout_and_dtype_of_the_array_do_not_matter():
    radiance = suite.hard(1001, 128).radiance
    wanted = el.detect(radiance).to_dict()
    wide = np.zeros((128, 256, 4), np.float32)
    wide[..., :3] = radiance
    for same in (radiance.astype(np.float64), np.asfortranarray(radiance), wide[..., :3]):
        assert el.detect(same).to_dict() == wanted


@real_maps("hdr/*.hdr", "exr/*.exr", "openexr_envmaps/*LatLong.exr")
def test_exposure_and_mirrors_change_no_light_of_a_real_map(path):
    env = el.EnvMap.open(path)
    lights = el.detect(env)

    def again(radiance):
        same = el.EnvMap(
            np.ascontiguousarray(radiance), layout=el.io.Layout(registration=env.registration)
        )
        return el.detect(same)

    scaled = again((env.radiance * np.float64(1e-3)).astype(np.float32))
    mirrored = again(env.radiance[:, ::-1])
    for other, turn, factor in [(scaled, (1, 1, 1), 1e-3), (mirrored, (-1, 1, 1), 1)]:
        assert len(other) == len(lights)
        # Dim lights of nearly the same flux may change places: the bright ones, which may not.
        np.testing.assert_allclose(other.flux_fraction, lights.flux_fraction, rtol=1e-3, atol=1e-6)
        for direction in (lights.direction * turn)[lights.flux_fraction > 0.001]:
            assert angle_deg(other.direction, direction).min() < 1e-2
        total = factor * lights.flux.sum(axis=0)
        np.testing.assert_allclose(other.flux.sum(axis=0), total, rtol=1e-4)


# Worst cases


@pytest.mark.parametrize("column", [0, 7, 15])
@pytest.mark.parametrize("row", range(8))
@REGISTRATIONS
def test_a_pixel_lit_in_any_row_is_one_light(row, column, registration):
    radiance = np.full((8, 16, 3), 0.01, np.float32)
    radiance[row, column] = 1e4
    lights = el.detect(el.EnvMap(radiance, layout=el.io.Layout(registration=registration)))
    assert len(lights) == 1
    is_border = registration == "border-sampled"
    solid_angle = kernels.pixel_solid_angles(8, 16, border_sampled=is_border)[row, column]
    np.testing.assert_allclose(lights.flux, np.full((1, 3), 1e4 * solid_angle), rtol=1e-5)
    assert lights.members.pixel.tolist() == [[row, column]]


def test_pixels_at_the_limit_of_half_floats_are_summed_whole():
    world = scene(256, background=[1.0] * 3, shapes=[Disc((1, 0, 0), 4, (65504,) * 3)])
    lights = el.detect(world.radiance)
    assert len(lights) == 1
    assert lights.is_clipped.tolist() == [True]
    np.testing.assert_allclose(lights.flux, world.irradiance_with_background, rtol=1e-3)


def test_a_sun_of_the_largest_float_is_measured():
    radiance = np.full((64, 128, 3), 1.0, np.float32)
    radiance[30, 40] = np.finfo(np.float32).max
    lights = el.detect(radiance, working_width=32)
    assert len(lights) == 1
    assert np.isfinite(lights.flux).all()
    assert np.isfinite(lights.solid_angle).all()


def test_a_night_of_a_thousand_stars_has_a_thousand_lights():
    """Every star is one light, in more tiles than one row has."""
    rng = np.random.default_rng(4)
    radiance = np.full((512, 1024, 3), 1e-3, np.float32)
    cells = rng.choice(50 * 100, 1000, replace=False)
    rows, columns = 6 + cells // 100 * 10, 3 + cells % 100 * 10
    radiance[rows, columns] = rng.uniform(1, 2, (1000, 1))
    lights = el.detect(radiance, gap_deg=0)
    assert len(lights) == 1000
    assert set.union(*members(lights)) == set(zip(rows.tolist(), columns.tolist(), strict=True))


@pytest.mark.parametrize("shape", [(8, 8, 3), (8, 16, 2), (8, 16, 5), (1, 2, 3)])
def test_what_is_no_map_is_refused_with_its_shape(shape):
    with pytest.raises(el.EnvLightsError, match=f"{shape[0]}"):
        el.detect(np.ones(shape))
