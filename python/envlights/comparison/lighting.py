"""Lighting on one side of a comparison: a map, and discs stored separately from its pixels."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.files import as_path
from envlights.comparison import harmonics
from envlights.comparison.angles import degrees_between
from envlights.comparison.harmonics import Discs
from envlights.detection.detect import detect
from envlights.detection.lights_file import SUFFIXES, load_lights
from envlights.environment.envmap import EnvMap
from envlights.environment.reading import AnyMap, Reading, as_envmap
from envlights.kernels.image import LUMINANCE
from envlights.kernels.probe import irradiance, rig_irradiance
from envlights.rigs.lights import Lights
from envlights.rigs.rig import Rig

#: Accepted types of a lighting.
AnyLighting = AnyMap | Rig | Lights

#: Length relative to the flux below which irradiance vectors are single-precision rounding.
_LEAST_LENGTH = 1e-6

#: Number of map rows for the comparison of two rigs.
DEFAULT_ROWS = 128


@dataclass(frozen=True, eq=False)
class Lighting:
    """Radiance in cells, and the discs drawn into it.

    Harmonics and irradiance of the discs are exact; their pixels are for mirrors and angles.
    """

    radiance: NDArray[np.float32]
    """Radiance of all light, (height, 2 * height, 3)."""

    backdrop: NDArray[np.float32]
    """Radiance without the discs, of the same shape."""

    discs: Lights | None
    """Lights of a rig or of a set of lights."""

    env: EnvMap
    """Map of all light, with units and clip level."""

    given: Lights | None = None
    """Lights of a rig or of a set of lights, as given."""

    @cached_property
    def harmonics(self) -> NDArray[np.float64]:
        """Harmonic coefficients; see `comparison.harmonics`."""
        out = harmonics.of_map(harmonics.reduce_cells(self.backdrop, harmonics.MOST_ROWS))
        return out if self.discs is None else out + self.fine_discs.harmonics()

    @cached_property
    def fine_discs(self) -> Discs:
        """Discs of all light that matters beyond the degrees of `harmonics`."""
        if self.discs is None:
            return harmonics.bright_parts(self.backdrop)
        lights = self.discs
        return Discs(lights.direction, lights.irradiance, lights.angular_radius)

    def probe(self, normals: NDArray[np.float64]) -> NDArray[np.float64]:
        """Irradiance at unit normals, (n, 3)."""
        values = irradiance(self.backdrop, normals)
        if self.discs is not None and len(self.discs):
            values = values + rig_irradiance(normals, np.zeros(3), *self.fine_discs)
        return values

    @cached_property
    def lights(self) -> Lights:
        """Lights of a rig, or lights detected in the map."""
        return detect(self.env) if self.given is None else self.given

    @property
    def vector(self) -> NDArray[np.float64]:
        """Irradiance vector of the luminance, from harmonics of degree 1, (3,)."""
        (y, _), (z, x) = self.harmonics[:2, 1].reshape(2, 2, 3) @ LUMINANCE
        vector: NDArray[np.float64] = np.array([x, y, -z]) * np.sqrt(4 * np.pi / 3)
        return vector

    @property
    def rows(self) -> int:
        """Number of map rows."""
        return len(self.radiance)

    @classmethod
    def of_cells(cls, radiance: NDArray[np.float32]) -> Lighting:
        """Lighting without discs."""
        return cls(radiance, radiance, None, EnvMap(radiance))


@dataclass(frozen=True, eq=False)
class Pair:
    """Truth and guess with maps of the same size."""

    truth: Lighting
    guess: Lighting

    @property
    def sides(self) -> tuple[Lighting, Lighting]:
        """Truth, then guess."""
        return self.truth, self.guess

    @cached_property
    def by_degree(self) -> NDArray[np.float64]:
        """Inner products per degree, (4, degree): T T, T G, G G and (G - T)^2."""
        one, other = self.truth.harmonics, self.guess.harmonics
        difference = other - one
        pairs = [(one, one), (one, other), (other, other), (difference, difference)]
        coarse = np.stack([harmonics.products(*pair) for pair in pairs])
        return np.concatenate([coarse, self._fine()], axis=1)

    def _fine(self) -> NDArray[np.float64]:
        """Inner products per degree beyond `DEGREE`."""
        one, other = self.truth.fine_discs, self.guess.fine_discs
        pairs = [(one, one), (one, other), (other, other)]
        a, b, c = (harmonics.fine_products(*pair) for pair in pairs)
        return np.stack([a, b, c, np.maximum(a - 2 * b + c, 0)])

    def vector_angle(self) -> float | None:
        """Angle in degrees between the irradiance vectors; None if either is 0 up to rounding."""
        for side in self.sides:
            flux = float(side.harmonics[0, 0, :3] @ LUMINANCE) * np.sqrt(4 * np.pi)
            if not np.linalg.norm(side.vector) > _LEAST_LENGTH * flux:
                return None
        return float(degrees_between(self.truth.vector, self.guess.vector))


def open_lighting(what: Any, reading: Reading | None = None) -> EnvMap | Rig | Lights:
    """Map, rig or lights from an object, an array or a path; `reading` applies to maps."""
    if isinstance(what, Rig | Lights | EnvMap):
        return what
    if isinstance(what, str | os.PathLike) and as_path(what).suffix.lower() in SUFFIXES:
        return load_lights(what)
    return as_envmap(what, reading)


def rows_of(what: EnvMap | Rig | Lights) -> int | None:
    """Number of rows of a map; None for lights, which have no pixels."""
    return what.height if isinstance(what, EnvMap) else None


def lighting_of(what: EnvMap | Rig | Lights, rows: int) -> Lighting:
    """Lighting of a map, a rig or lights, with a map of `rows` rows."""
    if isinstance(what, EnvMap):
        return _of_map(what, rows)
    lights = what.lights if isinstance(what, Rig) else what
    drawn = what.to_map(rows)
    dark = Lights(np.zeros((0, 3)), np.zeros((0, 3)), units=drawn.units)
    if isinstance(what, Rig):
        backdrop = Rig(what.ambient, dark, error=0.0, floor=what.floor).to_map(rows).radiance
    else:
        backdrop = np.zeros_like(drawn.radiance)
    return Lighting(drawn.radiance, backdrop, lights.discs(), drawn, lights)


def _of_map(env: EnvMap, rows: int) -> Lighting:
    """Lighting of a map, with its uncovered part filled."""
    whole = env.filled()
    reduced = whole if whole.height == rows else whole.resized(2 * rows)
    cells = reduced.cells()
    return Lighting(cells, cells, None, reduced)
