"""Series of exposures, made from maps whose radiance is known."""

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
import pytest

import envlights as el
from envlights import synthetic
from envlights._common.srgb import encode_srgb

TIMES = (1 / 250, 1 / 60, 1 / 15, 1 / 4, 1.0, 4.0)


def hall():
    return np.maximum(synthetic.hall(64).radiance, 1e-3)


def series(radiance, times=TIMES, dtype=np.uint8):
    largest = np.iinfo(dtype).max
    return [np.round(largest * encode_srgb(radiance * time)).astype(dtype) for time in times]


def write_image(path, picture, **attributes):
    spec = oiio.ImageSpec(*picture.shape[1::-1], 3, "uint8")
    for name, value in attributes.items():
        spec.attribute("Exif:" * (name == "PhotographicSensitivity") + name, value)
    file = oiio.ImageOutput.create(str(path))
    assert file.open(str(path), spec)
    file.write_image(picture)
    file.close()
    return path


def is_exposed(radiance, times=TIMES):
    """Mask of the pixels that some exposure captures between 0.25 and 0.98."""
    exposed = np.multiply.outer(times, radiance)
    return ((exposed > 0.25) & (exposed < 0.98)).any(axis=0)


# The merge


@pytest.mark.parametrize(("dtype", "tolerance"), [(np.uint8, 0.03), (np.uint16, 1e-4)])
def test_radiance_is_exact_where_an_exposure_saw_it(dtype, tolerance):
    radiance = hall()
    env = el.EnvMap.from_exposures(series(radiance, dtype=dtype), TIMES)
    where = is_exposed(radiance)
    assert where.mean() > 0.7
    error = np.abs(env.radiance / radiance - 1)[where]
    assert error.max() < tolerance
    assert not any("contradict" in note or "differ" in note for note in env.notes)


def test_floats_are_linear():
    radiance = hall()
    pictures = [np.minimum(radiance * time, 1) for time in TIMES]
    env = el.EnvMap.from_exposures(pictures, TIMES)
    np.testing.assert_allclose(env.radiance, radiance, rtol=1e-5)
    assert env.clip_level is None


def test_the_order_of_the_exposures_does_not_matter():
    pictures = series(hall())
    one = el.EnvMap.from_exposures(pictures, TIMES)
    other = el.EnvMap.from_exposures(pictures[::-1], TIMES[::-1])
    np.testing.assert_array_equal(one.radiance, other.radiance)


def test_what_every_exposure_lost_ends_at_the_white_of_the_shortest():
    radiance = np.full((8, 16, 3), 0.5)
    radiance[2, 3] = 1000.0
    env = el.EnvMap.from_exposures(series(radiance), TIMES)
    assert env.clip_level == pytest.approx(250.0)
    assert env.radiance[2, 3, 0] == pytest.approx(250.0)
    assert env.clipped_fraction > 0


# Ghosts and times


def test_a_thing_that_moved_is_noticed_and_taken_from_one_exposure():
    radiance = np.full((32, 64, 3), 0.3)
    moved = radiance.copy()
    moved[10:14, 20:26] = 0.6
    times = (0.5, 1.0, 1.5)
    pictures = [*series(radiance, times[:2]), *series(moved, times[2:])]
    env = el.EnvMap.from_exposures(pictures, times)
    assert any("contradict each other on" in note for note in env.notes)
    inside = env.radiance[10:14, 20:26]
    assert (np.minimum(abs(inside / 0.3 - 1), abs(inside / 0.6 - 1)) < 0.01).all()  # no mean
    np.testing.assert_allclose(env.radiance[20:], 0.3, rtol=0.01)


def test_a_wrong_time_is_corrected_and_named():
    wrong = (*TIMES[:2], 1 / 30, *TIMES[3:])
    env = el.EnvMap.from_exposures(series(hall()), wrong)
    (note,) = [note for note in env.notes if "is wrong" in note]
    assert note.startswith("the time of exposure 3 is wrong: 0.0333 was replaced by 0.066")
    right = el.EnvMap.from_exposures(series(hall()), TIMES)
    np.testing.assert_allclose(env.radiance, right.radiance, rtol=0.01)


