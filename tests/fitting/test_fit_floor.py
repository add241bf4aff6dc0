"""A floor in the scene: light from below the horizon neither counts nor is used."""

from functools import cache

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from envlights.fitting.request import request_of
from tests.conftest import real_maps

NORMALS, SOLID_ANGLES = kernels.icosphere(1280)
LAMP_BELOW = el.synthetic.Disc((0.3, -0.8, 0.5), 8, (50, 40, 30))


def hall():
    return el.synthetic.hall(128).radiance


def directions_of(radiance):
    height, width, _ = radiance.shape
    return kernels.pixel_directions(height, width)


def above_horizon(radiance):
    """`radiance`, black where it is below the horizon, as a floor without colour is."""
    return np.where(directions_of(radiance)[..., 1:2] > 0, radiance, 0)


@cache
def cosines(height):
    """Clamped cosines of NORMALS with the pixels above the horizon."""
    towards = kernels.pixel_directions(height, 2 * height)[: height // 2].reshape(-1, 3)
    return np.maximum(NORMALS @ towards.T, 0)


def summed_probe_over_floor(radiance):
    """Irradiance at NORMALS as a plain sum over the pixels above the horizon."""
    height, width, _ = radiance.shape
    flux = radiance.astype(float) * kernels.pixel_solid_angles(height, width)[..., None]
    return cosines(height) @ flux[: height // 2].reshape(-1, 3)


def probe_over_floor(rig, shape):
    """Irradiance under a rig over a floor: its ambient term is a map that the floor cuts."""
    ambient = summed_probe_over_floor(np.broadcast_to(rig.ambient, shape))
    return ambient + kernels.rig_irradiance(NORMALS, np.zeros(3), *arrays(rig.lights))


def arrays(lights):
    return lights.direction, lights.irradiance, lights.angular_radius


def errors_over_floor(rig, radiance):
    """Relative RMS error over a floor, all channels together and each alone."""
    wanted = summed_probe_over_floor(radiance)
    difference = probe_over_floor(rig, radiance.shape) - wanted
    square, whole = (SOLID_ANGLES @ values**2 for values in (difference, wanted))
    return np.sqrt(square.sum() / whole.sum()), np.sqrt(square / whole)


def test_light_from_below_alone_needs_no_light():
    lamp = el.synthetic.scene(128, background=[0.1] * 3, shapes=[LAMP_BELOW]).radiance
    below = lamp - above_horizon(lamp)
    for ambient in ("constant", "none", "auto"):
        rig = el.fit(below, floor=True, ambient=ambient)
        assert len(rig.lights) == 0
        assert not rig.ambient.any()
        assert rig.error == 0
        assert rig.report.stop_reason is el.rigs.StopReason.NOTHING_TO_FIT
    assert len(el.fit(below, lights=1).lights) == 1


def test_what_is_below_the_horizon_changes_nothing():
    radiance = hall()
    one = el.fit(radiance, floor=True)
    changed = np.where(directions_of(radiance)[..., 1:2] > 0, radiance, 7 * radiance + 1)
    other = el.fit(changed, floor=True)
    assert other.to_dict()["lights"] == one.to_dict()["lights"]
    assert other.error == one.error
    np.testing.assert_array_equal(other.ambient, one.ambient)


@pytest.mark.parametrize("ambient", ["constant", "none"])
@pytest.mark.parametrize("lights", [0, 1, 4, 8])
def test_the_error_is_that_of_an_integral_over_a_floor(lights, ambient):
    radiance = hall()
    rig = el.fit(radiance, lights=lights, ambient=ambient, floor=True)
    error, channels = errors_over_floor(rig, radiance)
    # Other normals, and pixels taken at their centres.
    assert rig.error == pytest.approx(error, rel=0.02, abs=1e-4)
    np.testing.assert_allclose(rig.report.channel_errors, channels, rtol=0.02, atol=1e-4)
    assert rig.report.measured_on == "all normals over a floor"


@pytest.mark.parametrize("lights", [2, 4, 8])
def test_over_a_floor_no_other_fit_is_better(lights):
    shapes = [LAMP_BELOW, el.synthetic.Disc((-0.5, 0.4, 0.2), 12, (9, 9, 7))]
    for radiance in (hall(), el.synthetic.scene(128, background=[0.5] * 3, shapes=shapes).radiance):
        over_floor, _ = errors_over_floor(el.fit(radiance, lights, floor=True), radiance)
        assert over_floor < errors_over_floor(el.fit(radiance, lights), radiance)[0]


def assert_none_below(radiance):
    for lights in (1, 2, 4, 8):
        for ambient in ("constant", "none"):
            rig = el.fit(radiance, lights, ambient=ambient, floor=True)
            assert (rig.lights.direction[:, 1] >= 0).all()
            assert (rig.ambient >= 0).all()


def test_no_light_stands_below_the_horizon():
    assert_none_below(hall())
    for seed in el.synthetic.EVALUATION[:4]:
        assert_none_below(el.synthetic.hard(seed, 128).radiance)


@real_maps("hdr/*.hdr")
def test_no_light_stands_below_the_horizon_of_real_maps(path):
    assert_none_below(el.EnvMap.open(path))


def test_a_light_that_the_horizon_cuts_stays_on_it():
    """All light comes from a band above the horizon; without the bound, lights would sink."""
    radiance = np.zeros((64, 128, 3), np.float32)
    radiance[31] = 1.0
    radiance[31, 40:50] = 20.0
    rig = el.fit(radiance, lights=6, ambient="none", floor=True)
    assert (rig.lights.direction[:, 1] >= 0).all()
    assert rig.error < 0.1


@pytest.mark.parametrize("start", ["even", "detect"])
def test_named_starts_stay_above_the_horizon(start):
    shapes = [LAMP_BELOW, el.synthetic.Disc((-0.5, 0.4, 0.2), 5, (50, 50, 50))]
    radiance = el.synthetic.scene(256, background=[0.1] * 3, shapes=shapes).radiance
    rig = el.fit(radiance, lights=3, start=start, floor=True)
    assert (rig.lights.direction[:, 1] >= 0).all()
    assert rig.error < 0.02


@pytest.mark.parametrize("start", ["even", "detect"])
def test_named_starts_are_places_above_the_horizon(start):
    """The lamp below is the brighter one: of one light that is detected it would be the place."""
    lamp = np.array([-0.5, 0.4, 0.2])
    shapes = [LAMP_BELOW, el.synthetic.Disc(lamp, 5, (30, 30, 30))]
    env = el.EnvMap(el.synthetic.scene(256, background=[0.1] * 3, shapes=shapes).radiance)
    for lights in (1, 5):
        places = request_of(lights, None, start, None).first_directions_under(env, True)
        assert (places[:, 1] >= 0).all()
        assert len(places) == (lights if start == "even" else 1)
    if start == "detect":
        np.testing.assert_allclose(places[0], lamp / np.linalg.norm(lamp), atol=0.01)


def test_a_rig_over_a_floor_is_followed():
    radiance = hall()
    before = el.fit(radiance, floor=True)
    after = el.fit(radiance, floor=True, start=before)
    np.testing.assert_allclose(after.lights.direction, before.lights.direction, atol=1e-6)
    fixed = el.fit(radiance, floor=True, fixed=before.lights)
    np.testing.assert_allclose(fixed.lights.irradiance, before.lights.irradiance, rtol=1e-5)
    assert fixed.error == pytest.approx(before.error, rel=1e-5)


BELOW = el.Lights([[0, 0.6, 0.8], [0.6, -0.8, 0]], [[2, 2, 2], [1, 1, 1]])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"ambient": "sh2"}, "ambient must be 'none' or 'constant' or 'auto' where there is a"),
        (
            {"start": BELOW},
            "start must have no light below the horizon .* direction 1 has y = -0.8",
        ),
        ({"start": el.Rig([0] * 3, BELOW, 0)}, "start must have no light below the horizon"),
        ({"fixed": [[0, -1, 0]]}, "fixed must have no light below the .* direction 0 has y = -1"),
        (
            {"fixed": [[0, 0.6, 0.8], [0.6, -0.8, 0], [0, -1, 0]]},
            "fixed must have no light below the .* direction 1 has y = -0.8",
        ),
        ({"floor": "no"}, "floor must be True or False; got 'no'"),
    ],
)
def test_what_a_floor_does_not_allow_is_refused(options, message):
    with pytest.raises(el.EnvLightsError, match=message):
        el.fit(np.ones((8, 16, 3)), **{"floor": True, **options})


def test_a_rig_over_a_floor_says_so_and_its_probe_is_that_over_one():
    rig = el.fit(hall(), lights=3, floor=True)
    assert rig.floor
    assert not el.fit(hall(), lights=3).floor
    wanted = summed_probe_over_floor(np.broadcast_to(rig.ambient, hall().shape))
    wanted += el.Rig([0, 0, 0], rig.lights, error=0.0).probe(NORMALS)
    np.testing.assert_allclose(rig.probe(NORMALS), wanted, rtol=1e-3, atol=1e-3 * wanted.max())
