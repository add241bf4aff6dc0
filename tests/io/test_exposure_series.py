"""Series of exposures as cameras write them: JPEG, white below 255, other responses, motion."""

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
import pytest

import envlights as el
from envlights._common.srgb import decode_srgb, encode_srgb
from envlights.environment.decoders import raw
from envlights.environment.decoders.exif_exposure import exposure_of
from envlights.environment.exposures import alignment
from tests.reference.camera_curves import filmic, rec709, shoulder

TIMES = (0.002, 0.02, 0.2, 2.0, 8.0)
SUN = (slice(28, 36), slice(40, 48))


def world(sun=(400.0, 200.0, 80.0)):
    """Sky, structured ground, lamps of several radiances, and a square sun."""
    rng = np.random.default_rng(5)
    truth = np.full((128, 256, 3), 0.02)
    truth[64:] = 0.05 * rng.uniform(0.3, 2, (64, 256, 1))
    ramp = np.geomspace(0.01, 90, 96)
    truth[70:100, 140:236] = ramp[None, :, None]
    truth[SUN] = sun
    return truth


def codes(truth, curve=encode_srgb, clip_level=255, times=TIMES):
    return [
        np.minimum(np.round(255 * curve(truth * t)), clip_level).astype(np.uint8) for t in times
    ]


def save(path, picture, quality=None, **attributes):
    form = "float" if picture.dtype == np.float32 else str(picture.dtype)
    spec = oiio.ImageSpec(*picture.shape[1::-1], 3, form)
    if quality:
        spec.attribute("Compression", f"jpeg:{quality}")
        spec.attribute("jpeg:subsampling", "4:2:0")
    for name, value in attributes.items():
        spec.attribute(name.replace("__", ":"), value)
    file = oiio.ImageOutput.create(str(path))
    assert file.open(str(path), spec)
    file.write_image(picture)
    file.close()
    return path


def jpegs(folder, pictures, quality):
    return [save(folder / f"{n}.jpg", each, quality) for n, each in enumerate(pictures)]


def sun_over_ground(radiance):
    """Ratio of each channel, from the inside of the sun."""
    return radiance[30:34, 42:46].mean(axis=(0, 1)) / radiance[66:68, :120].mean()


def has_note(env, text):
    return any(text in note for note in env.notes)


# JPEG and white


@pytest.mark.parametrize(
    ("quality", "tolerance"), [(80, 0.15), (90, 0.05), (95, 0.05), (100, 0.05)]
)
@pytest.mark.parametrize("clip_level", [255, 250, 245, 240, 235])
def test_the_sun_keeps_its_radiance(tmp_path, quality, tolerance, clip_level):
    truth = world()
    env = el.EnvMap.from_exposures(
        jpegs(tmp_path, codes(truth, clip_level=clip_level), quality), TIMES
    )
    ratio = sun_over_ground(env.radiance) / sun_over_ground(truth)
    np.testing.assert_allclose(ratio, 1, atol=tolerance)
    if quality >= 90:
        assert has_note(env, f"end at code {clip_level} of 255") == (clip_level < 254)


def test_each_picture_may_have_its_own_white():
    truth = world()
    whites = (255, 254, 250, 240, 252)
    pictures = [np.minimum(*pair) for pair in zip(codes(truth), np.uint8(whites), strict=True)]
    env = el.EnvMap.from_exposures(pictures, TIMES)
    np.testing.assert_allclose(sun_over_ground(env.radiance), sun_over_ground(truth), rtol=0.05)


def test_a_shortest_exposure_at_white_is_said_to_be_clipped():
    truth = world(sun=(4000.0, 3000.0, 2000.0))
    for clip_level in (255, 245):
        env = el.EnvMap.from_exposures(codes(truth, clip_level=clip_level), TIMES)
        assert env.clip_level == pytest.approx(decode_srgb(1.0) / TIMES[0], rel=0.01)
        assert env.clipped_fraction > 0
        np.testing.assert_allclose(env.radiance[SUN], env.clip_level, rtol=0.01)


# Responses


def video(x):
    return (16 + 219 * encode_srgb(x)) / 255


@pytest.mark.parametrize(
    ("curve", "name"),
    [(rec709, "Rec.709"), (video, "sRGB in video range"), (shoulder, ""), (filmic, "")],
)
def test_a_response_that_is_not_srgb_is_recognised_or_estimated(curve, name):
    truth = world()
    env = el.EnvMap.from_exposures(codes(truth, curve), TIMES)
    assert has_note(env, "response of the camera is not sRGB; used: " + (name or "estimated"))
    ratio = sun_over_ground(env.radiance) / sun_over_ground(truth)
    np.testing.assert_allclose(ratio, 1, atol=0.08)
    # White of an estimated response is a guess: only then is the scale relative, which a note says.
    seen = (truth > 0.02) & (truth < 50)
    scale = np.median((env.radiance / truth)[seen])
    assert abs(scale - 1) < 0.005 if name else 1.03 < scale < 2
    assert has_note(env, "the radiance is relative") == (not name)


