"""Triangles of the shapes in a scene, and ray tracing of first hits.

Mitsuba's scalar variant takes one call of Python for each ray; the kernel takes one for all.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights import _native

#: Corners of a rectangle in its UV coordinates, and the rows of its two triangles.
_CORNERS, _HALVES = ((0, 0), (1, 0), (1, 1), (0, 1)), [[0, 1, 2], [0, 2, 3]]


class ShapeHits(NamedTuple):
    """First hit of each ray."""

    shape: NDArray[np.int64]
    """Index of the shape, or -1, (n,)."""

    uv: NDArray[np.float64]
    """UV coordinates of the hit, (n, 2)."""

    is_front: NDArray[np.bool_]
    """True if the normal points against the ray, (n,)."""


class Triangles:
    """Triangles of several shapes."""

    def __init__(
        self,
        corners: NDArray[np.float64],
        uv: NDArray[np.float64],
        shape: NDArray[np.int64],
        is_flipped: NDArray[np.bool_],
    ) -> None:
        """Corners (n, 3, 3), UV coordinates (n, 3, 2), shapes (n,), and the mask of flipped ones.

        Corners are counter-clockwise as seen from the front, and clockwise in flipped triangles.
        """
        self.corners, self.uv, self.shape, self.is_flipped = corners, uv, shape, is_flipped

    @cached_property
    def _tree(self) -> _native.TriangleTree:
        return _native.TriangleTree(np.ascontiguousarray(self.corners.reshape(-1, 3)))

    def hits(self, origins: NDArray[np.float64], directions: NDArray[np.float64]) -> ShapeHits:
        """First hits of rays, (n, 3) each."""
        row, weights, is_front = self._tree.nearest(origins, directions)
        uv = self.uv[row]
        place = uv[:, 0] + np.einsum("nk,nkc->nc", weights, uv[:, 1:] - uv[:, :1])
        shape = np.where(row < 0, -1, self.shape[row])
        return ShapeHits(shape, place, is_front != self.is_flipped[row])


def triangles(mi: Any, shapes: Sequence[Any]) -> Triangles | None:
    """Triangles of shapes; None if a shape is neither a mesh nor a rectangle."""
    found = [_of_shape(mi, shape) for shape in shapes]
    each = [of_shape for of_shape in found if of_shape is not None]
    if len(each) < len(found):
        return None
    counts = [len(corners) for corners, _ in each]
    return Triangles(
        np.concatenate([corners for corners, _ in each]),
        np.concatenate([uv for _, uv in each]),
        np.repeat(np.arange(len(shapes)), counts),
        np.repeat([shape.has_flipped_normals() for shape in shapes], counts),
    )


def _of_shape(mi: Any, shape: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Corners (n, 3, 3) and UV coordinates (n, 3, 2) of a shape; None if it has no triangles."""
    if shape.shape_type() == int(mi.ShapeType.Rectangle):
        ends = [shape.eval_parameterization(mi.Point2f(*each)).p for each in _CORNERS]
        return np.array(ends, np.float64)[_HALVES], np.array(_CORNERS, np.float64)[_HALVES]
    return _of_mesh(mi, shape) if shape.is_mesh() else None


def _of_mesh(mi: Any, mesh: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Corners and UV coordinates of a mesh."""
    held = mi.traverse(mesh)
    places, uv, faces = (
        np.array(held[name]).reshape(-1, columns)
        for name, columns in (("vertex_positions", 3), ("vertex_texcoords", 2), ("faces", 3))
    )
    # Without UV coordinates no texel can be found; the chart of the shape was refused before.
    uv = uv if len(uv) else np.zeros((len(places), 2))
    return places[faces].astype(np.float64), uv[faces].astype(np.float64)
