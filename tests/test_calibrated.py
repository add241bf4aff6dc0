"""Maps in candela per square metre, from readings of meters and from exposures."""

import copy
import pickle

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
import pytest
from hypothesis import given
from hypothesis import strategies as st

import envlights as el
from envlights.kernels.image import LUMINANCE
from envlights.papers.loghin import Settings
from tests.reference import srgb

OWN = "the map's own scale"
FACINGS = ([0, 1, 0], [0, -1, 0], [0.6, 0.8, 0], [0, 0, 1])


def random_map(seed=0, height=16):
    return el.EnvMap(np.random.default_rng(seed).random((height, 2 * height, 3)))


def clipped_map():
    """A sky with a clipped sun 45 degrees above the horizon, in front of us."""
    sky = np.full((64, 128, 3), 0.1) * [0.8, 1.0, 1.2]
    sky[14:18, 62:66] = 1.0
    return el.EnvMap(sky, clip_level=1.0)


def write_photograph(path, tags, value=0.5):
    spec = oiio.ImageSpec(16, 8, 3, oiio.UINT8)
    for name, number in tags.items():
        spec.attribute(name, number)
    image = oiio.ImageOutput.create(str(path))
    image.open(str(path), spec)
    image.write_image(np.full((8, 16, 3), round(255 * value), np.uint8))
    image.close()


#: 1/125 s at f/8 and ISO 200.
TAGS = {"ExposureTime": 1 / 125, "FNumber": 8.0, "Exif:PhotographicSensitivity": 200}
EV100 = np.log2(8**2 * 125 * 100 / 200)


@given(st.integers(0, 99), st.floats(0.01, 2e5), st.sampled_from(FACINGS))
def test_the_surface_receives_the_lux_that_were_measured(seed, lux, normal):
    env = random_map(seed).calibrated(lux=lux, normal=normal)
    assert env.units == "cd/m2"
    np.testing.assert_allclose(env.probe(normal) @ LUMINANCE, lux, rtol=1e-5)


def test_a_uniform_sky_of_pi_lux_has_one_candela():
    env = el.EnvMap(np.full((16, 32, 3), 7.0)).calibrated(lux=np.pi)
    np.testing.assert_allclose(env.radiance, 1, rtol=1e-5)


def test_a_border_sampled_map_receives_its_lux():
    env = el.EnvMap(
        random_map().radiance, layout=el.io.Layout(registration="border-sampled")
    ).calibrated(lux=300)
    assert env.is_border_sampled
    np.testing.assert_allclose(env.probe([0, 1, 0]) @ LUMINANCE, 300, rtol=1e-5)


@pytest.mark.parametrize("registration", ["cell-centred", "border-sampled"])
def test_a_pixel_has_the_luminance_that_was_measured(registration):
    smooth = el.EnvMap(np.full((32, 64, 3), 0.2), layout=el.io.Layout(registration=registration))
    env = smooth.calibrated(nits=4000, at=(5, 60))
    np.testing.assert_allclose(env.radiance @ LUMINANCE, 4000, rtol=1e-5)


def test_a_disc_smaller_than_a_pixel_is_that_pixel():
    env = random_map()
    for row, column in ((0, 0), (7, 31), (15, 8)):
        found = env.calibrated(nits=250, at=(row, column), patch=0)
        np.testing.assert_allclose(found.radiance[row, column] @ LUMINANCE, 250, rtol=1e-5)
    even = el.EnvMap(np.linspace(0.1, 1, 16)[:, None, None] * np.ones((32, 3)))
    for height, row in ((1, 0), (-1, 15)):
        found = even.calibrated(nits=250, at=(0, height, 0), patch=0)
        np.testing.assert_allclose(found.radiance[row] @ LUMINANCE, 250, rtol=1e-5)


