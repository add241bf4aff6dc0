"""Single light card: a row of `Cards`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from envlights._common.result import Result
from envlights.cards import geometry
from envlights.kernels.angles import azimuths, elevations


@dataclass(frozen=True, eq=False, repr=False)
class Card(Result):
    """Single card, the type of ``cards[0]``; the fields are rows of `Cards`."""

    shape: str
    """One of "rectangle", "tube", "disc", "point", "other", "sphere"."""

    matrix: NDArray[np.float64]
    """Columns U, V, O, (3, 3)."""

    irradiance: NDArray[np.float64]
    """Linear RGB at normal incidence, (3,)."""

    radiance: NDArray[np.float64]
    """Uniform radiance, (3,)."""

    texture: NDArray[np.float32]
    """Linear radiance, (rows, columns, 3)."""

    overlap: float
    """Intersection over union of the light's pixels and the shape."""

    angular_radius: float
    """Angular radius of the light as a disc, in radians."""

    @property
    def corners(self) -> NDArray[np.float64]:
        """Unit directions of the corners, (4, 3); see `Cards.corners`."""
        return geometry.one(geometry.corners(self.matrix[None]))

    @property
    def direction(self) -> NDArray[np.float64]:
        """Unit direction of the centre, (3,)."""
        return geometry.one(geometry.unit(geometry.centres(self.matrix[None])))

    @property
    def size(self) -> NDArray[np.float64]:
        """Angles along U and V in radians, (2,)."""
        return geometry.one(geometry.sizes(self.matrix[None]))

    def in_short(self) -> str:
        """Shape, size and direction."""
        width, height = np.rad2deg(self.size)
        (azimuth,), (elevation,) = (
            np.rad2deg(of(self.direction[None])) for of in (azimuths, elevations)
        )
        place = f"azimuth {azimuth:.1f}°, elevation {elevation:+.1f}°"
        return f"{self.shape}, {width:.1f}° x {height:.1f}°, {place}"

    def __str__(self) -> str:
        red, green, blue = self.irradiance
        overlap = f"overlap {self.overlap:.2f}"
        return f"{self.in_short()}\n{overlap}; irradiance {red:.4g}, {green:.4g}, {blue:.4g}"
