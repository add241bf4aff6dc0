"""Exposures of a panorama, merged into one linear image (Madsen et al. 2003, figure 4).

The response is known: sRGB. So the radiance of a sample z of an exposure of t seconds is z / t, and
what is uncertain about it is the step between two codes, dz. The mean over all exposures with the
weights (t / dz)^2 has the least variance. A sample at white counts for nothing, unless it is at
white in all exposures.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native
from envlights._check import amount
from envlights._native import EnvLightsError
from envlights._srgb import decode_codes
from envlights.io.images import read_image
from envlights.io.openimageio import oiio
from envlights.kernels.sphere import pixel_solid_angles

#: Only samples in this range are used to compare exposures.
_LEAST_COMPARED, _MOST_COMPARED = 0.02, 0.9
#: Ratio above which exposures contradict each other.
_CONTRADICTION = 1.3
#: Ratio of measured to stated times above which a note doubts them.
_DOUBT = 1.1
#: Smallest number of pixels, well exposed in both pictures, that a check of times needs.
_FEWEST = 16
#: Report motion only above this fraction of the sphere.
_LEAST_SHARE = 1e-3

#: Rows of a block; the arrays for a block take more memory than its pixels.
_ROWS = 64


class Exposures:
    """Exposures of one scene as linear images that clip at 1, shortest first."""

    def __init__(
        self, pictures: Sequence[ArrayLike | str | os.PathLike[str]], times: Sequence[float] | None
    ) -> None:
        if isinstance(pictures, str | os.PathLike) or len(pictures) < 2:
            raise EnvLightsError("exposures must be two pictures or more; for one, use `EnvMap`")
        if times is None:
            times = [_exposure_time(picture) for picture in pictures]
        if len(times) != len(pictures):
            raise EnvLightsError(
                f"there must be a time for each exposure ({len(pictures)}); got {len(times)}"
            )
        seconds = np.array([_checked_time(number, time) for number, time in enumerate(times, 1)])
        order = np.argsort(seconds, kind="stable")
        self.times: NDArray[np.float64] = seconds[order]
        self.numbers = [int(place) + 1 for place in order]
        self.border_sampled = False
        self.notes: list[str] = []
        self.images = [self._read(pictures[place], int(place) + 1) for place in order]
        sizes = [image.shape for image in self.images]
        for number, size in zip(self.numbers, sizes, strict=True):
            if size != sizes[0]:
                raise EnvLightsError(
                    f"exposures must have one size; exposure {self.numbers[0]} has the shape"
                    f" {sizes[0]}, exposure {number} {size}"
                )

    def _read(self, picture: ArrayLike | str | os.PathLike[str], number: int) -> NDArray[Any]:
        if isinstance(picture, str | os.PathLike):
            image = read_image(picture)
            self.border_sampled |= image.border_sampled
            self.notes += [note for note in image.notes if note not in self.notes]
            return image.pixels
        array = np.asarray(picture)
        if array.ndim != 3 or array.shape[2] != 3:
            raise EnvLightsError(
                f"exposure {number} must have the shape (height, width, 3); got {array.shape}"
            )
        if array.dtype.kind == "u" and array.dtype.itemsize <= 2:
            return decode_codes(array)
        if array.dtype.kind != "f":
            raise EnvLightsError(
                f"exposure {number} must be floating point, uint8 or uint16; got {array.dtype}"
            )
        if not np.isfinite(array).all():
            raise EnvLightsError(f"exposure {number} holds samples that are not finite")
        return array.astype(np.float32, copy=False)

    def merged(self) -> tuple[NDArray[np.float32], float | None]:
        """Radiance for an exposure of 1 s, and its clip level if the shortest one is clipped."""
        merged = np.empty_like(self.images[0])
        is_moved = np.zeros(merged.shape[:2], bool)
        is_lost = False
        for top in range(0, len(merged), _ROWS):
            rows = slice(top, top + _ROWS)
            samples = np.stack([image[rows] for image in self.images])
            merged[rows], is_moved[rows] = _merge(samples, self.times)
            is_lost |= bool((samples[0] >= _native.LEAST_WHITE).any())
        self._note_wrong_times()
        self._note_ghosts(is_moved)
        return merged, float(1 / self.times[0]) if is_lost else None

    def _note_wrong_times(self) -> None:
        """Note neighbouring exposures whose ratio differs from that of their times."""
        pairs = zip(range(len(self.times) - 1), range(1, len(self.times)), strict=True)
        for short, long in pairs:
            stated = self.times[long] / self.times[short]
            one, other = (self.images[place][..., 1] for place in (short, long))
            both = _is_compared(one) & _is_compared(other)
            numbers = f"exposures {self.numbers[short]} and {self.numbers[long]}"
            if both.sum() < _FEWEST:
                self.notes.append(f"{numbers} have too few pixels in common to check their times")
                continue
            measured = float(np.median(other[both] / one[both]))
            if max(measured / stated, stated / measured) > _DOUBT:
                self.notes.append(
                    f"{numbers} differ by a factor of {measured:.3g}, their times by {stated:.3g}:"
                    " is a time wrong, or the response not sRGB?"
                )

    def _note_ghosts(self, is_moved: NDArray[np.bool_]) -> None:
        solid_angles = pixel_solid_angles(*is_moved.shape)
        share = float(solid_angles[is_moved].sum() / solid_angles.sum())
        if share > _LEAST_SHARE:
            self.notes.append(
                f"exposures contradict each other on {100 * share:.2g} % of the sphere, where"
                " something may have moved; only the best exposure was used there"
            )


def _merge(
    samples: NDArray[np.float32], times: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Merge some rows of all exposures, and mark pixels where they contradict each other."""
    seconds = times[:, None, None, None]
    radiance = samples / seconds
    # Weigh each sample; where all are clipped, use the shortest exposure.
    weight = (seconds / _code_step(samples)) ** 2
    weight[samples >= _native.LEAST_WHITE] = 0
    lost = (weight == 0).all(axis=0)
    weight[0][lost] = 1
    # Use only the best exposure where another contradicts it.
    best = np.argmax(weight, axis=0)[None]
    alone = np.take_along_axis(radiance, best, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = radiance / alone
        differs = np.maximum(ratio, 1 / ratio) > _CONTRADICTION
    is_good = _is_compared(samples) & _is_compared(np.take_along_axis(samples, best, axis=0))
    is_moved: NDArray[np.bool_] = np.asarray((differs & is_good).any(axis=(0, 3)))
    mean = (weight * radiance).sum(axis=0) / weight.sum(axis=0)
    return np.where(is_moved[..., None], alone[0], mean), is_moved


def _is_compared(samples: NDArray[np.float32]) -> NDArray[np.bool_]:
    return (samples > _LEAST_COMPARED) & (samples < _MOST_COMPARED)


def _code_step(linear: NDArray[np.float32]) -> NDArray[np.float64]:
    """Derivative of the linear value by its sRGB code."""
    power = np.maximum(linear, 0.0031308).astype(np.float64) ** (1 - 1 / 2.4)
    return np.where(linear <= 0.0031308, 1 / 12.92, 2.4 / 1.055 * power)


def _checked_time(number: int, time: object) -> float:
    seconds = amount(f"the time of exposure {number}", time)
    if seconds == 0:
        raise EnvLightsError(f"the time of exposure {number} must be above 0; got 0")
    return seconds


def _exposure_time(picture: object) -> float:
    """Exposure of a file from its EXIF: time, corrected for aperture and sensitivity."""
    if not isinstance(picture, str | os.PathLike):
        raise EnvLightsError("arrays hold no exposure times; give times")
    name = os.fspath(picture)
    file = oiio.ImageInput.open(name)
    if file is None:
        oiio.geterror()
        read_image(picture)  # refuses it with its reason
        raise EnvLightsError(f"cannot read {name} as an image")
    spec = file.spec()
    file.close()
    time = spec.get_float_attribute("ExposureTime", 0.0)
    if not time > 0:
        raise EnvLightsError(f"{name} holds no exposure time in its EXIF; give times")
    # Correct the time for aperture and sensitivity.
    aperture = spec.get_float_attribute("FNumber", 0.0)
    speed = max(
        float(spec.get_int_attribute(tag, 0))
        for tag in ("Exif:PhotographicSensitivity", "Exif:ISOSpeedRatings")
    )
    return float(time * (speed or 100.0) / 100.0 / (aperture or 1.0) ** 2)
