"""Single light with a position."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from envlights._common.result import Result
from envlights.cards import geometry
from envlights.cards.arrays import uniform_radiance
from envlights.placing.planes import Reals


@dataclass(frozen=True, eq=False, repr=False)
class PlacedLight(Result):
    """Light of a room, in metres from the camera and in the frame of `EnvMap`."""

    kind: str
    """"sphere": shines evenly into all directions; "plane": shines from one side, by the cosine;
    "sun": at infinity, without a position."""

    is_disc: bool
    """True for an ellipse, False for a rectangle."""

    matrix: Reals
    """Columns U, V, O of the points O + a U + b V, (3, 3), as of `Cards`.

    Of a sphere, its facing square; of a sun, a card with its centre at distance 1."""

    irradiance: Reals
    """Linear RGB of a surface at the camera that faces the light, (3,)."""

    angular_radius: float
    """Radius as a disc from the camera, in radians."""

    texture: NDArray[np.float32]
    """Linear radiance, (rows, columns, 3); see `Cards`."""

    uncertainty: float = 0.0
    """Median relative deviation of the depth from the sphere or the plane.

    Of several maps, the largest angle in radians by which a ray misses the position. Of a lamp that
    hangs in a `room`, half of the relative range of distances that fit the walls nearly as well."""

    @property
    def direction(self) -> Reals:
        """Unit vector from the camera to the centre, (3,)."""
        return geometry.unit(self.matrix @ [0.5, 0.5, 1])

    @property
    def position(self) -> Reals:
        """Centre in metres, (3,); infinite for a sun."""
        return self.direction * self.distance

    @property
    def distance(self) -> float:
        """Metres from the camera to the centre; infinite for a sun."""
        is_far = self.kind == "sun"
        return np.inf if is_far else float(np.linalg.norm(self.matrix @ [0.5, 0.5, 1]))

    @property
    def normal(self) -> Reals:
        """Unit normal of the side that shines, (3,); of a sphere, towards the camera."""
        return geometry.one(geometry.normals(self.matrix[None]))

    @property
    def up(self) -> Reals:
        """Unit vector upwards in the plane of the light, (3,)."""
        return -geometry.unit(self.matrix[:, 1])

    @property
    def size(self) -> Reals:
        """Width and height in metres, (2,); of a sphere, its diameter twice."""
        if self.kind == "sphere":
            return np.full(2, 2 * self.radius)
        lengths: Reals = np.linalg.norm(self.matrix[:, :2], axis=0)
        return lengths

    @property
    def radius(self) -> float:
        """Radius in metres of a sphere of the angular radius."""
        return float(self.distance * np.sin(self.angular_radius))

    @property
    def radiance(self) -> Reals:
        """Uniform radiance, linear RGB, (3,)."""
        if self.kind == "plane":
            shape = ("disc" if self.is_disc else "rectangle",)
            return geometry.one(uniform_radiance(self.matrix[None], shape, self.irradiance[None]))
        radiance: Reals = self.irradiance / max(np.pi * np.sin(self.angular_radius) ** 2, 1e-12)
        return radiance

    @property
    def intensity(self) -> Reals:
        """Radiant intensity along the normal in W / sr, or candela for a map in cd/m2, (3,)."""
        if self.kind != "plane":
            return self.irradiance * self.distance**2
        area = float(self.size.prod()) * (np.pi / 4 if self.is_disc else 1)
        return self.radiance * area

    def seen_from(self, point: Reals) -> tuple[Reals, Reals, float]:
        """Direction, irradiance at normal incidence and angular radius at a point, as a disc.

        The irradiance is 0 behind a plane.
        """
        if self.kind == "sun":
            return self.direction, self.irradiance, self.angular_radius
        if self.kind == "sphere":
            to = self.position - point
            # In a sphere, the light is that of its surface, from the side of its centre.
            distance = max(float(np.linalg.norm(to)), self.radius)
            radius = float(np.arcsin(min(self.radius / distance, 1.0)))
            direction = geometry.unit(to) if to.any() else self.direction
            return direction, self.irradiance * (self.distance / distance) ** 2, radius
        matrix = self.around(point)
        vector = geometry.vector_irradiance(geometry.outline(matrix, self.is_disc))
        length = float(np.linalg.norm(vector))
        if np.linalg.det(matrix) <= 0 or not length:
            return self.direction, np.zeros(3), 0.0
        radius = float(np.arcsin(np.sqrt(min(length / np.pi, 1.0))))
        return vector / length, self.radiance * length, radius

    def around(self, point: Reals) -> Reals:
        """Matrix relative to a point, which the square of a sphere faces; that of a sun stays."""
        if self.kind == "sun":
            return self.matrix
        if self.kind == "sphere":
            direction, _, radius = self.seen_from(point)
            distance = float(np.linalg.norm(self.position - point))
            return geometry.square_towards(direction, radius) * distance
        return self.matrix - np.outer(point, [0, 0, 1])

    def quarters(self) -> list[PlacedLight]:
        """Four quarters of a rectangle, with their parts of the irradiance."""
        across, down, corner = self.matrix.T
        corners = [corner + a * across + b * down for a in (0, 0.5) for b in (0, 0.5)]
        matrices = np.array([np.stack([across / 2, down / 2, each], axis=1) for each in corners])
        units = uniform_radiance(matrices, ("rectangle",) * 4, np.ones((4, 3)))
        pairs = zip(matrices, self.radiance / units, strict=True)
        return [replace(self, matrix=matrix, irradiance=part) for matrix, part in pairs]

    def in_short(self) -> str:
        """Kind, size and distance."""
        if self.kind == "sun":
            return "sun at infinity"
        width, height = self.size
        size = f"{width:.2f} m" if self.kind == "sphere" else f"{width:.2f} m x {height:.2f} m"
        return f"{self.kind}, {size}, at {self.distance:.2f} m"
