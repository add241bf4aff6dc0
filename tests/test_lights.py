"""Directional lights with their sizes, all in one order."""

import copy
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

import envlights as el
from envlights.kernels.image import LUMINANCE
from envlights.rigs.lights import brightest_first

NORMALS, SOLID_ANGLES = el.kernels.icosphere(320)

#: No light: its directions, and its irradiances.
DARK = np.zeros((0, 3))

#: Two lamps that mirror each other, and colours of equal luminance: rounding decides their order.
LAMPS = np.array([[0.6, 0.64, 0.48], [-0.6, 0.64, 0.48]])
COLOURS = np.array([[0.5, 0.5, 0.1], [0.1, 0.5, 0.5]]) / LUMINANCE


def a_probe_that_fits(weights):
    """The probe under both lamps and ambient light, with a residual that changes no fitted number.

    Also the factor of each lamp in its standard error, which identifies the lamps.
    """
    columns = np.column_stack([np.full(len(NORMALS), np.pi), np.maximum(NORMALS @ LAMPS.T, 0)])
    root = np.sqrt(weights)[:, None]
    noise = root * np.random.default_rng(15).normal(scale=0.02, size=(len(NORMALS), 3))
    noise -= root * columns @ np.linalg.lstsq(root * columns, noise, rcond=None)[0]
    probe = el.kernels.rig_irradiance(NORMALS, [0.1] * 3, LAMPS, COLOURS) + noise / root
    covariance = np.linalg.inv((root * columns).T @ (root * columns))
    return probe, np.sqrt(np.diag(covariance)[1:])


def trials(probe, jitter):
    """The probe at 1000 scales, each time rounded a little differently."""
    rng = np.random.default_rng(0)
    for scale in 10 ** rng.uniform(-3, 6, 1000):
        yield scale, scale * probe * (1 + jitter * rng.normal(size=probe.shape))


def test_figures_of_lights_that_rounding_orders_name_the_right_light():
    # Different weights left and right: the lamps have standard errors of their own.
    weights = SOLID_ANGLES * np.where(NORMALS[:, 0] > 0, 1.0, 4.0)
    probe, uncertainty = a_probe_that_fits(weights)
    assert uncertainty[0] > 1.2 * uncertainty[1]
    orders = set()
    for number, (scale, measured) in enumerate(trials(probe, jitter=5e-15)):
        given = [0, 1] if number % 2 else [1, 0]
        rig = el.fit_probe(NORMALS, measured, 2, weights=weights, fixed=LAMPS[given])
        rows = list(rig.report.fixed)
        orders.add(tuple(np.array(given)[rows]))
        np.testing.assert_array_equal(rig.lights.direction[rows], LAMPS[given])
        np.testing.assert_allclose(rig.lights.irradiance[rows], scale * COLOURS[given], rtol=1e-9)
        errors = np.array(rig.report.irradiance_errors)[rows]
        relative = errors / errors.sum(axis=0)
        wanted = (uncertainty / uncertainty.sum())[given]
        np.testing.assert_allclose(relative, np.stack([wanted] * 3, axis=1), rtol=1e-6)
        assert rig.report.direction_errors == (0.0, 0.0)
    assert orders == {(0, 1), (1, 0)}  # rounding did decide


def test_the_fixed_one_of_two_lights_that_are_alike_is_named():
    probe, _ = a_probe_that_fits(SOLID_ANGLES)
    rows = set()
    for number, (_, measured) in enumerate(trials(probe, jitter=3e-3)):
        lamp = LAMPS[[number % 2]]
        rig = el.fit_probe(NORMALS, measured, 2, weights=SOLID_ANGLES, fixed=lamp)
        (row,) = rig.report.fixed
        rows.add(row)
        np.testing.assert_array_equal(rig.lights.direction[[row]], lamp)
        assert rig.report.direction_errors[row] == 0.0 < rig.report.direction_errors[1 - row]
    assert rows == {0, 1}


def test_what_is_in_order_stays_when_it_is_sorted_again():
    rng = np.random.default_rng(2)
    for count in range(2, 40):
        # Equal luminance up to rounding, each row at another place than before.
        share = rng.dirichlet(np.ones(3), size=count)
        irradiance = share / LUMINANCE * 10 ** rng.uniform(-6, 6)
        once = irradiance[brightest_first(irradiance)]
        np.testing.assert_array_equal(brightest_first(once), np.arange(count))
        np.testing.assert_array_equal(
            el.Lights(np.tile([0, 1, 0], (count, 1)), once).irradiance, once
        )


