"""Solids that cast shadows (balls, boxes, convex polyhedra), and the points that receive light.

The frame is that of `EnvMap`: right-handed, +y up. A floor is the plane y = 0.
"""

from __future__ import annotations

import math
import numbers
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.arrays import freeze
from envlights._common.check import amount, describe, positive, reals, rotation, whole_numbers
from envlights._native import EnvLightsError

#: Distance from a surface, relative to the size of the solid, within which a point lies on it.
_ON_SURFACE = 1e-6
#: Smallest cosine between the normal of a point and that of the surface on which it lies.
_LEAST_COSINE = 0.5

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Ball:
    """A ball.

    Examples
    --------
    >>> Ball((0, 0.5, 0), 0.5).lowest
    0.0
    """

    centre: Vector
    """Centre, in any unit of length."""

    radius: float
    """Radius, above 0."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", _vector("centre", self.centre))
        object.__setattr__(self, "radius", positive("radius", self.radius))

    @property
    def lowest(self) -> float:
        """Height of the lowest point."""
        return self.centre[1] - self.radius

    def normals_at(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Outward normals at the points that lie on the surface, NaN at all others."""
        away = points - self.centre
        distance = np.linalg.norm(away, axis=1)
        is_on = np.abs(distance - self.radius) <= _ON_SURFACE * self.radius
        scale = np.where(is_on, distance, np.nan)
        return np.asarray(away / scale[:, None])[:, None]


class _FlatFaces:
    """Normals of a solid with flat faces."""

    vertices: tuple[Vector, ...]
    faces: tuple[tuple[int, ...], ...]

    @property
    def lowest(self) -> float:
        """Height of the lowest point."""
        return min(vertex[1] for vertex in self.vertices)

    def planes(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Unit normal of each face, (faces, 3), and distance of its plane from the origin."""
        vertices = np.array(self.vertices)
        centre = vertices.mean(axis=0)
        loops = [vertices[list(face)] for face in self.faces]
        areas = np.array([np.cross(v, np.roll(v, -1, axis=0)).sum(axis=0) for v in loops])
        normals = areas / np.linalg.norm(areas, axis=1, keepdims=True)
        middles = np.array([v.mean(axis=0) for v in loops])
        outward = np.sign(np.einsum("fi,fi->f", normals, middles - centre))
        normals *= outward[:, None]
        return normals, np.einsum("fi,fi->f", normals, middles)

    def normals_at(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Outward normals of the faces that contain each point, (n, faces, 3), otherwise NaN."""
        normals, distances = self.planes()
        size = float(np.ptp(np.array(self.vertices), axis=0).max())
        heights = points @ normals.T - distances
        is_on = np.abs(heights) <= _ON_SURFACE * size
        is_on &= (heights <= _ON_SURFACE * size).all(axis=1, keepdims=True)
        return np.asarray(np.where(is_on[..., None], normals, np.nan))


@dataclass(frozen=True)
class Box(_FlatFaces):
    """A box with flat sides.

    Examples
    --------
    >>> box = Box((0, 1, 0), (0.5, 1, 0.5), turn=0.3)
    >>> len(box.vertices), box.lowest
    (8, 0.0)
    """

    centre: Vector
    """Centre, in any unit of length."""

    half_sides: Vector
    """Half of each side, above 0."""

    turn: float | tuple[Vector, Vector, Vector] = 0.0
    """Rotation: an angle in radians about +y, which turns +z towards +x, or a matrix, (3, 3)."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", _vector("centre", self.centre))
        halves = _vector("half_sides", self.half_sides)
        object.__setattr__(self, "half_sides", tuple(positive("half_sides", h) for h in halves))
        is_angle = isinstance(self.turn, numbers.Real)
        turn = _angle(self.turn) if is_angle else _rows("turn", rotation(self.turn))
        object.__setattr__(self, "turn", turn)

    @property
    def vertices(self) -> tuple[Vector, ...]:  # type: ignore[override]
        """The eight corners."""
        signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        corners = np.array(self.centre) + (signs * self.half_sides) @ _matrix(self.turn).T
        return _rows("vertices", corners)

    @property
    def faces(self) -> tuple[tuple[int, ...], ...]:  # type: ignore[override]
        """Corner indices of each of the six faces, in order."""
        return (0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5)


@dataclass(frozen=True)
class Polyhedron(_FlatFaces):
    """A convex polyhedron.

    Examples
    --------
    >>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> Polyhedron(corners, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]).lowest
    0.0
    """

    vertices: tuple[Vector, ...]
    """Corners, (n, 3), in any unit of length."""

    faces: tuple[tuple[int, ...], ...]
    """Corner indices of each face, clockwise or counter-clockwise. Each edge joins two faces."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", _rows("vertices", self.vertices))
        if isinstance(self.faces, str) or not isinstance(self.faces, Iterable):
            raise EnvLightsError(f"faces must be rows of vertices; got {describe(self.faces)}")
        loops = [whole_numbers("faces", face) for face in self.faces]
        object.__setattr__(self, "faces", tuple(tuple(face.tolist()) for face in loops))
        # The kernel raises an error for solids that are not convex or not closed.
        check_solids([self])