def test_a_response_by_hand_is_used():
    truth = world()
    table = np.interp(
        np.arange(256) / 255, shoulder(np.linspace(0, 1, 4096)), np.linspace(0, 1, 4096)
    )
    env = el.EnvMap.from_exposures(codes(truth, shoulder), TIMES, response=table)
    ratio = sun_over_ground(env.radiance) / sun_over_ground(truth)
    np.testing.assert_allclose(ratio, 1, atol=0.03)


@pytest.mark.parametrize("response", ["gamma", np.ones((3, 256)), -np.arange(256.0), 7, {}])
def test_what_is_no_response_is_refused(response):
    with pytest.raises(el.EnvLightsError, match="response must be 'srgb', 'linear' or 256"):
        el.EnvMap.from_exposures(codes(world()), TIMES, response=response)


# Times


@pytest.mark.parametrize("place", range(1, 5))
@pytest.mark.parametrize("factor", [0.4, 1.5, 3.0])
def test_one_wrong_time_is_corrected(place, factor):
    truth = world()
    times = list(TIMES)
    times[place] *= factor
    env = el.EnvMap.from_exposures(codes(truth), times)
    assert has_note(env, f"the time of exposure {place + 1} is wrong")
    ratio = sun_over_ground(env.radiance) / sun_over_ground(truth)
    np.testing.assert_allclose(ratio, 1, atol=0.05)


def test_a_wrong_time_of_two_is_refused_with_the_ratio():
    pictures = codes(world(), times=(0.2, 2.0))
    with pytest.raises(
        el.EnvLightsError, match=r"1 and 2 by a factor of (10|9\.9.), their times by 4"
    ):
        el.EnvMap.from_exposures(pictures, (0.5, 2.0))


def exif(folder, *shots):
    truth = world()
    return [
        save(folder / f"{n}.jpg", codes(truth, times=(time,))[0], 100, **tags)
        for n, (time, tags) in enumerate(shots)
    ]


def test_apex_and_fnumber_are_the_same(tmp_path):
    tags = [{"FNumber": 8.0}, {"Exif__ApertureValue": 6.0}, {"FNumber": 8.0}]
    times = (0.02, 0.2, 2.0)
    shots = [(t, {"ExposureTime": 64 * t, **tag}) for t, tag in zip(times, tags, strict=True)]
    env = el.EnvMap.from_exposures(exif(tmp_path, *shots))
    assert not has_note(env, "wrong")
    assert has_note(env, "times from 0.02 to 2")


@pytest.mark.parametrize("tag", [{"FNumber": 8.0}, {"Exif__PhotographicSensitivity": 400}])
@pytest.mark.parametrize("without", [0, 1, 2])
def test_a_tag_that_one_file_lost_is_a_refusal(tmp_path, tag, without):
    shots = [
        (t, {"ExposureTime": t, **({} if n == without else tag)})
        for n, t in enumerate((0.02, 0.2, 2.0))
    ]
    with pytest.raises(el.EnvLightsError, match=rf"{without + 1} of 3; give times"):
        el.EnvMap.from_exposures(exif(tmp_path, *shots))


def test_times_by_hand_win(tmp_path):
    shots = [(t, {"ExposureTime": 1.0}) for t in (0.02, 0.2, 2.0)]
    env = el.EnvMap.from_exposures(exif(tmp_path, *shots), (0.02, 0.2, 2.0))
    assert not has_note(env, "wrong")


# Motion


@pytest.mark.parametrize("shift", [(1, 0), (-3, 0), (2, 1), (0, -2)])
def test_a_shift_between_shots_is_removed(shift):
    truth = np.repeat(np.repeat(world()[::4, ::4], 4, 0), 4, 1)
    pictures = codes(truth)
    pictures[2:4] = [np.roll(picture, shift, (1, 0)) for picture in pictures[2:4]]
    env = el.EnvMap.from_exposures(pictures, TIMES)
    assert has_note(env, "was moved by")
    still = el.EnvMap.from_exposures(codes(truth), TIMES)
    ground = (slice(66, 96), slice(20, 120))
    spread = np.abs(env.radiance[ground] / still.radiance[ground] - 1)
    assert np.median(spread) < 0.03


