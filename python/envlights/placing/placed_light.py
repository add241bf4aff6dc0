"""Single light with a position."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from envlights._common.result import Result
from envlights.cards import geometry
from envlights.cards.arrays import uniform_radiance
from envlights.placing.reading import Reals


@dataclass(frozen=True, eq=False, repr=False)
class PlacedLight(Result):
    """Light of a room, in metres from the camera and in the frame of `EnvMap`."""

    kind: str
    """"sphere": shines evenly into all directions; "plane": shines from one side, by the cosine;
    "sun": at infinity, without a position."""

    shape: str
    """Shape of its card, such as "rectangle"; a plane is an ellipse unless that has corners."""

    matrix: Reals
    """Columns U, V, O of the points O + a U + b V, (3, 3); of a sphere, its facing square.

    U goes to the right and V down, as in `Cards`. Of a sun, the centre is at distance 1."""

    irradiance: Reals
    """Linear RGB of a surface at the camera that faces the light, (3,)."""

    angular_radius: float
    """Radius as a disc from the camera, in radians."""

    texture: NDArray[np.float32]
    """Linear radiance, (rows, columns, 3); see `Cards`."""

    uncertainty: float = 0.0
    """Relative deviation of the depth from the sphere or plane; of two maps, the residual angle."""

    @property
    def is_disc(self) -> bool:
        """True for a plane that is an ellipse."""
        return self.shape not in ("rectangle", "tube")

    @property
    def direction(self) -> Reals:
        """Unit vector from the camera to the centre, (3,)."""
        return geometry.unit(self.matrix @ [0.5, 0.5, 1])

    @property
    def distance(self) -> float:
        """Metres from the camera to the centre; infinite for a sun."""
        is_far = self.kind == "sun"
        return np.inf if is_far else float(np.linalg.norm(self.matrix @ [0.5, 0.5, 1]))

    @property
    def position(self) -> Reals:
        """Centre in metres, (3,); infinite for a sun."""
        return self.direction * self.distance

    @property
    def normal(self) -> Reals:
        """Unit normal of the side that shines, (3,); of a sphere, towards the camera."""
        return geometry.normals(self.matrix[None])[0]

    @property
    def up(self) -> Reals:
        """Unit vector up in the plane of the light, (3,)."""
        return -geometry.unit(self.matrix[:, 1])

    @property
    def size(self) -> tuple[float, float]:
        """Width and height in metres; of a sphere, its diameter twice."""
        if self.kind == "sphere":
            return 2 * self.radius, 2 * self.radius
        width, height = np.linalg.norm(self.matrix[:, :2], axis=0)
        return float(width), float(height)

    @property
    def radius(self) -> float:
        """Radius of a sphere in metres; of others, that of a sphere of their size."""
        return float(self.distance * np.sin(self.angular_radius))

    @property
    def radiance(self) -> Reals:
        """Uniform radiance, linear RGB, (3,)."""
        if self.kind == "plane":
            shape = ("disc" if self.is_disc else "rectangle",)
            return uniform_radiance(self.matrix[None], shape, self.irradiance[None])[0]
        square = np.sin(self.angular_radius) ** 2
        radiance: Reals = self.irradiance / (np.pi * max(square, 1e-12))
        return radiance

    @property
    def intensity(self) -> Reals:
        """Radiant intensity along the normal in W / sr, or candela for a map in cd/m2, (3,)."""
        if self.kind == "sphere":
            return self.irradiance * self.distance**2
        width, height = self.size
        area = width * height * (np.pi / 4 if self.is_disc else 1)
        return self.radiance * area

    def in_short(self) -> str:
        """Kind, distance and size."""
        if self.kind == "sun":
            return "sun at infinity"
        width, height = self.size
        size = f"{width:.2f} m" if self.kind == "sphere" else f"{width:.2f} m x {height:.2f} m"
        return f"{self.kind}, {size}, at {self.distance:.2f} m"
