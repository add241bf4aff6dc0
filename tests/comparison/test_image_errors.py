"""Errors of images that a user rendered."""

import numpy as np
import pytest

import envlights as el
from tests.reference import spheres as reference


def images(shape=(6, 7, 3)):
    rng = np.random.default_rng(4)
    return rng.random(shape) + 0.1, rng.random(shape) + 0.1


def test_the_errors_are_those_of_the_formulas():
    truth, guess = images()
    rmse, si_rmse, angle = reference.numbers(truth.reshape(-1, 3), guess.reshape(-1, 3))
    errors = el.comparison.image_errors(truth, guess)
    assert errors.rmse == pytest.approx(rmse)
    assert errors.si_rmse == pytest.approx(si_rmse)
    assert errors.angle == pytest.approx(angle)
    assert errors.relative == pytest.approx(rmse / np.sqrt((truth**2).mean()))
    assert errors.scale == pytest.approx((truth * guess).sum() / (guess**2).sum())


def test_the_published_sum_is_sqrt_3_of_the_mean():
    truth, guess = images()
    mean, total = (
        el.comparison.image_errors(truth, guess, channels=each) for each in ("mean", "sum")
    )
    assert total.rmse == pytest.approx(np.sqrt(3) * mean.rmse)
    assert total.si_rmse == pytest.approx(np.sqrt(3) * mean.si_rmse)
    assert (total.angle, total.relative) == (mean.angle, mean.relative)


def test_a_mask_counts_its_pixels_alone():
    truth, guess = images()
    mask = np.zeros((6, 7))
    mask[2:4, 1:] = 0.5
    masked = el.comparison.image_errors(truth, guess, mask)
    assert masked == el.comparison.image_errors(truth[2:4, 1:], guess[2:4, 1:])
    assert masked == el.comparison.image_errors(
        truth[2:4, 1:].reshape(-1, 3), guess[2:4, 1:].reshape(-1, 3)
    )


def test_tiny_angles_keep_their_digits():
    truth = np.ones((3, 3))
    guess = truth + np.array([1e-9, 0, -1e-9])
    expected = np.degrees(1e-9 * np.sqrt(2 / 3))
    assert el.comparison.image_errors(truth, guess).angle == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("unit", [1e80, 1.0, 1e-85])
def test_the_scaled_error_of_huge_and_tiny_images_is_that_of_others(unit):
    guess = unit * np.array([[1, 0, 1], [2, 1, 1]])
    errors = el.comparison.image_errors(np.full((2, 3), unit), guess)
    assert errors.si_rmse == pytest.approx(0.5 * unit, rel=1e-12)
    assert errors.si_relative == pytest.approx(0.5)


def test_black_pixels_are_left_out_of_the_angle_and_counted():
    truth, guess = images((4, 3))
    truth[0] = guess[1] = 0
    errors = el.comparison.image_errors(truth, guess)
    assert errors.black == 0.5
    assert errors.angle == pytest.approx(el.comparison.image_errors(truth[2:], guess[2:]).angle)
    black = el.comparison.image_errors(np.zeros((2, 3)), np.ones((2, 3)))
    assert (black.angle, black.relative, black.black) == (None, None, 1.0)
    assert "-" in str(black)


def test_errors_are_shown_as_text_html_and_numbers():
    errors = el.comparison.image_errors(*images())
    assert "RMSE" in str(errors)
    assert "<table" in errors._repr_html_()
    assert errors.to_dict()["si_rmse"] == errors.si_rmse


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.ones((2, 3)), np.ones((3, 3))), r"the same shape; got \(2, 3\) and \(3, 3\)"),
        ((np.ones((2, 4)), np.ones((2, 4))), r"truth must have the shape \(height, width, 3\)"),
        ((np.full((2, 3), np.nan), np.ones((2, 3))), "truth must be finite; row 0 holds nan"),
        ((np.ones((2, 3)), np.full((2, 3), 1e200)), "guess must be below 1e100"),
        ((np.ones((2, 3)), np.ones((2, 3)), np.zeros(2)), "mask must leave a pixel"),
        ((np.ones((2, 3)), np.ones((2, 3)), np.ones(3)), r"mask must be numbers of the shape"),
        ((np.ones((2, 3)), np.ones((2, 3)), "mask"), "mask must be"),
        ((np.zeros((0, 3)), np.zeros((0, 3))), "truth must have the shape"),
        ((3, 3), "truth must have the shape"),
    ],
)
def test_bad_images_are_refused(arguments, message):
    with pytest.raises(el.EnvLightsError, match=message):
        el.comparison.image_errors(*arguments)


def test_other_sums_are_refused():
    with pytest.raises(el.EnvLightsError, match="channels must be"):
        el.comparison.image_errors(*images(), channels="max")
