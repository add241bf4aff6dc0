"""Single light: a row of `Lights`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from envlights._common.former import former_attributes
from envlights._common.result import Result
from envlights._common.words import percent
from envlights.kernels.angles import POLES, angle_cells, azimuths, elevations
from envlights.kernels.image import LUMINANCE


@former_attributes(share="fraction")
@dataclass(frozen=True, eq=False, repr=False)
class Light(Result):
    """Single light, the type of ``lights[0]``.

    Examples
    --------
    >>> import envlights as el
    >>> lights = el.Lights([[0, 1, 0], [1, 0, 0]], [[1, 1, 1], [3, 3, 3]])
    >>> lights[0]
    <Light: azimuth 90.0°, elevation +0.0°, 75 %>
    >>> [round(light.fraction, 2) for light in lights]
    [0.75, 0.25]
    """

    _is_headed = True

    direction: NDArray[np.float64]
    """Unit vector from the scene to the light, (3,)."""

    irradiance: NDArray[np.float64]
    """Linear RGB at normal incidence, (3,)."""

    angular_radius: float
    """Angular radius in radians; 0 is a point."""

    fraction: float
    """Fraction of the total luminance; see `Lights.fraction`."""

    @property
    def azimuth(self) -> float:
        """Azimuth in radians; see `Lights.azimuth`."""
        return float(azimuths(self.direction[None])[0])

    @property
    def elevation(self) -> float:
        """Elevation in radians; see `Lights.elevation`."""
        return float(elevations(self.direction[None])[0])

    @property
    def luminance(self) -> float:
        """Luminance of the irradiance."""
        return float(self.irradiance @ LUMINANCE)

    def in_short(self) -> str:
        """Azimuth, elevation and flux fraction."""
        azimuth, elevation = angle_cells(self.direction)
        place = f"azimuth {azimuth}, elevation {elevation}"
        if azimuth in POLES:
            place = f"at the {azimuth}"
        return f"{place}, {percent(self.fraction)}"

    def _lines(self) -> list[str]:
        red, green, blue = self.irradiance
        size = (
            f"radius {np.rad2deg(self.angular_radius):.2f}°" if self.angular_radius else "a point"
        )
        return [f"{size}; irradiance {red:.4g}, {green:.4g}, {blue:.4g}"]


@dataclass(frozen=True, eq=False, repr=False)
class DetectedLight(Light):
    """Single detected light, with its measurements; see `DetectedLights`."""

    peak_direction: NDArray[np.float64]
    solid_angle: float
    elongation: float
    orientation: NDArray[np.float64]
    peak_luminance: float
    flux_fraction: float
    flux: NDArray[np.float64]
    is_clipped: bool
    is_broad: bool
    weight: float | None = None
    direction_uncertainty: float | None = None
    is_cut: bool = False

    def _lines(self) -> list[str]:
        return ["; ".join([*super()._lines(), *remarks_of(self)])]


def remarks_of(light: DetectedLight) -> list[str]:
    """Remarks on a light for a table: clipped, cut off by the border, wide, direction uncertain."""
    remarks = ["clipped"] if light.is_clipped else []
    remarks += ["cut off"] if light.is_cut else []
    remarks += ["wide"] if light.is_broad else []
    if light.direction_uncertainty is not None:
        remarks.append(f"direction ± {np.rad2deg(light.direction_uncertainty):.2f}°")
    return remarks