def test_equals_keep_their_order():
    assert brightest_first(np.ones((5, 3))).tolist() == [0, 1, 2, 3, 4]
    assert brightest_first(np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0.0]])).tolist() == [2, 1, 0]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"direction": [[0, 2, 0]]}, "direction 0 has length 2"),
        ({"irradiance": [[1, -1, 1]]}, "not negative"),
        ({"solid_angle": [1, 2]}, r"solid_angle must have a row for each light \(1\); got 2"),
    ],
)
def test_detected_lights_are_checked_as_others_are(change, message):
    lamp = el.synthetic.Disc((1, 0, 0), 5.0, (9, 9, 9))
    world = el.synthetic.scene(64, background=[0.1] * 3, shapes=[lamp])
    lights = el.detect(world.radiance)
    with pytest.raises(el.EnvLightsError, match=message):
        replace(lights, **change)


RADII = np.deg2rad([0, 0.27, 3, 20, 60, 90])


def anywhere(radii, seed=0):
    """Lights of these radii, of random directions and colours."""
    rng = np.random.default_rng(seed)
    at = el.kernels.uniform_sphere(rng.random((len(radii), 2)))
    return el.Lights(at, rng.gamma(2.0, 1.0, (len(radii), 3)), radii)


def relative(seen, wanted):
    return np.linalg.norm(seen - wanted) / np.linalg.norm(wanted)


def test_sizes_stand_in_the_order_of_the_lights():
    lights = el.Lights(np.eye(3), [[1, 1, 1], [3, 3, 3], [2, 2, 2]], [0.1, 0.3, 0.2])
    assert lights.angular_radius.tolist() == [0.3, 0.2, 0.1]
    assert lights[1:].angular_radius.tolist() == [0.2, 0.1]
    assert lights.to_dict()["angular_radius"] == [0.3, 0.2, 0.1]
    assert copy.deepcopy(lights).to_dict() == lights.to_dict()
    assert not lights.angular_radius.flags.writeable
    assert el.Lights(np.eye(3), np.ones((3, 3))).angular_radius.tolist() == [0, 0, 0]


def test_the_table_has_sizes_where_a_light_has_one():
    sized = el.Lights(np.eye(3)[:2], [[2, 2, 2], [1, 1, 1]], np.deg2rad([12.345, 0]))
    header, first, second = str(sized).splitlines()
    assert "radius" in header
    assert "66.7 %  12.35°          2" in first
    assert "33.3 %   0.00°          1" in second
    assert "radius" not in str(el.Lights(np.eye(3), np.ones((3, 3))))


@pytest.mark.parametrize(
    ("radius", "message"),
    [
        ([0.1], r"a row for each light \(2\); got 1"),
        ([0.1, 1.6], r"from 0 to pi / 2 radians; row 1 holds 1.6"),
        ([-0.1, 0], r"row 0 holds -0.1"),
        ([0, np.nan], r"row 1 holds nan"),
        (["a", "b"], r"angular_radius must hold real numbers"),
        (0.1, r"angular_radius must have 1 axes"),
    ],
)
def test_impossible_sizes_are_refused(radius, message):
    with pytest.raises(el.EnvLightsError, match=message):
        el.Lights(np.eye(3)[:2], np.ones((2, 3)), radius)


def test_sizes_of_zero_change_no_bit():
    """Against equations 4 to 6 for points, in NumPy and in the same order."""
    for rig in el.synthetic.rigs(20):
        points = dark = el.kernels.rig_irradiance(NORMALS, rig.ambient, DARK, DARK)
        for (x, y, z), irradiance in zip(rig.lights.direction, rig.lights.irradiance, strict=True):
            cosine = NORMALS[:, 0] * x + NORMALS[:, 1] * y + NORMALS[:, 2] * z
            points = points + irradiance * np.maximum(cosine, 0)[:, None]
        assert (points > dark).any()
        np.testing.assert_array_equal(rig.probe(NORMALS), points)


def test_kernels_refuse_impossible_sizes():
    for radii, message in (([2.0], "from 0 to 1.57"), ([np.nan], "from 0 to"), ([], "1.*got 0")):
        with pytest.raises(el.EnvLightsError, match=f"angular_radius must .*{message}"):
            el.kernels.rig_irradiance(NORMALS, [0] * 3, [[0, 1, 0]], [[1, 1, 1]], radii)