@given(st.integers(0, 20), st.floats(1, 120), st.sampled_from(FACINGS))
def test_the_luminance_is_the_mean_over_the_disc(seed, diameter, at):
    """The pixels of the disc, chosen and weighted by the directions of the whole map."""
    env = random_map(seed)
    found = env.calibrated(nits=100, at=at, patch=diameter).radiance @ LUMINANCE
    cosine = el.kernels.pixel_directions(16, 32) @ np.array(at)
    is_in = cosine >= min(np.cos(np.radians(diameter / 2)), cosine.max())
    weight = el.kernels.pixel_solid_angles(16, 32)[is_in]
    np.testing.assert_allclose(weight @ found[is_in] / weight.sum(), 100, rtol=1e-5)


def test_a_value_of_one_is_the_saturation_of_the_exposure():
    env = random_map().calibrated(ev100=15)
    np.testing.assert_allclose(env.radiance, 1.2 * 2**15 * random_map().radiance, rtol=1e-6)


@pytest.mark.parametrize(
    "normal", [None, [0, 1, 0], [0.6, 0.8, 0], [0, np.sqrt(0.5), np.sqrt(0.5)]]
)
def test_readings_in_sun_and_shade_hold_both(normal):
    """The surface receives the sum, and the second reading without the clipped pixels."""
    world = clipped_map()
    env = world.calibrated(lux=98000, shaded=15000, normal=normal)
    towards = [0, 1, 0] if normal is None else normal
    is_sun = (world.radiance >= 1).all(axis=2)
    shade = el.EnvMap(np.where(is_sun[..., None], 0, env.radiance))
    np.testing.assert_allclose(env.probe(towards) @ LUMINANCE, 98000, rtol=1e-5)
    np.testing.assert_allclose(shade.probe(towards) @ LUMINANCE, 15000, rtol=1e-4)
    assert env.clip_level is None


def test_readings_that_contradict_the_map_are_refused_with_the_figures():
    """The clipped sun alone gives more than a hundredth of the light."""
    wanted = r"lux and shaded, 1010 and 1000, contradict the map: ratio must be at least .* 1\.\d+"
    with pytest.raises(el.EnvLightsError, match=wanted):
        clipped_map().calibrated(lux=1010, shaded=1000)
    with pytest.raises(el.EnvLightsError, match="below the horizon of the surface"):
        clipped_map().calibrated(lux=2000, shaded=1000, normal=[0, -1, 0])


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ({"lux": 1, "nits": 1, "at": (0, 0)}, "one scale; got lux and nits"),
        ({"nits": 1}, "nits needs the measured place"),
        ({"at": (0, 0)}, "at belongs to nits"),
        ({"normal": (0, 1, 0), "ev100": 3}, "normal belongs to lux"),
        ({"shaded": 3}, "shaded belongs to lux"),
        ({"lux": 0}, "lux must be above 0"),
        ({"lux": -1}, "lux must be a finite number"),
        ({"lux": 1, "normal": (0, 2, 0)}, "length"),
        ({"lux": 1, "shaded": 2}, "shaded must be below lux.*2 lux in the shade and 1 in the sun"),
        ({"lux": 2, "shaded": 1}, "no pixel is clipped"),
        ({"nits": 1, "at": (16, 0)}, "16 rows and 32 columns; got \\(16, 0"),
        ({"nits": 1, "at": (1, 2, 3, 4)}, "got 4 numbers"),
        ({"ev100": 1000}, "ev100 must be a finite number"),
        ({"lux": 1e300}, "single precision"),
        ({"patch": 200, "lux": 1}, "patch must be"),
        ({}, "give a reading: lux=, nits= with at=, or ev100="),
    ],
)
def test_other_readings_are_refused(arguments, reason):
    with pytest.raises(el.EnvLightsError, match=reason):
        random_map().calibrated(**arguments)


