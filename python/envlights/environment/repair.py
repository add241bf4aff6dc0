"""Repair of a clipped map: estimate of the clipped flux, and its distribution.

The ground is the light meter of the scene. Under all light, with the clipped light, a ground of
albedo a has the radiance a / pi times its irradiance. So with the mean luminance L_ground of the
ground and the irradiance E_up of an upward surface under the clipped map,

    missing = min( 3 max(0, pi L_ground / 0.2 - E_up),  3 F_unclipped,  400 / sr x W_clipped )

is an estimate of the clipped flux. 0.2 is the albedo of usual ground, and 3 the ratio of flux to
irradiance for light from 20 degrees above the horizon. F and W are flux and solid angle. The
numbers were chosen on pictures of HDR maps; `benchmarks/clipped_repair.py` measures the result.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._common.check import amount
from envlights._native import EnvLightsError
from envlights.environment.clean import clean
from envlights.environment.fill import Fill
from envlights.environment.light import from_unseen as received_from_unseen
from envlights.environment.pixels import MapPixels
from envlights.kernels.image import LUMINANCE
from envlights.kernels.probe import irradiance as surface_irradiance
from envlights.kernels.sphere import pixel_solid_angles

#: Assumed albedo of the ground.
_ALBEDO = 0.2
#: Ratio of the missing flux to the missing irradiance of a horizontal surface.
_FLUX_PER_IRRADIANCE = 3.0
#: Largest ratio of the missing flux to the unclipped flux.
_MOST_OF_UNCLIPPED = 3.0
#: Largest luminance of the missing light, as a multiple of the clip level.
_MOST_LUMINANCE = 400.0

#: Sine of the elevation below which pixels count as ground.
_GROUND = -math.sin(math.radians(3.0))
#: Smallest visible fraction of the ground, and smallest unclipped fraction of that, for an
#: estimate.
_LEAST_GROUND = 0.1
#: Range of apparent albedos that a white floor could explain as well.
_WHITE_FLOOR = 0.7, 1.1

#: Columns of the image in which clipped regions are separated, and the largest gap that joins two
#: regions, in radians; equal to the defaults of `detect` for clipped maps.
PLATEAU_COLUMNS, PLATEAU_GAP = 512, math.radians(0.8)

#: Number of rows that are processed at once, to limit memory.
_ROWS = 128


class Repair(NamedTuple):
    """Radiance with an estimate of the clipped light."""

    radiance: NDArray[np.float32]
    note: str
    """Factor by which the flux was raised, or the reason why it was not raised."""
    is_open: bool
    """True if nothing was added, so that clipped light may still be missing."""


def with_estimate(
    pixels: MapPixels, irradiance: float | None, ratio: float | None, fill: Fill
) -> MapPixels:
    """Pixels with an estimate of the clipped light; see `EnvMap.repaired`."""
    received, assumed = received_from_unseen(pixels, fill)
    repaired = repair(pixels, irradiance, ratio, from_unseen=received)
    notes = [*pixels.notes, *assumed, repaired.note]
    radiance, level = clean(repaired.radiance, notes)
    if repaired.is_open and pixels.clip_level is not None:
        level = pixels.clip_level
    return pixels.changed(radiance, pixels.coverage, notes, clip_level=level)


def repair(
    pixels: MapPixels,
    irradiance: float | None,
    ratio: float | None,
    normal: NDArray[np.float64] | None = None,
    *,
    from_unseen: float = 0.0,
) -> Repair:
    """Add the light that was clipped: a measured amount, or an estimate.

    The amount is measured on a surface that faces a unit vector; upward when left out.
    `from_unseen` is the luminance of the irradiance of this surface from what is not seen.
    """
    radiance, border_sampled, coverage = pixels.radiance, pixels.is_border_sampled, pixels.coverage
    clip_level = pixels.found_clip_level
    if irradiance is not None and ratio is not None:
        raise EnvLightsError("give irradiance or ratio, not both")
    irradiance = None if irradiance is None else amount("irradiance", irradiance)
    ratio = None if ratio is None else amount("ratio", ratio)
    is_estimate = irradiance is None and ratio is None
    level = math.inf if clip_level is None else clip_level
    fraction = _native.clipped_light_shares(
        radiance, border_sampled, level, PLATEAU_COLUMNS, PLATEAU_GAP
    )
    if not fraction.any():
        return Repair(radiance, "nothing was added: no pixel is clipped", is_estimate)
    light = _measure(radiance, fraction, level, border_sampled, coverage)
    if normal is not None and not is_estimate:
        light = _as_seen_from(light, normal, radiance, fraction, level, border_sampled)
    light = light.with_upward(from_unseen)
    missing, source = light.estimate(level) if is_estimate else light.up_to(irradiance, ratio)
    if missing == 0:
        note = f"nothing was added for the clipped light: {source}"
        return Repair(radiance, note, is_estimate)
    factor = 1 + missing / light.flux
    note = f"the flux was raised by a factor of {factor:.3g} for the clipped light: {source}"
    return Repair(_raise_clipped(radiance, fraction, missing), note, False)


@dataclass(frozen=True)
class _Light:
    """Flux and irradiance of a clipped map, as luminance."""

    flux: float
    unclipped_flux: float
    upward: float
    """Irradiance of a horizontal surface."""
    upward_unclipped: float
    """Irradiance of a horizontal surface, without the clipped pixels."""
    upward_share: float
    """Irradiance of a horizontal surface per unit of flux in the clipped pixels."""
    clipped: float
    """Clipped solid angle, in steradians."""
    ground: float
    """Mean luminance of the unclipped ground."""
    unclipped_ground: float
    """Unclipped fraction of the visible ground."""
    seen_ground: float
    """Visible fraction of the ground."""

    def with_upward(self, irradiance: float) -> _Light:
        """Light with the irradiance of uncovered parts added."""
        upward, unclipped = self.upward + irradiance, self.upward_unclipped + irradiance
        return replace(self, upward=upward, upward_unclipped=unclipped)

    def estimate(self, clip_level: float) -> tuple[float, str]:
        """Estimate of the missing flux from the ground, with its source as text."""
        if self.seen_ground < _LEAST_GROUND:
            return 0.0, "the ground is not seen, so there is no estimate; give irradiance or ratio"
        if self.unclipped_ground < _LEAST_GROUND:
            return (
                0.0,
                "the ground itself is clipped, so there is no estimate; give irradiance or ratio",
            )
        albedo = math.pi * self.ground / self.upward if self.upward > 0 else math.inf
        least, most = _WHITE_FLOOR
        if least <= albedo <= most:
            return 0.0, (
                f"under the light in the map the ground has an albedo of {albedo:.2g}, like a white"
                " floor, so there is no estimate; give irradiance or ratio"
            )
        irradiance = math.pi * self.ground / _ALBEDO
        if irradiance <= self.upward:
            return 0.0, (
                "the light in the map explains the brightness of the ground; for dark ground or"
                " night, give irradiance or ratio"
            )
        missing = min(
            _FLUX_PER_IRRADIANCE * (irradiance - self.upward),
            _MOST_OF_UNCLIPPED * self.unclipped_flux,
            _MOST_LUMINANCE * clip_level * self.clipped,
        )
        low, high = _true_factors(1 + missing / self.flux)
        return missing, (
            "an estimate from the brightness of the ground (in two of three maps, the true factor"
            f" is between {low:.2g} and {high:.2g})"
        )

    def up_to(self, irradiance: float | None, ratio: float | None) -> tuple[float, str]:
        """Missing flux for a measured irradiance or ratio, with its source as text."""
        name, target, least = "irradiance", irradiance or 0.0, self.upward
        if ratio is not None:
            check_not_black("the clipped light", self.upward_unclipped)
            name, target, least = "ratio", ratio, self.upward / self.upward_unclipped
        if not target >= least:
            raise EnvLightsError(
                f"{name} must be at least that of the map, {least:.4g}; got {target:g}"
            )
        if self.upward_share == 0:
            raise EnvLightsError(
                "all clipped pixels lie below the horizon of the surface and cannot light it; leave"
                f" {name} out"
            )
        unit = self.upward_unclipped if ratio is not None else 1.0
        return (target - least) * unit / self.upward_share, f"by the {name} of {target:.4g}"


def check_not_black(left_out: str, irradiance: float) -> None:
    """Raise an error for a ratio to an irradiance of 0."""
    if irradiance <= 0:
        raise EnvLightsError(
            f"the map is black without {left_out}, so a ratio says nothing; give irradiance instead"
        )


def _true_factors(factor: float) -> tuple[float, float]:
    """Interval of the true factor in two of three maps, for a `factor` of 1 or more."""
    low, high = _TWO_THIRDS
    return max(1.0, low * factor), high * factor


#: Quantiles 1/6 and 5/6 of the ratio of true to estimated factor.
_TWO_THIRDS = 0.8, 2.3


def _measure(
    radiance: NDArray[np.float32],
    fraction: NDArray[np.float32],
    clip_level: float,
    border_sampled: bool,
    coverage: NDArray[np.float32] | None,
) -> _Light:
    """Measure flux, irradiance and solid angle of visible pixels, clipped and unclipped."""
    height, width, _ = radiance.shape
    solid_angles = pixel_solid_angles(height, width, border_sampled=border_sampled)
    # Compute cosines at row edges, and the mean cosine of each row above the horizon.
    edges = 1 - np.concatenate([[0.0], np.cumsum(solid_angles.sum(axis=1))]) / (2 * np.pi)
    above = np.maximum(edges, 0) ** 2
    cosine = (above[:-1] - above[1:]) / (2 * (edges[:-1] - edges[1:]))
    is_ground = 0.5 * (edges[:-1] + edges[1:]) < _GROUND
    sums = np.zeros(10)
    for top in range(0, height, _ROWS):
        rows = slice(top, top + _ROWS)
        weight, shares = solid_angles[rows], fraction[rows]
        seen_weight = weight if coverage is None else weight * coverage[rows]
        luminance = radiance[rows] @ LUMINANCE
        is_whole = (radiance[rows] < _native.LEAST_WHITE * clip_level).all(axis=2)
        flux_of = luminance * weight
        up = cosine[rows, None]
        ground = is_ground[rows, None] & np.ones_like(is_whole)
        sums += [
            flux_of.sum(),
            flux_of[is_whole].sum(),
            (flux_of * up).sum(),
            (flux_of * up)[is_whole].sum(),
            (shares * weight * up).sum(),
            weight[~is_whole].sum(),
            flux_of[ground & is_whole].sum(),
            seen_weight[ground & is_whole].sum(),
            seen_weight[ground].sum(),
            weight[ground].sum(),
        ]
    flux, whole, upward, upward_whole, upward_share, clipped, *of_ground = map(float, sums)
    ground_flux, whole_ground, seen_ground, all_ground = of_ground
    return _Light(
        flux=flux,
        unclipped_flux=whole,
        upward=upward,
        upward_unclipped=upward_whole,
        upward_share=upward_share,
        clipped=clipped,
        ground=ground_flux / (whole_ground or 1.0),
        unclipped_ground=whole_ground / (seen_ground or 1.0),
        seen_ground=seen_ground / all_ground,
    )


def _as_seen_from(
    light: _Light,
    normal: NDArray[np.float64],
    radiance: NDArray[np.float32],
    fraction: NDArray[np.float32],
    clip_level: float,
    border_sampled: bool,
) -> _Light:
    """Measurements for a surface with another normal than up."""
    is_whole = (radiance < _native.LEAST_WHITE * clip_level).all(axis=2, keepdims=True)

    def on_surface(image: NDArray[np.float32]) -> float:
        values = surface_irradiance(image, normal[None], border_sampled=border_sampled)
        return float(values[0] @ LUMINANCE)

    grey = np.repeat(np.asarray(fraction, np.float32)[..., None], 3, axis=2)
    return replace(
        light,
        upward=on_surface(radiance),
        upward_unclipped=on_surface(np.where(is_whole, radiance, np.float32(0))),
        upward_share=on_surface(grey),
    )


def _raise_clipped(
    radiance: NDArray[np.float32], fraction: NDArray[np.float32], missing: float
) -> NDArray[np.float32]:
    """Add the flux `missing` to the clipped pixels, keeping their colours."""
    raised = radiance.copy()
    for top in range(0, len(radiance), _ROWS):
        rows = raised[top : top + _ROWS]
        is_clipped = fraction[top : top + _ROWS] > 0
        pixels = rows[is_clipped]
        more = missing * fraction[top : top + _ROWS][is_clipped] / (pixels @ LUMINANCE)
        rows[is_clipped] = pixels * (1 + more[:, None])
    return raised
