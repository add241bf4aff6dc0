"""Image errors: RMSE, scale-invariant RMSE, and angle between colours."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import check_choice, describe, first_not_finite, reals
from envlights._common.fields import fields_of
from envlights._common.result import Result
from envlights._common.tables import Table
from envlights._common.words import degrees, percent
from envlights._native import EnvLightsError
from envlights.comparison.angles import degrees_between


@dataclass(frozen=True, eq=False, repr=False)
class ImageErrors(Result):
    """Errors of an image or of a sphere."""

    rmse: float
    """Root mean square of the difference, in units of the image."""

    si_rmse: float
    """RMSE after scaling the guess by least squares."""

    angle: float | None
    """Mean angle between RGB vectors in degrees; None if all pixels are black."""

    relative: float | None
    """RMSE relative to the root mean square of the truth; None if the truth is black."""

    si_relative: float | None
    """Scale-invariant RMSE relative to the RMS of the truth; None if the truth is black."""

    scale: float
    """Factor that minimises the RMSE of the guess."""

    black: float
    """Fraction of pixels ignored by the angle, because truth or guess is black."""

    normalised_rmse: float | None = None
    """RMSE of images divided by their own 99.9 % percentile; only for "diffusionlight"."""

    def in_short(self) -> str:
        """RMSE, scale-invariant RMSE and angle."""
        angle = degrees(self.angle)
        return f"RMSE {self.rmse:.4g}, si-RMSE {self.si_rmse:.4g}, RGB angle {angle}"

    def _table(self) -> Table:
        return errors_table({"image": self})

    def to_dict(self) -> dict[str, float | None]:
        """All fields as plain numbers."""
        return fields_of(self)


def errors_table(errors: Mapping[str, ImageErrors]) -> Table:
    """Table with a row per image or sphere."""
    has_normalised = any(each.normalised_rmse is not None for each in errors.values())
    columns = ["sphere", "RMSE", "si-RMSE", "RGB angle", "relative", "si-relative"]
    rows = [
        [
            name,
            f"{each.rmse:.4g}",
            f"{each.si_rmse:.4g}",
            degrees(each.angle),
            percent(each.relative),
            percent(each.si_relative),
            *([f"{each.normalised_rmse or 0:.4g}"] if has_normalised else []),
        ]
        for name, each in errors.items()
    ]
    return Table([*columns, *(["norm-RMSE"] if has_normalised else [])], rows)


class Products(NamedTuple):
    """Inner products of two images, averaged over pixels and channels."""

    truth: float
    """Mean square of the truth."""

    both: float
    """Mean product of truth and guess."""

    guess: float
    """Mean square of the guess."""

    difference: float
    """Mean square of the difference, computed directly to avoid cancellation."""

    def squares(self) -> tuple[float, float, float]:
        """Mean square of the difference, the same after the best scaling, and the scale."""
        if not self.guess > 0:
            return self.difference, self.truth, 1.0
        scale = self.both / self.guess
        # <T, T> - <T, G>^2 / <G, G>, expressed by D = G - T: |a G - T|^2 = |D|^2 - <D, G>^2 / <G,
        # G>.
        # The square of an inner product may overflow or underflow, so divide first.
        rest = self.guess - self.both
        along = rest * (rest / self.guess)
        return self.difference, max(self.difference - along, 0.0), scale


def errors_of_products(
    products: Products, angle: tuple[float | None, float], *, channels: str
) -> ImageErrors:
    """Errors from inner products, and an angle in degrees with its fraction of black pixels."""
    factor = 3.0 if channels == "sum" else 1.0
    square, best, scale = products.squares()
    is_lit = products.truth > 0
    return ImageErrors(
        float(np.sqrt(factor * square)),
        float(np.sqrt(factor * best)),
        angle[0],
        float(np.sqrt(square / products.truth)) if is_lit else None,
        float(np.sqrt(best / products.truth)) if is_lit else None,
        float(scale),
        angle[1],
    )


class PixelSums(NamedTuple):
    """Weighted sums over pixels, which can be added for blocks of an image."""

    weight: float
    """Sum of the weights."""

    products: NDArray[np.float64]
    """T T, T G, G G and (G - T)^2, as means over channels, (4,)."""

    seen: float
    """Total weight of the pixels that are black in neither image."""

    angle: float
    """Weighted sum of the angles of these pixels, in degrees."""

    def plus(self, other: PixelSums) -> PixelSums:
        """Sums over both blocks."""
        return PixelSums(
            self.weight + other.weight,
            self.products + other.products,
            self.seen + other.seen,
            self.angle + other.angle,
        )

    def errors(self, *, channels: str, black: str) -> ImageErrors:
        """Errors of the pixels."""
        products = Products(*(self.products / self.weight))
        return errors_of_products(products, self.mean_angle(black), channels=channels)

    def mean_angle(self, black: str) -> tuple[float | None, float]:
        """Mean angle in degrees, and the fraction of black pixels."""
        if not self.seen > 0:
            return None, 1.0
        whole = self.weight if black == "perfect" else self.seen
        return float(self.angle / whole), float(1 - self.seen / self.weight)


def pixel_sums(
    truth: NDArray[np.float64],
    guess: NDArray[np.float64],
    weights: NDArray[np.float64] | None = None,
) -> PixelSums:
    """Sums over pixels, (n, 3), with equal or other `weights`, (n,)."""
    # Put channels first: sums over the last axis of (n, 3) take ten times as long.
    one, other = np.ascontiguousarray(truth.T), np.ascontiguousarray(guess.T)
    fraction = np.ones(len(truth)) if weights is None else weights
    difference = other - one
    pairs = (one, one), (one, other), (other, other), (difference, difference)
    products = np.array([(a * b @ fraction).sum() / 3 for a, b in pairs])
    # Scale each vector, so that products neither overflow nor underflow.
    largest = [np.maximum.reduce(np.abs(each)) for each in (one, other)]
    is_seen = (largest[0] > 0) & (largest[1] > 0)
    units = [
        each / np.where(is_seen, most, 1) for each, most in zip((one, other), largest, strict=True)
    ]
    angles = degrees_between(units[0].T, units[1].T)
    seen = fraction * is_seen
    every = np.ones(len(truth))
    return PixelSums(float(fraction @ every), products, float(seen @ every), float(seen @ angles))


def image_errors(
    truth: ArrayLike, guess: ArrayLike, mask: ArrayLike | None = None, *, channels: str = "mean"
) -> ImageErrors:
    r"""Errors of an image that was rendered or photographed elsewhere.

    Parameters
    ----------
    truth, guess : array_like, shape (height, width, 3) or (n, 3)
        Images of one shape; finite. Linear or encoded: the errors are those of the numbers.
    mask : array_like, shape (height, width) or (n,), optional
        Pixels that count are True or above 0.
    channels : {"mean", "sum"}
        "mean": mean over pixels and channels. "sum": mean over pixels of the sum over channels, as
        in the code of StyleLight: RMSE and si-RMSE are :math:`\sqrt 3` times as large.

    Returns
    -------
    ImageErrors

    Raises
    ------
    EnvLightsError
        If the shapes differ, a pixel is not finite, or the mask leaves none.

    Notes
    -----
    With the truth T, the guess G and :math:`a = \langle T, G \rangle / \langle G, G \rangle`,
    the scale-invariant RMSE is that of :math:`a G`. The angle of a pixel is
    :math:`\mathrm{atan2}(|G \times T|, G \cdot T)`; pixels that are black in one image are left
    out, and `ImageErrors.black` has their fraction.

    Examples
    --------
    >>> import numpy as np
    >>> import envlights as el
    >>> grey = np.ones((2, 2, 3))
    >>> el.comparison.image_errors(grey, 2 * grey)
    <ImageErrors: RMSE 1, si-RMSE 0, RGB angle 0°>
    """
    check_choice("channels", channels, ("mean", "sum"))
    images = [_image(name, image) for name, image in (("truth", truth), ("guess", guess))]
    if images[0].shape != images[1].shape:
        raise EnvLightsError(
            f"truth and guess must have the same shape; got {images[0].shape} and {images[1].shape}"
        )
    counted = _mask(mask, images[0].shape[:-1])
    rows = [image[counted] if mask is not None else image.reshape(-1, 3) for image in images]
    return pixel_sums(rows[0], rows[1]).errors(channels=channels, black="left out")


def _image(name: str, image: ArrayLike) -> NDArray[np.float64]:
    array = reals(name, image, None)
    if array.ndim not in (2, 3) or array.shape[-1] != 3 or not array.size:
        raise EnvLightsError(
            f"{name} must have the shape (height, width, 3) or (n, 3); got {array.shape}"
        )
    if (bad := first_not_finite(np.atleast_3d(array))) is not None:
        raise EnvLightsError(f"{name} must be finite; row {bad[0]} holds {bad[2]}")
    if np.abs(array).max() > 1e100:
        raise EnvLightsError(f"{name} must be below 1e100, so that its squares are finite")
    return array


def _mask(mask: ArrayLike | None, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    if mask is None:
        return np.ones(shape, bool)
    try:
        values = np.asarray(mask)
        counted = np.asarray(values > 0)
    except (ValueError, TypeError):
        raise EnvLightsError(f"mask must be an array of numbers; got {describe(mask)}") from None
    if values.dtype.kind not in "biuf" or counted.shape != shape:
        raise EnvLightsError(f"mask must be numbers of the shape {shape}; got {values.shape}")
    if not counted.any():
        raise EnvLightsError("mask must leave a pixel; it leaves none")
    return counted