def test_the_exposure_calibrates_a_map_once_and_a_meter_again():
    once = random_map().calibrated(ev100=10)
    with pytest.raises(el.EnvLightsError, match="in cd/m2 already"):
        once.calibrated(ev100=10)
    again = once.calibrated(lux=300).calibrated(lux=300)
    np.testing.assert_allclose(again.probe([0, 1, 0]) @ LUMINANCE, 300, rtol=1e-5)


def test_places_without_a_luminance_are_refused():
    with pytest.raises(el.EnvLightsError, match="the map is black there"):
        el.EnvMap(np.zeros((8, 16, 3))).calibrated(lux=3)
    with pytest.raises(el.EnvLightsError, match="clipped at 1"):
        clipped_map().calibrated(nits=3, at=(15, 63))
    seen = np.ones((16, 32))
    seen[15] = 0
    with pytest.raises(el.EnvLightsError, match="does not show all of the disc"):
        el.EnvMap(np.ones((16, 32, 3)), coverage=seen).calibrated(nits=3, at=(15, 3))


def test_the_clip_level_and_what_is_seen_keep_their_place():
    seen = np.ones((64, 128))
    seen[60:] = 0
    world = el.EnvMap(clipped_map().radiance, clip_level=1.0, coverage=seen)
    env = world.calibrated(ev100=0)
    assert env.clip_level == pytest.approx(1.2)
    assert env.clipped_fraction == world.clipped_fraction
    np.testing.assert_array_equal(env.coverage, world.coverage)


def test_a_second_reading_replaces_the_first():
    env = random_map().calibrated(lux=5).calibrated(lux=10)
    np.testing.assert_allclose(env.probe([0, 1, 0]) @ LUMINANCE, 10, rtol=1e-5)
    assert sum("calibrated" in note for note in env.notes) == 1


def test_the_exposure_of_a_photograph_is_in_its_exif(tmp_path):
    path = tmp_path / "map.jpg"
    write_photograph(path, TAGS)
    env = el.EnvMap.open(path)
    assert env.ev100 == pytest.approx(EV100, abs=1e-4)
    found = env.calibrated()
    np.testing.assert_allclose(found.radiance, 1.2 * 2**EV100 * env.radiance, rtol=1e-3)
    assert "EXIF" in found.notes[-1]
    assert env.rotated(np.eye(3)).ev100 == env.ev100


def test_the_exposure_of_a_tiff_is_in_its_exif(tmp_path):
    """A library other than ours writes it: OpenImageIO leaves the sensitivity out."""
    image = pytest.importorskip("PIL.Image")
    fraction = pytest.importorskip("PIL.TiffImagePlugin").IFDRational
    exif = image.Exif()
    camera = exif.get_ifd(0x8769)
    camera.update({0x829A: fraction(1, 125), 0x829D: fraction(8, 1), 0x8827: 200})
    exif[0x8769] = camera
    image.new("RGB", (16, 8), (128, 128, 128)).save(tmp_path / "map.tif", exif=exif)
    assert el.EnvMap.open(tmp_path / "map.tif").ev100 == pytest.approx(EV100, abs=1e-4)


@pytest.mark.parametrize("missing", TAGS)
def test_an_exposure_without_a_tag_is_unknown(missing, tmp_path):
    write_photograph(tmp_path / "map.jpg", {k: v for k, v in TAGS.items() if k != missing})
    env = el.EnvMap.open(tmp_path / "map.jpg")
    assert env.ev100 is None
    with pytest.raises(el.EnvLightsError, match="give a reading"):
        env.calibrated()


def test_merged_exposures_have_the_scale_of_their_exif(tmp_path):
    """Grey of 2000 cd/m2 in three exposures: linear 16-bit values below saturation."""
    for j, time in enumerate((1 / 500, 1 / 250, 1 / 125)):
        tags = {**TAGS, "ExposureTime": time}
        ev100 = np.log2(8**2 / time * 100 / 200)
        linear = 2000 / (1.2 * 2**ev100)
        write_photograph(tmp_path / f"{j}.jpg", tags, srgb.encode(linear))
    merged = el.EnvMap.from_exposures(sorted(tmp_path.glob("*.jpg")))
    assert merged.ev100 == 0
    np.testing.assert_allclose(merged.calibrated().radiance, 2000, rtol=0.03)
    times = el.EnvMap.from_exposures(sorted(tmp_path.glob("*.jpg")), [1, 2, 4])
    assert times.ev100 is None