@pytest.mark.parametrize("radius", [0.005, 0.3, 1.0, np.pi / 2])
def test_the_probe_of_a_disc_is_its_integral(radius):
    """Rings of the half space before the normal, each with the azimuths inside the disc."""
    up, cosines = np.array([0, 1.0, 0]), np.cos(np.linspace(0.02, np.pi - 0.02, 41))
    towards = np.stack([np.sqrt(1 - cosines**2), cosines, 0 * cosines], axis=1)
    # Close to the horizon, where it cuts a small disc.
    near = np.pi / 2 + radius * np.linspace(-1.1, 1.1, 23)
    towards = np.concatenate([towards, np.stack([np.sin(near), np.cos(near), 0 * near], axis=1)])
    for direction in towards:
        seen = el.kernels.rig_irradiance([up], [0] * 3, [direction], [[1, 1, 1]], [radius])[0, 0]
        centre = np.arccos(np.clip(direction[1], -1, 1))

        def ring(theta, centre=centre):
            scale = np.sin(theta) * np.sin(centre)
            cosine = (np.cos(radius) - np.cos(theta) * np.cos(centre)) / max(scale, 1e-300)
            width = 2 * np.arccos(np.clip(cosine, -1, 1))
            return np.cos(theta) * np.sin(theta) * width / (np.pi * np.sin(radius) ** 2)

        low, high = max(centre - radius, 0), min(centre + radius, np.pi / 2)
        ends = [abs(centre - radius), centre + radius]
        inner = [end for end in ends if low < end < high]
        wanted = (
            quad(ring, low, high, points=inner or None, epsabs=1e-10, limit=400)[0]
            if high > low
            else 0.0
        )
        assert abs(seen - wanted) < 1e-8, (direction, seen, wanted)


def test_a_map_of_lights_lights_as_they_do():
    """Two ways to one number: pixels summed by the map's kernel, and the closed form of discs."""
    for seed in range(3):
        lights = anywhere(RADII[2:], seed)
        rig = el.Rig([0.1, 0.2, 0.3], lights, error=0.0)
        assert relative(rig.to_map(256).probe(NORMALS), rig.probe(NORMALS)) < 2e-4
        harmonic = el.Rig(el.synthetic.rigs(1, seed)[0].ambient, lights, error=0.0)
        assert relative(harmonic.to_map(256).probe(NORMALS), harmonic.probe(NORMALS)) < 2e-4


@given(st.integers(0, 2**32 - 1), st.floats(0, 1), st.integers(16, 100))
def test_every_light_on_a_map_keeps_irradiance_and_direction(seed, share, height):
    """The first moment of a map of one light, from its probe along three axes and back."""
    light = anywhere([share**4 * np.pi / 2], seed)
    env = light.to_map(height)
    difference = env.probe(np.eye(3)) - env.probe(-np.eye(3))
    wanted = light.direction.T * light.irradiance
    # The map holds single precision.
    np.testing.assert_allclose(difference, wanted, atol=2e-6 * light.irradiance.max())
    assert env.radiance.min() >= 0


def test_maps_of_lights_add_up():
    lights = anywhere(RADII)
    apart = sum(lights[k : k + 1].to_map(64).radiance.astype(float) for k in range(len(lights)))
    np.testing.assert_allclose(lights.to_map(64).radiance, apart, rtol=1e-5)


@pytest.mark.parametrize("height", [0, 1, 2.5, "a", 2**32 - 1])
def test_impossible_heights_are_refused(height):
    with pytest.raises((el.EnvLightsError, MemoryError), match=r"height must be|no memory"):
        anywhere(RADII).to_map(height)


@pytest.mark.parametrize("height", [64, 256])
@pytest.mark.parametrize("pixels", [0, 1, 1.5, 4, 9])
def test_a_map_of_what_was_detected_in_a_map_of_lights_lights_the_same(height, pixels):
    """`to_map` and `detect` are a fixed point for a light of any size at any position."""
    for seed in range(20):
        light = anywhere([pixels * np.pi / height], seed)
        drawn = el.Rig(light.irradiance[0] * 1e-3, light, error=0.0).to_map(height)
        found = el.detect(drawn)
        assert len(found) == 1
        again, once = (each.to_map(height) for each in (found, light))
        assert relative(again.probe(NORMALS), once.probe(NORMALS)) < 0.01
        assert (
            np.rad2deg(np.arccos((found.direction @ light.direction.T).min())) < 0.1 * 180 / height
        )


