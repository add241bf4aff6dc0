"""Arrays of maps and photographs as linear images: the steps of a file, for samples in memory."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import for_kernels
from envlights._common.srgb import decode_codes
from envlights._native import EnvLightsError
from envlights.environment.clip_level import clip_level_of_codes
from envlights.environment.colour.alpha import fraction_of_alpha
from envlights.environment.coverage import checked_coverage, multiply_by_coverage
from envlights.environment.files.hints import NO_HINTS
from envlights.environment.files.images import Image
from envlights.environment.files.whole_numbers import WholeNumbers
from envlights.environment.picture_files import faces_of_mapping


class _Samples(NamedTuple):
    """Samples of an image as given, with three channels."""

    samples: NDArray[Any]
    """Red, green and blue, (height, width, 3) or (6, n, n, 3)."""

    coverage: NDArray[np.float32] | None
    """Coverage of each pixel by alpha and mask, 0 to 1, (height, width); None if complete."""


def image_of_array(
    array: ArrayLike | Mapping[str, ArrayLike],
    coverage: ArrayLike | None = None,
    *,
    known_level: float | None = None,
    what: str = "a map",
) -> Image:
    """Linear image of an array, or of six arrays by the names of their faces.

    Parameters
    ----------
    array : array_like, or mapping from names to array_like
    coverage : array_like, optional
        Fraction of each pixel that is seen, beside that of alpha and mask.
    known_level : float, optional
        Clip level; when left out, the histogram of codes has one.
    what : str
        Name of the array, for refusals.
    """
    hints, notes = NO_HINTS, list[str]()
    if isinstance(array, Mapping):
        array, order = faces_of_mapping(array)
        hints = hints._replace(order=order)
    samples, seen = _samples_of(array, notes, what)
    samples = _codes_of_floats(samples, notes)
    clip_level = known_level
    if clip_level is None and samples.dtype.kind != "f":
        clip_level = clip_level_of_codes(samples, seen, notes)
    linear = _linear(samples, notes)
    if seen is not None:
        linear = multiply_by_coverage(linear, seen)
    if coverage is not None:
        given = checked_coverage(coverage, samples.shape[:-1])
        if given is not None:
            seen = given if seen is None else seen * given
    return Image(linear, False, tuple(notes), clip_level, seen, hints)


#: Smallest number of different values in an array of 8-bit codes.
_VALUES = 32


def _codes_of_floats(samples: NDArray[Any], notes: list[str]) -> NDArray[Any]:
    """Samples as uint8 if floats hold 8-bit codes, scaled to 255 or 1; others unchanged."""
    if samples.dtype.kind != "f" or not samples.size:
        return samples
    # For nearly every map a few pixels rule this out; only the others are read completely.
    step = max(samples.shape[-2] // 64, 1)
    some = samples[..., ::step, ::step, :]
    for scale, name in ((1, "whole numbers from 0 to 255"), (255, "multiples of 1/255 up to 1")):
        if not (_are_codes(some, scale) and _are_codes(samples, scale)):
            continue
        values = np.unique(samples) * scale
        if len(values) >= _VALUES:
            notes.append(
                f"the samples are {name} in floats: decoded as 8-bit codes from sRGB; scaled by"
                " another factor they would be linear radiance"
            )
            return np.round(samples.astype(np.float64) * scale).astype(np.uint8)
    notes += WholeNumbers().add(samples).notes()
    return samples


def _are_codes(samples: NDArray[Any], scale: int) -> bool:
    """True if all samples times `scale` are whole numbers from 0 to 255, and some exceed 1."""
    scaled = samples.astype(np.float64) * scale
    tolerance = 0 if scale == 1 else 1e-4
    if not (scaled.min() >= 0 and 1 < scaled.max() <= 255 + tolerance):
        return False
    return bool((np.abs(scaled - np.round(scaled)) <= tolerance).all())


def _linear(samples: NDArray[Any], notes: list[str]) -> NDArray[np.float32]:
    """Linear samples; integers are decoded from sRGB, and `notes` says so."""
    if samples.dtype.kind == "f":
        # A float64 sample beyond float32 becomes infinite, and `clean` replaces it.
        with np.errstate(over="ignore"):
            return for_kernels(samples, np.float32)
    notes.append(f"{samples.dtype.name} samples were decoded from sRGB")
    return decode_codes(samples.reshape(-1, *samples.shape[-2:])).reshape(samples.shape)


def _samples_of(image: ArrayLike, notes: list[str], what: str) -> _Samples:
    """`image` as an array (height, width, 3); raises an error that says `what` is required.

    Grey arrays and arrays with alpha are converted like files; `notes` says so. Six squares stay an
    array (6, n, n, 3).
    """
    try:
        array = np.asarray(image)
    except ValueError as error:
        raise EnvLightsError(f"{what} must be an array of numbers; {error}") from None
    if array.dtype.kind == "O":
        raise EnvLightsError(f"{what} must be an array of numbers; got {type(image).__name__}")
    is_coded = array.dtype.kind == "u" and array.dtype.itemsize <= 2  # in either byte order
    if array.dtype.kind != "f" and not is_coded:
        raise EnvLightsError(
            f"{what} must be floating point, uint8 or uint16; got the dtype {array.dtype}"
        )
    samples, coverage = _rgb(array, notes, what)
    return _Samples(samples, _without_masked(image, coverage))


def _rgb(array: NDArray[Any], notes: list[str], what: str) -> _Samples:
    """Three channels, grey ones repeated, and straight alpha."""
    shape = array.shape
    is_grey_cube = array.ndim == 3 and array.shape[0] == 6 and array.shape[1] == array.shape[2] > 4
    if array.ndim == 2 or is_grey_cube:
        array = array[..., None]
    is_cube = array.ndim == 4 and array.shape[0] == 6
    channels = array.shape[-1] if array.ndim == 3 or is_cube else 0
    if channels == 3:
        return _Samples(array, None)
    if channels == 4:
        fraction = fraction_of_alpha(array[..., 3])
        return _Samples(array[..., :3], None if (fraction == 1).all() else fraction)
    if channels == 1:
        notes.append("the only channel was read as grey")
        return _Samples(np.repeat(array, 3, axis=-1), None)
    raise EnvLightsError(
        f"{what} must have the shape (height, width, 3), or (height, width) for grey; got {shape}"
    )


def _without_masked(
    radiance: ArrayLike, coverage: NDArray[np.float32] | None
) -> NDArray[np.float32] | None:
    """Coverage of each pixel, 0 where a channel of a masked array is masked."""
    # Importing `numpy.ma` would load a module that only masked arrays need.
    mask = np.asarray(isinstance(radiance, np.ndarray) and getattr(radiance, "mask", False))
    if not mask.any():
        return coverage
    hidden = mask if mask.ndim == 2 else mask.any(axis=-1)
    fraction = np.ones(hidden.shape, np.float32) if coverage is None else coverage
    return np.where(hidden, np.float32(0), fraction)