def test_exposures_too_far_apart_are_noticed():
    radiance = np.full((64, 128, 3), 0.5)
    radiance[:32] = 500.0
    env = el.EnvMap.from_exposures(series(radiance, (0.001, 1.0)), (0.001, 1.0))
    assert any("too few pixels in common to check their times" in note for note in env.notes)
    np.testing.assert_allclose(env.radiance[:32], 500.0, rtol=0.01)
    np.testing.assert_allclose(env.radiance[40:], 0.5, rtol=0.01)
    np.testing.assert_allclose(env.radiance[32:40], 0.5, rtol=0.25)  # near a clipped region


# Files


def test_times_come_from_the_files(tmp_path):
    radiance = hall()
    files = [
        write_image(tmp_path / f"{number}.jpg", picture, ExposureTime=float(time), FNumber=1.0)
        for number, (picture, time) in enumerate(zip(series(radiance), TIMES, strict=True))
    ]
    env = el.EnvMap.from_exposures(files)
    error = np.abs(env.radiance / radiance - 1)[is_exposed(radiance)]
    assert np.median(error) < 0.02  # JPEG


def test_aperture_and_sensitivity_count(tmp_path):
    radiance = np.full((8, 16, 3), 0.4)
    one = write_image(
        tmp_path / "1.jpg",
        *series(radiance, (1.0,)),
        ExposureTime=1.0,
        FNumber=1.0,
        PhotographicSensitivity=100,
    )
    half = {"ExposureTime": 1.0, "FNumber": 2.0, "PhotographicSensitivity": 200}
    other = write_image(tmp_path / "2.jpg", *series(radiance, (0.5,)), **half)
    env = el.EnvMap.from_exposures([one, other])
    assert not any("differ" in note for note in env.notes)
    np.testing.assert_allclose(env.radiance, radiance, rtol=0.02)


# Refusals


@pytest.mark.parametrize(
    ("pictures", "times", "message"),
    [
        ([np.zeros((2, 4, 3))], (1.0,), "two pictures or more"),
        ("one.jpg", None, "two pictures or more"),
        ([[[1, 2], [3]], [[1, 2], [3]]], (1, 2), "exposure 1 must be an array of numbers"),
        ([np.zeros((2, 4, 3))] * 2, None, "arrays hold no exposure times; give times"),
        ([np.zeros((2, 4, 3))] * 2, (1.0,), r"a time for each exposure \(2\); got 1"),
        ([np.zeros((2, 4, 3))] * 2, (1.0, 0.0), "time of exposure 2 must be above 0"),
        ([np.zeros((2, 4, 3))] * 2, (1.0, "a"), "time of exposure 2 must be a finite number"),
        ([np.zeros((2, 4, 3)), np.zeros((4, 8, 3))], (1, 2), "must have one size"),
        ([np.zeros((2, 4))] * 2, (1, 2), "exposure 1 must have the shape"),
        ([np.zeros((2, 4, 3), int)] * 2, (1, 2), "floating point, uint8 or uint16; got int64"),
        ([np.full((2, 4, 3), np.nan)] * 2, (1, 2), "samples that are not finite"),
        (["no.jpg", "none.jpg"], None, "there is no such file"),
    ],
)
def test_what_is_no_series_is_refused(pictures, times, message):
    with pytest.raises(el.EnvLightsError, match=message):
        el.EnvMap.from_exposures(pictures, times)


def test_a_file_with_samples_that_are_not_finite_is_refused(tmp_path):
    picture = np.full((2, 4, 3), 0.5, np.float32)
    el.io.write_exr(tmp_path / "whole.exr", picture)
    picture[0, 0] = np.nan
    el.io.write_exr(tmp_path / "damaged.exr", picture)
    with pytest.raises(el.EnvLightsError, match="exposure 2 holds samples that are not finite"):
        el.EnvMap.from_exposures([tmp_path / "whole.exr", tmp_path / "damaged.exr"], (1.0, 2.0))


def test_a_file_without_a_time_is_refused(tmp_path):
    file = write_image(tmp_path / "1.png", np.zeros((2, 4, 3), np.uint8))
    with pytest.raises(el.EnvLightsError, match="holds no exposure time in its EXIF; give times"):
        el.EnvMap.from_exposures([file, file])
