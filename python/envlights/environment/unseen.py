"""Radiance for the part of the sphere that a map does not show."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native
from envlights._common.blocks import in_blocks
from envlights._common.check import amount, check_choice, colour
from envlights._native import EnvLightsError
from envlights.environment.coverage import share_of_sphere
from envlights.kernels.image import LUMINANCE
from envlights.kernels.probe import irradiance
from envlights.kernels.sphere import pixel_directions, pixel_solid_angles

#: Fills by name; a radiance is the other choice.
FILLS = ("black", "harmonic", "ground")
#: Name of a fill, a radiance, or None for the default.
Unseen = str | ArrayLike | None

#: Seen fraction of the sphere from which a fill is harmonic without a request. Without the part
#: below -60 degrees (0.93 seen) the probe of 8 real maps was off by at most 0.004. A hole of a
#: panorama's tripod may reach up to -45 degrees (0.854 seen).
ENOUGH_SEEN = 0.85
#: Columns in which a fill is solved, because it is smooth. With 1024, the probe of maps without
#: nadir differs by 3e-4, and the fill takes four times as long.
_COLUMNS = 256
#: Limit of the luminance that "ground" continues above the horizon, in medians of what is seen.
#: Without limit and ground, the worst probe error of 8 upper halves is 0.66 instead of 0.43.
_MOST_OVER_MEDIAN = 8.0
#: Pixels of an image that is sampled for the median.
_MEDIAN_COLUMNS = 512


class PartialMap(NamedTuple):
    """Radiance multiplied by the share of each pixel that is seen."""

    radiance: NDArray[np.float32]
    seen: NDArray[np.float32]
    border_sampled: bool

    @property
    def share(self) -> float:
        """Fraction of the sphere that is seen."""
        return share_of_sphere(self.seen, self.border_sampled)


def checked_unseen(unseen: Unseen) -> str | list[float] | None:
    """Name of a fill, its radiance as RGB, or None; refuse anything else."""
    if unseen is None:
        return None
    if isinstance(unseen, str):
        check_choice("unseen", unseen, FILLS)
        return unseen
    if np.ndim(unseen) == 0:
        return [amount("unseen", unseen)] * 3
    return colour("unseen", unseen)


def choice_of(unseen: Unseen, share: float) -> str | list[float]:
    """Checked fill of a map that shows this `share`; harmonic by default if that is enough."""
    choice = checked_unseen(unseen)
    if choice is not None:
        return choice
    if share >= ENOUGH_SEEN:
        return "harmonic"
    raise EnvLightsError(
        f"the map shows {100 * share:.2g} % of the sphere, so the brightest light may be outside;"
        " say what is there by unseen='black', 'harmonic', 'ground' or a radiance (a number or"
        " RGB). `detect` needs no choice"
    )


def fill(part: PartialMap, choice: str | list[float], albedo: float) -> NDArray[np.float32]:
    """Radiance of all pixels of a map after a fill."""
    if not isinstance(choice, str):
        return _with_radiance(part, np.array(choice), slice(None))
    if choice == "black":
        return part.radiance
    if choice == "harmonic":
        return _harmonic(part, np.inf)
    return _with_ground(part, albedo)


def note_of_fill(choice: str | list[float], share: float, albedo: float) -> str:
    """Note on a fill of a map that shows this `share` of the sphere."""
    words = {
        "black": "counts as black",
        "harmonic": "was filled from its border by Laplace's equation",
        "ground": "was filled from its border above the horizon, and with ground of the albedo"
        f" {albedo:g} below it",
    }
    if isinstance(choice, str):
        done = words[choice]
    else:
        done = f"has the radiance {', '.join(f'{value:g}' for value in choice)}"
    return f"the {100 * (1 - share):.2g} % of the sphere that is not seen {done}"


def _harmonic(part: PartialMap, most: float) -> NDArray[np.float32]:
    """Harmonic fill that continues radiance up to the luminance `most`."""
    return _native.fill_unseen(part.radiance, part.seen, part.border_sampled, _COLUMNS, most)


def _with_ground(part: PartialMap, albedo: float) -> NDArray[np.float32]:
    """Harmonic fill with dimmed lights above the horizon, and ground that reflects it below."""
    sky = _harmonic(part, _MOST_OVER_MEDIAN * _median_luminance(part))
    received = irradiance(sky, [[0.0, 1.0, 0.0]], border_sampled=part.border_sampled)[0]
    below = _first_row_below(part)
    ground = _with_radiance(part, albedo / np.pi * received, slice(below, None))
    sky[below:] = ground
    return sky


def _with_radiance(
    part: PartialMap, radiance: NDArray[np.float64], rows: slice
) -> NDArray[np.float32]:
    """Rows whose unseen part has one radiance."""
    seen, known, rgb = part.seen[rows], part.radiance[rows], radiance.astype(np.float32)
    return in_blocks(
        known.shape, lambda at: known[at] + (np.float32(1) - seen[at][..., None]) * rgb
    )


def _first_row_below(part: PartialMap) -> int:
    """First row whose pixels have their centres below the horizon."""
    towards = pixel_directions(len(part.seen), 2, border_sampled=part.border_sampled)
    return int(np.count_nonzero(towards[:, 0, 1] >= 0))


def share_above_horizon(part: PartialMap) -> float:
    """Fraction of the upper half of the sphere that is seen."""
    below = _first_row_below(part)
    height, width = part.seen.shape
    weights = pixel_solid_angles(height, width, border_sampled=part.border_sampled)[:below]
    return float((part.seen[:below] * weights).sum() / weights.sum())


def _median_luminance(part: PartialMap) -> float:
    """Median luminance of what is seen by solid angle, from a regular sample of pixels."""
    step = max(part.seen.shape[1] // _MEDIAN_COLUMNS, 1)
    at = (slice(None, None, step), slice(None, None, step))
    share = part.seen[at].astype(np.float64)
    weights = share * pixel_solid_angles(*part.seen.shape, border_sampled=part.border_sampled)[at]
    is_seen = share > 0
    luminance = (part.radiance[at][is_seen] @ LUMINANCE) / share[is_seen]
    order = np.argsort(luminance)
    below = np.cumsum(weights[is_seen][order])
    return float(luminance[order][np.searchsorted(below, 0.5 * below[-1])]) if len(below) else 0.0