#: Solid that casts a shadow.
Solid = Ball | Box | Polyhedron


@dataclass(frozen=True, eq=False)
class Stage:
    """Solids, and points of surfaces that receive light.

    Examples
    --------
    A point of the floor, and one on top of a box, which is recognised:

    >>> box = Box((0, 0.5, 0), (0.5, 0.5, 0.5))
    >>> Stage(box, [[2, 0, 0], [0, 1, 0]], [[0, 1, 0], [0, 1, 0]]).own
    array([-1,  0])
    """

    solids: tuple[Solid, ...]
    """Solids; a single solid becomes a tuple."""

    points: NDArray[np.float64]
    """Points that receive light, (n, 3)."""

    normals: NDArray[np.float64]
    """Unit surface normals at the points, (n, 3)."""

    # The constructor replaces None.
    own: NDArray[np.int64] = None  # type: ignore[assignment]
    """Index of the solid on whose surface each point lies, or -1, (n,). Computed by default."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "solids", solids_of(self.solids))
        points, normals = (_finite(name, getattr(self, name)) for name in ("points", "normals"))
        if len(points) != len(normals):
            raise EnvLightsError(
                f"normals must have the shape of points, {points.shape}; got {normals.shape}"
            )
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "normals", normals)
        own = self._owners() if self.own is None else whole_numbers("own", self.own)
        object.__setattr__(self, "own", freeze(own))

    def _owners(self) -> NDArray[np.int64]:
        """Index of the solid on whose surface each point lies, or -1."""
        own = np.full(len(self.points), -1)
        for row, solid in enumerate(self.solids):
            cosines = np.einsum("nfi,ni->nf", solid.normals_at(self.points), self.normals)
            own[(np.nan_to_num(cosines, nan=-1.0) > _LEAST_COSINE).any(axis=1)] = row
        return own

    @classmethod
    def floor(cls, solids: Solid | Iterable[Solid], points: ArrayLike) -> Stage:
        """Stage with floor points, (n, 3), whose normals are +y, none of them on a solid."""
        rows = _finite("points", points)
        up = np.broadcast_to([0.0, 1.0, 0.0], rows.shape)
        return cls(solids_of(solids), rows, up, np.full(len(rows), -1))


def solids_of(solids: Solid | Iterable[Solid]) -> tuple[Solid, ...]:
    """One or more solids as a tuple; raises an error for anything else."""
    is_one = isinstance(solids, Solid) or not isinstance(solids, Iterable)
    each: tuple[Any, ...] = (solids,) if is_one else tuple(solids)  # type: ignore[arg-type]
    for solid in each:
        if not isinstance(solid, Solid):
            raise EnvLightsError(
                "solids must be Ball, Box or Polyhedron, one or several;"
                f" got an object of the type {type(solid).__name__}"
            )
    return each


def check_solids(solids: Iterable[Solid]) -> None:
    """Raise an error for invalid solids: not convex, not closed, or flat."""
    from envlights import _native

    none = np.zeros((0, 3))
    _native.form_factors(Stage(tuple(solids), none, none, np.zeros(0, np.int64)))


def _finite(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """Vectors, (n, 3), as a read-only array; raises an error unless finite."""
    rows = reals(name, values, 2)
    if rows.shape[1] != 3:
        raise EnvLightsError(f"{name} must have the shape (n, 3); got {rows.shape}")
    if not np.isfinite(rows).all():
        bad = int(np.argwhere(~np.isfinite(rows).all(axis=1))[0, 0])
        raise EnvLightsError(f"{name} must be finite; row {bad} holds {rows[bad].tolist()}")
    return freeze(rows)


def _rows(name: str, values: ArrayLike) -> tuple[Vector, ...]:
    return tuple((x, y, z) for x, y, z in _finite(name, values).tolist())


def _vector(name: str, values: ArrayLike) -> Vector:
    vector = reals(name, values, 1)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise EnvLightsError(f"{name} must be three finite numbers; got {describe(values)}")
    x, y, z = vector.tolist()
    return x, y, z


def _angle(value: object) -> float:
    return amount("turn", value, least=-math.inf)


def _matrix(turn: Any) -> NDArray[np.float64]:
    """Rotation matrix for an angle about +y, or the given matrix."""
    if np.ndim(turn):
        return np.array(turn)
    cos, sin = math.cos(turn), math.sin(turn)
    return np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])
