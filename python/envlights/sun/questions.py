"""Eight questions that distinguish a sun from a lamp, window or cloud; each yes is a point."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights.sun.direction import SunPosition
from envlights.sun.parts import Part
from envlights.sun.sky_image import SkyImage

#: Smallest number of points for the answers "sun" and "perhaps".
SUN, PERHAPS = 7, 5

#: Smallest median of log(blue / red) of a blue sky.
_BLUE = 0.15
#: Smallest fraction of sky or clipped cells in the ring around the region, and ring width in
#: degrees.
_AROUND, _RING = 0.55, 10.0
#: Smallest fraction of the clipped solid angle above the horizon that lies in the region.
_ALONE = 0.5
#: Smallest log ratio of the residual of elevation bands to that of a sky with a sun.
_GAIN = 0.5
#: Largest correlation of log luminance and log(blue / red) on the ground.
_BLUE_SHADOWS = -0.05
#: Smallest ratio of depth to the radius of a disc with the same area.
_ROUND = 0.45
#: Largest deviation of log luminance from the fitted sky.
_SMOOTH = 0.12
#: Smallest elevation, smallest depth, and elevation below which air may dim a sun to 0.01 of its
#: irradiance (the air mass is above 2.4), in degrees.
_UP, _DEEP, _HIGH = 3.0, 1.0, 25.0
#: Range of elevations that count as ground, in degrees.
_GROUND = -60.0, -3.0

Array = NDArray[np.float64]


def points_of(image: SkyImage, part: Part | None, position: SunPosition) -> dict[str, bool]:
    """Questions with their answers; `part` is None for a spot in a smooth sky."""
    fit = position.fit
    is_up = bool(position.direction[1] > np.sin(np.radians(_UP)))
    answers = {
        "the sky is blue": _blueness(image, image.sky) > _BLUE,
        "there is sky all round": part is None or _around(image, part) > _AROUND,
        "it is the only one": part is None or _alone(image, part) > _ALONE,
        "the sky is brighter around it": fit is not None and fit.gain > _GAIN,
        "shadows are blue": _shadow_correlation(image) < _BLUE_SHADOWS,
        "it is round": part is None or float(part.depth.max()) > _ROUND * part.radius,
        "the sky is smooth": fit is not None and fit.deviation < _SMOOTH,
        "it is up": is_up and (part is None or float(part.depth.max()) > _DEEP),
    }
    return {question: bool(answer) for question, answer in answers.items()}


def veils_of(image: SkyImage, position: SunPosition) -> list[str]:
    """Reasons why the sun may be dimmed, which its clipped region does not show."""
    fit = position.fit
    is_smooth = fit is not None and fit.deviation < _SMOOTH
    is_low = position.direction[1] < np.sin(np.radians(_HIGH))
    return [
        *([] if _blueness(image, image.sky) > _BLUE else ["the sky is not blue"]),
        *([] if is_smooth else ["the sky is not smooth"]),
        *([f"the sun is below {_HIGH:g} degrees"] if is_low else []),
    ]


def _blueness(image: SkyImage, mask: NDArray[np.bool_]) -> float:
    """Median of log(blue / red); -1 if no cell is selected."""
    return float(np.median(_log_blue(image, mask))) if mask.any() else -1.0


def _log_blue(image: SkyImage, mask: NDArray[np.bool_]) -> Array:
    red, blue = np.maximum(image.radiance[mask][:, [0, 2]], 1e-3).T
    value: Array = np.log(blue / red)
    return value


def _around(image: SkyImage, part: Part) -> float:
    """Fraction of sky or clipped cells in the ring around the region."""
    centre = part.direction
    angle = np.degrees(np.arccos(np.clip(image.directions @ centre, -1, 1)))
    ring = (angle >= part.radius) & (angle < part.radius + _RING) & (image.elevation > 2)
    return float(np.mean((image.sky | image.is_touched)[ring])) if ring.any() else 0.0


def _alone(image: SkyImage, part: Part) -> float:
    """Fraction of the clipped solid angle above the horizon that lies in the region."""
    clipped = (image.solid_angles * image.core).sum()
    return float(part.solid_angle / max(clipped, 1e-9))


def _shadow_correlation(image: SkyImage) -> float:
    """Correlation of log luminance and log(blue / red) on the unclipped ground."""
    low, high = _GROUND
    ground = (image.elevation < high) & (image.elevation > low) & ~image.is_touched
    if np.count_nonzero(ground) < 20:
        return 0.0
    log, blue = image.log[ground], _log_blue(image, ground)
    if log.std() == 0 or blue.std() == 0:
        return 0.0
    return float(np.corrcoef(log, blue)[0, 1])
