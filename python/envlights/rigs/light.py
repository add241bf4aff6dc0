"""Single light: a row of `Lights`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from envlights._common.former import former_attributes
from envlights._common.result import Result
from envlights.kernels import sphere
from envlights.kernels.image import LUMINANCE

#: Directions without an azimuth, at elevations that are printed as 90 and -90 degrees.
POLES = ("zenith", "nadir")


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
    """Unit vector from the scene towards the light, (3,)."""

    irradiance: NDArray[np.float64]
    """Linear RGB at normal incidence, (3,)."""

    angular_radius: float
    """Angular radius in radians; 0 is a point."""

    fraction: float
    """Fraction of the light; see `Lights.fraction`."""

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
        """Azimuth, elevation and share."""
        azimuth, elevation = angle_cells(self.direction)
        place = f"azimuth {azimuth}, elevation {elevation}"
        if azimuth in POLES:
            place = f"at the {azimuth}"
        return f"{place}, {100 * self.fraction:.3g} %"

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
    """Remarks on a light for texts: clipped, cut off by the border, wide, direction uncertain."""
    remarks = ["clipped"] if light.is_clipped else []
    remarks += ["cut off"] if light.is_cut else []
    remarks += ["wide"] if light.is_broad else []
    if light.direction_uncertainty is not None:
        remarks.append(f"direction ± {np.rad2deg(light.direction_uncertainty):.2f}°")
    return remarks


def place_of(direction: NDArray[np.float64]) -> str:
    """Azimuth and elevation of a direction, in words."""
    (azimuth,), (elevation,) = azimuths(direction[None]), elevations(direction[None])
    if round(abs(np.rad2deg(elevation))) == 90:
        return f"the {POLES[int(elevation < 0)]}"
    return f"azimuth {np.rad2deg(azimuth):.0f}°, elevation {np.rad2deg(elevation):.0f}°"


def angle_cells(direction: NDArray[np.float64]) -> tuple[str, str]:
    """Azimuth and elevation in degrees; at a pole its name in place of the azimuth."""
    (azimuth,), (elevation,) = azimuths(direction[None]), elevations(direction[None])
    height = f"{np.rad2deg(elevation):+.1f}°"
    if height in ("+90.0°", "-90.0°"):
        return POLES[int(height[0] == "-")], height
    return f"{np.rad2deg(azimuth):.1f}°", height


def azimuths(direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Radians from -z over +x, in the order of map columns, from 0 to 2 pi, (n,)."""
    radians: NDArray[np.float64] = 2 * np.pi * sphere.direction_to_uv(direction)[:, 0]
    return radians


def elevations(direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Radians above the horizon, from -pi / 2 to pi / 2, (n,)."""
    radians: NDArray[np.float64] = np.pi * (0.5 - sphere.direction_to_uv(direction)[:, 1])
    return radians