def test_a_motion_is_recovered():
    rng = np.random.default_rng(0)
    noise = rng.uniform(0.05, 0.7, (256, 512)).astype(np.float32)
    field = el.EnvMap(np.repeat(el.kernels.blur(noise, 3.0, wrap=True)[..., None], 3, axis=2))
    for turn in np.deg2rad([[0.0, 1.0, 0.0], [0.7, 0.3, -1.1], [0, 0, 0.8]]):
        moved = field.rotated(alignment.rotation(turn)).radiance
        found = alignment.motion(field.radiance, moved, 0.0, 1.0)
        np.testing.assert_allclose(found.turn, turn, atol=np.deg2rad(0.08))
        assert found.rise == 0


# Kinds


def test_white_balance_that_drifts_is_noticed():
    truth = world()
    pictures = codes(truth)
    pictures[3] = codes(truth * [1.15, 1.0, 0.85])[3]
    env = el.EnvMap.from_exposures(pictures, TIMES)
    assert has_note(env, "exposures 3 and 4 differ in white balance")
    assert not has_note(env, "exposures 1 and 2 differ in white balance")


@pytest.mark.parametrize(
    ("pictures", "times", "message"),
    [
        (None, None, "two pictures or more; got None"),
        ({"a.jpg": 1.0, "b.jpg": 2.0}, None, "in a list; got a dict"),
        (7, None, "two pictures or more; got 7"),
        ([], None, "two pictures or more; got 0"),
        ([np.zeros((2, 4, 3))] * 2, {1: 2}, "times must be a list of numbers"),
        ([np.zeros((2, 4, 3))] * 2, 3, "times must be a list of numbers"),
        ([np.zeros((2, 4, 3)), np.zeros((2, 4, 3), "u1")], (1, 2), "must be of one kind"),
    ],
)
def test_what_is_no_series_is_refused(pictures, times, message):
    with pytest.raises(el.EnvLightsError, match=message):
        el.EnvMap.from_exposures(pictures, times)


def test_generators_are_series():
    pictures = codes(world())
    one = el.EnvMap.from_exposures(pictures, TIMES)
    other = el.EnvMap.from_exposures((each for each in pictures), (t for t in TIMES))
    np.testing.assert_array_equal(one.radiance, other.radiance)


def test_linear_floats_are_linear(tmp_path):
    truth = world()
    files = [
        save(tmp_path / f"{n}.exr", np.minimum(truth * t, 1).astype(np.float32))
        for n, t in enumerate(TIMES)
    ]
    env = el.EnvMap.from_exposures(files, TIMES)
    np.testing.assert_allclose(env.radiance, truth, rtol=1e-4)


# Raw files


def test_a_raw_file_without_its_library_names_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rawpy", None)
    for suffix in (".dng", ".CR2", ".nef", ".arw"):
        with pytest.raises(el.EnvLightsError, match=r"install envlights\[raw\]"):
            el.EnvMap.from_exposures([tmp_path / f"a{suffix}"] * 2, (1, 2))


class RawError(Exception):
    """Failure of the stand-in for rawpy."""


class RawFile:
    """File of the stand-in for rawpy, which holds only its exposure time."""

    def __init__(self, name):
        text = Path(name).read_text()
        if not text:
            raise RawError("Unsupported file format")
        self.time = float(text)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    @property
    def other(self):
        return SimpleNamespace(shutter_speed=self.time, iso_speed=100, aperture=1)

    def postprocess(self, **options):
        if self.time < 0:
            raise RawError("Unexpected end of file")
        assert options["gamma"] == (1, 1)
        assert options["output_bps"] == 16
        return np.round(65535 * np.clip(world() * self.time, 0, 1)).astype(np.uint16)


LIBRARY = SimpleNamespace(
    imread=RawFile,
    LibRawError=RawError,
    ColorSpace=SimpleNamespace(sRGB=1),
    HighlightMode=SimpleNamespace(Clip=0),
)


def test_raw_files_are_linear_and_hold_times(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rawpy", LIBRARY)
    paths = [tmp_path / f"{n}.dng" for n in range(5)]
    for path, time in zip(paths, TIMES, strict=True):
        path.write_text(str(time))
    env = el.EnvMap.from_exposures(paths)
    assert raw.NOTE in env.notes
    np.testing.assert_allclose(env.radiance[SUN], world()[SUN], rtol=1e-3)
    paths[2].write_text("")
    with pytest.raises(el.EnvLightsError, match="as a raw file: Unsupported file format"):
        el.EnvMap.from_exposures(paths, TIMES)
    paths[2].write_text("-1")
    with pytest.raises(el.io.DamagedFileError, match="cannot be decoded: Unexpected end of file"):
        el.EnvMap.from_exposures(paths, TIMES)


def test_values_that_no_camera_has_count_as_missing():
    extreme = {"FNumber": 1e200, "ExposureTime": 1e-200, "PhotographicSensitivity": 100.0}
    assert exposure_of(extreme) == {"speed": 100.0}