DERIVED = {
    "rotated": lambda env: env.rotated(np.eye(3)[[1, 2, 0]]),
    "resized": lambda env: env.resized(32),
    "limited": lambda env: env.limited(1e9),
    "filled": lambda env: el.EnvMap(
        env.radiance, units=env.units, coverage=np.linspace(0, 1, 64)[::-1, None] * np.ones(128)
    ).filled("black"),
    "repaired": lambda env: env.repaired(),
    "to": lambda env: env.to("cube"),
    "view": lambda env: env.view([0, 0, 1]),
    "detect": lambda env: el.detect(env),
    "loghin": lambda env: el.papers.loghin.detect(env, settings=Settings(threshold=1e4)),
    "one light": lambda env: el.detect(env)[:1],
    "discs": lambda env: el.detect(env).discs(),
    "lights of split": lambda env: el.split(env).lights,
    "rest of split": lambda env: el.split(env).remainder,
    "fit": lambda env: el.fit(env, 1),
    "lights of fit": lambda env: el.fit(env, 1).lights,
    "slice": lambda env: el.fit(env, 1).lights[:1],
    "paper": lambda env: el.papers.madsen.fit(env, 1, max_steps=1),
    "turned rig": lambda env: el.fit(env, 1).rotated(np.eye(3)[[1, 2, 0]]),
    "map of rig": lambda env: el.fit(env, 1).to_map(16),
    "map of lights": lambda env: el.fit(env, 1).lights.to_map(16),
    "pickle": lambda env: pickle.loads(pickle.dumps(env)),
    "pickled rig": lambda env: pickle.loads(pickle.dumps(el.fit(env, 1))),
    "pickled lights": lambda env: pickle.loads(pickle.dumps(el.detect(env))),
    "copy": copy.deepcopy,
}


@pytest.mark.parametrize("name", DERIVED)
def test_units_are_those_of_the_map(name):
    world = clipped_map()
    assert DERIVED[name](world).units == OWN
    assert DERIVED[name](world.calibrated(ev100=15)).units == "cd/m2"


def test_a_fit_is_the_same_in_other_units():
    world = clipped_map()
    rig, lit = el.fit(world, 1), el.fit(world.calibrated(ev100=10), 1)
    np.testing.assert_allclose(lit.lights.irradiance, 1.2 * 2**10 * rig.lights.irradiance, 1e-4)
    assert lit.error == pytest.approx(rig.error, rel=1e-4)


def test_texts_say_lux_and_candela():
    env = clipped_map().calibrated(lux=20000)
    assert "in cd/m2" in repr(env)
    assert "luminance in cd/m2: median" in str(env)
    rig = el.fit(env, 1)
    assert "irradiance in lux (R, G, B)" in str(rig)
    assert "ambient radiance in cd/m2" in str(rig)
    assert "irradiance in lux" in str(el.detect(env))
    plain = str(el.fit(clipped_map(), 1))
    assert "in lux" not in plain
    assert "cd/m2" not in plain


def test_equality_and_units():
    env = random_map()
    assert el.EnvMap(env.radiance, units="cd/m2") != env
    lamp = el.Lights([[0, 1, 0]], [[1, 1, 1]])
    assert el.Lights([[0, 1, 0]], [[1, 1, 1]], units="cd/m2") != lamp
    for make in (
        lambda: el.EnvMap(env.radiance, units="lux"),
        lambda: el.Lights([[0, 1, 0]], [[1, 1, 1]], units="lux"),
    ):
        with pytest.raises(el.EnvLightsError, match="units must be"):
            make()
