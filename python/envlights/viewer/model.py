"""Models of the user's: triangles with albedos, on the floor, in metres."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common import check
from envlights._native import EnvLightsError
from envlights.viewer import model_file
from envlights.viewer.model_file import ALBEDO, check_count

#: Plausible sizes in metres: others get a note on the scale.
_SMALL, _LARGE = 0.01, 100.0

#: Matrices that turn the axis of a file which points up into +y.
_UP = {"y": np.eye(3), "z": np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])}


class Model:
    """Triangles with an albedo at each corner, which stand on the floor of a page of `el.view`.

    The model is scaled, turned so that `up` is +y, and moved: its lowest point to y = 0, the centre
    of its box to x = z = 0. Triangles without area are left out.

    Parameters
    ----------
    vertices : array_like, shape (n, 3)
        Positions, in metres after `scale`.
    triangles : array_like of int, shape (m, 3)
        Rows of `vertices`; at most 200 000 triangles.
    albedo : array_like, shape (3,), (n, 3) or (m, 3, 3)
        Linear albedo, from 0 to 1, of the whole model, of each vertex, or of each corner.
    scale : float
        Metres per unit of `vertices`.
    up : {"y", "z"}
        Axis that points up.

    Raises
    ------
    EnvLightsError
        If the arrays are no triangles, hold NaN or infinity, or are too many.

    Examples
    --------
    >>> import envlights as el
    >>> tent = el.viewer.Model([[0, 0, 0], [2, 0, 0], [1, 0, 2], [1, 3, 1]],
    ...                 [[0, 1, 3], [1, 2, 3], [2, 0, 3]], scale=0.5)
    >>> tent
    Model(3 triangles, 1 x 1.5 x 1 m)
    """

    def __init__(
        self,
        vertices: ArrayLike,
        triangles: ArrayLike,
        albedo: ArrayLike = (ALBEDO, ALBEDO, ALBEDO),
        *,
        scale: float = 1.0,
        up: str = "y",
    ) -> None:
        points = _points(vertices)
        rows = _triangles(triangles, len(points))
        colours = _corner_albedo(albedo, rows, len(points))
        points = _on_floor(points, rows, check.amount("scale", scale, least=1e-9, most=1e9), up)
        keep = _areas(points, rows) > 0
        if not keep.any():
            raise EnvLightsError(
                f"the model has no triangle with an area, of {len(rows)}; give vertices that differ"
            )
        #: Positions in metres, (n, 3).
        self.vertices = points
        #: Rows of `vertices`, (m, 3).
        self.triangles: NDArray[np.int64] = rows[keep]
        #: Linear albedo of each corner, (m, 3, 3).
        self.albedo: NDArray[np.float64] = colours[keep]
        #: Remarks on what was assumed or left out.
        self.notes: tuple[str, ...] = tuple(self._remarks(int((~keep).sum())))

    @classmethod
    def open(cls, source: Any, *, scale: float = 1.0, up: str = "y") -> Model:
        """Model of a file (glTF, GLB, OBJ, PLY, STL, OFF), or of an object of trimesh.

        Colours are those of the material, its texture at the vertices, or the vertices' own.

        Parameters
        ----------
        source : path, or trimesh.Trimesh or trimesh.Scene
            File, which the library trimesh reads, or its object.
        scale : float
            Metres per unit of the file.
        up : {"y", "z"}
            Axis of the file that points up.

        Raises
        ------
        EnvLightsError
            If the file cannot be read, or is no model.
        FileNotFoundError
            If there is no such file.

        Examples
        --------
        >>> import envlights as el
        >>> chair = el.viewer.Model.open("chair.glb", scale=0.01)  # doctest: +SKIP
        """
        is_path = isinstance(source, str | os.PathLike)
        try:
            parts = model_file.read(source)
            starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
            return cls(
                np.concatenate([part.vertices for part in parts]),
                np.concatenate([p.triangles + k for p, k in zip(parts, starts, strict=False)]),
                np.concatenate([part.albedo for part in parts]),
                scale=scale,
                up=up,
            )
        except EnvLightsError as error:
            where = f"cannot show {check.describe(source)}: " if is_path else ""
            raise type(error)(f"{where}{error}") from None

    @property
    def size(self) -> NDArray[np.float64]:
        """Width, height and depth in metres, (3,)."""
        used = self.vertices[self.triangles.ravel()]
        return np.asarray(used.max(axis=0) - used.min(axis=0))

    def __repr__(self) -> str:
        width, height, depth = self.size
        return f"Model({len(self.triangles)} triangles, {width:.3g} x {height:.3g} x {depth:.3g} m)"

    def _remarks(self, without_area: int) -> list[str]:
        """Notes on triangles that are left out, and on a scale that is probably wrong."""
        notes = []
        if without_area:
            notes.append(f"{without_area} triangles without area are left out")
        size = float(self.size.max())
        if not _SMALL <= size <= _LARGE:
            notes.append(
                f"the model is {size:.3g} m large; if its unit is not the metre, pass scale="
                f" (0.001 for millimetres, 0.01 for centimetres)"
            )
        return notes


def _points(vertices: ArrayLike) -> NDArray[np.float64]:
    """Positions as a finite array, (n, 3)."""
    points = check.reals("vertices", vertices, 2)
    if points.shape[1] != 3:
        raise EnvLightsError(f"vertices must have the shape (n, 3); got {points.shape}")
    bad = check.first_not_finite(points)
    if bad is not None:
        raise EnvLightsError(
            f"vertices must be finite; vertex {bad[0]} holds {bad[2]}; remove or repair it"
        )
    if len(points) and np.abs(points).max() > 1e12:
        raise EnvLightsError("vertices must lie within 1e12 of the origin; check their unit")
    return points


def _triangles(triangles: ArrayLike, count: int) -> NDArray[np.int64]:
    """Rows of vertices that exist, (m, 3)."""
    rows = np.asarray(triangles)
    if rows.ndim != 2 or rows.shape[1:] != (3,) or rows.dtype.kind not in "iu":
        raise EnvLightsError(
            f"triangles must be whole numbers of the shape (m, 3); got {rows.dtype} {rows.shape};"
            " split polygons into triangles"
        )
    check_count(len(rows))
    if rows.min() < 0 or int(rows.max()) >= count:
        bad = int(rows.min()) if rows.min() < 0 else int(rows.max())
        raise EnvLightsError(f"triangles must name vertices from 0 to {count - 1}; got {bad}")
    return rows.astype(np.int64)


def _corner_albedo(albedo: ArrayLike, rows: NDArray[np.int64], count: int) -> NDArray[np.float64]:
    """Albedo of each corner, (m, 3, 3)."""
    values = check.reals("albedo", albedo, None)
    if not (np.isfinite(values).all() and (values >= 0).all() and (values <= 1).all()):
        raise EnvLightsError(
            "albedo must be from 0 to 1; divide 8-bit codes by 255 and decode sRGB"
        )
    shapes = {(3,): None, (count, 3): rows, (len(rows), 3, 3): ...}
    if values.shape not in shapes:
        raise EnvLightsError(
            f"albedo must have the shape (3,), ({count}, 3) or ({len(rows)}, 3, 3);"
            f" got {values.shape}"
        )
    if values.ndim == 1:
        return np.broadcast_to(values, (len(rows), 3, 3))
    return values[rows] if values.ndim == 2 else values


def _on_floor(
    points: NDArray[np.float64], rows: NDArray[np.int64], scale: float, up: str
) -> NDArray[np.float64]:
    """Points scaled and turned, with the box of the triangles centred on the floor."""
    check.check_choice("up", up, tuple(_UP))
    turned = scale * points @ _UP[up].T
    used = turned[rows.ravel()]
    lower, upper = used.min(axis=0), used.max(axis=0)
    centre = (lower + upper) / 2
    centre[1] = lower[1]
    return np.asarray(turned - centre)


def _areas(points: NDArray[np.float64], rows: NDArray[np.int64]) -> NDArray[np.float64]:
    """Twice the area of each triangle."""
    a, b, c = (points[rows[:, k]] for k in range(3))
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1))
