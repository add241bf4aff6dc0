"""Evidence in the pixels of a picture: black corners, two discs, two equal halves."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights.environment.layouts.seams import log_luminance

#: Rows of the grid on which pictures are compared.
_ROWS = 128
#: Luminance of black corners relative to the mean of the disc; codes of JPEG pictures have noise.
_BLACK = 0.02
#: Fraction of the corners that is black, and of the disc that is brighter than the corners.
_MOST = 0.95
#: Smallest correlation of the log luminance of two halves that show one world.
_ALIKE = 0.9
#: Smallest standard deviation of the log luminance of halves that can be compared.
_CONTRAST = 1e-3


def has_black_corners(samples: NDArray[Any]) -> bool:
    """True if a square picture is black outside its largest circle and bright inside.

    Parameters
    ----------
    samples : ndarray, shape (n, n, channels)
    """
    luminance = np.exp(log_luminance(_every_nth(samples)))
    luminance -= luminance.min()
    height, width = luminance.shape
    y, x = (np.arange(side) * 2 / max(side - 1, 1) - 1 for side in (height, width))
    radius = np.hypot(x[None], y[:, None])
    corners, disc = luminance[radius > 1.04], luminance[radius < 0.96]
    if not corners.size or not disc.size:
        return False
    level = _BLACK * float(disc.mean())
    is_black = float((corners <= level).mean()) >= _MOST
    return is_black and float((disc > level).mean()) >= _MOST


def is_dual_fisheye(samples: NDArray[Any]) -> bool:
    """True if both halves of a 2:1 picture are bright discs in black squares."""
    half = samples.shape[1] // 2
    return has_black_corners(samples[:, :half]) and has_black_corners(samples[:, half:])


def has_equal_halves(samples: NDArray[Any]) -> bool:
    """True if the upper and the lower half of a picture show nearly the same."""
    logs = log_luminance(_every_nth(samples))
    half = len(logs) // 2
    upper, lower = logs[:half], logs[-half:]
    if half < 2 or min(upper.std(), lower.std()) < _CONTRAST:
        return False
    return float(np.corrcoef(upper.ravel(), lower.ravel())[0, 1]) > _ALIKE


def is_constant(samples: NDArray[Any]) -> bool:
    """True if each of the squares, (k, n, n, channels), has one luminance, up to JPEG noise."""
    return all(
        np.ptp(_every_nth(square).astype(np.float32), axis=(0, 1)).max() <= _tolerance(square)
        for square in samples
    )


def _tolerance(square: NDArray[Any]) -> float:
    """Largest difference of samples of an empty square: a step of 8 bits, or rounding."""
    if square.dtype.kind == "u":
        return 4 * float(np.iinfo(square.dtype).max) / 255
    return max(0.02 * float(np.abs(square).max(initial=0)), 2e-3)


def _every_nth(samples: NDArray[Any]) -> NDArray[Any]:
    """Every n-th sample."""
    step = max(min(samples.shape[:2]) // _ROWS, 1)
    return samples[::step, ::step]