def test_a_detected_disc_has_the_flux_and_size_that_were_detected():
    for radius in RADII[2:4]:
        found = el.detect(anywhere([radius]).to_map(512))
        disc = found.discs()
        # The rim covers parts of pixels, which count in part: 0.15 pixels more.
        assert abs(found.angular_radius[0] - radius) < 0.25 * np.pi / 512
        assert disc.angular_radius == found.angular_radius
        np.testing.assert_array_equal(disc.irradiance, found.irradiance)
        # The sum over pixels and the closed form differ by the corners of the rim's pixels.
        flux = disc.irradiance * 2 / (1 + np.cos(disc.angular_radius))
        np.testing.assert_allclose(flux, found.flux, rtol=2e-3)
        wanted = 2 * np.pi * (1 - np.cos(disc.angular_radius))
        np.testing.assert_allclose(found.solid_angle, wanted, rtol=1e-9)
        assert found.to_dict()["angular_radius"] == found.angular_radius.tolist()
        assert found[:1].angular_radius == found.angular_radius


def test_lobes_have_the_irradiance_and_the_spread_of_their_lights():
    lights = anywhere(RADII)
    lobes = lights.spherical_gaussians()
    np.testing.assert_array_equal(lobes.axis, lights.direction)
    for sharpness, amplitude, irradiance, radius in zip(
        lobes.sharpness, lobes.amplitude, lights.irradiance, lights.angular_radius, strict=True
    ):

        def moment(weight, least, k=sharpness):
            """Moment of the lobe over 1 - cos, in units of its width."""
            upper = min((1 - least) * k, 60)
            return 2 * np.pi / k * quad(lambda x: np.exp(-x) * weight(x / k), 0, upper)[0]

        np.testing.assert_allclose(amplitude * moment(lambda t: 1 - t, 0), irradiance, rtol=1e-7)
        spread = moment(lambda t: t, -1) / moment(lambda _: 1, -1)
        wanted = np.sin(max(radius, np.deg2rad(0.265)) / 2) ** 2
        np.testing.assert_allclose(spread, wanted, rtol=1e-3)
    # A lobe is nearly a disc to a probe.
    at, solid_angles = el.kernels.icosphere(81920)
    wide = anywhere(RADII[3:4])
    ((axis,), (k,), (amplitude,)) = wide.spherical_gaussians()
    radiance = np.exp(k * (at @ axis - 1))[:, None] * amplitude
    seen = np.maximum(NORMALS @ at.T, 0) * solid_angles @ radiance
    rig = el.Rig([0] * 3, wide, error=0.0)
    assert relative(seen, rig.probe(NORMALS)) < 0.01


def test_rows_of_several_lengths_take_no_lights():
    lights = el.Lights(np.eye(3), np.eye(3))
    with pytest.raises(el.EnvLightsError, match="an index of lights must be a number"):
        lights[[[0, 1], [2]]]


def test_irradiance_beyond_single_precision_is_refused():
    with pytest.raises(el.EnvLightsError, match=r"at most 3\.4e\+38"):
        el.Lights([[0, 1, 0]], [[1e308, 1, 1]])
    with pytest.raises(el.EnvLightsError, match="ambient"):
        el.Rig([1e308, 1, 1], el.Lights([[0, 1, 0]], [[1, 1, 1]]), error=0.0)


def test_a_light_at_a_pole_has_no_azimuth_in_texts():
    lights = el.Lights([[0, 1, 0], [1e-9, -1, 0], [0, 0.999, 0.0447]], [[3] * 3, [2] * 3, [1] * 3])
    rows = [line.split()[1:3] for line in str(lights).splitlines()[1:]]
    assert rows == [["zenith", "+90.0°"], ["nadir", "-90.0°"], ["180.0°", "+87.4°"]]
    assert lights[0].in_short() == "at the zenith, 50 %"
    script = el.export.blender(lights).splitlines()
    places = [line.split("# ")[1] for line in script if line.startswith("    ([")]
    assert places == ["zenith", "nadir", "azimuth 180.0 degrees, elevation +87.4 degrees"]
    assert "\n".join(script).isascii()
