"""A lightmap for the shapes of a Mitsuba scene: square charts, and the texel that each ray hits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import ceil, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._native import EnvLightsError
from envlights.scene.gather import BACK, SKY, TexelHit
from envlights.scene.mitsuba.renderer import in_one_line
from envlights.scene.surface import Surface
from envlights.scene.triangles import ShapeHits

#: Origins (n, 3) and unit directions (n, 3) of rays -> their first hits.
FirstHits = Callable[[NDArray[np.float64], NDArray[np.float64]], ShapeHits]

#: Shape, texture coordinates, and side, of a ray that hits nothing.
_MISS = (-1, 0.0, 0.0, False)


def texel_hits(first_hits: FirstHits, shapes: int, width: int, size: int) -> TexelHit:
    """Ray tracer for `gather`.

    `width` is that of the points of the direct images, charts as in `charts.charts`, and `size` the
    number of texels along a side of these images.
    """
    grid = ceil(sqrt(shapes))
    side = width // grid

    def texel_hit(
        origins: NDArray[np.float64], directions: NDArray[np.float64]
    ) -> NDArray[np.int64]:
        shape, uv, is_front = first_hits(origins, directions)
        # Find the point in the chart, then the texel of the direct image around it.
        chart_row, chart_column = np.divmod(shape, grid)
        column, row = np.clip((uv * side).astype(np.int64), 0, side - 1).T
        row, column = chart_row * side + row, chart_column * side + column
        texel = row * size // width * size + column * size // width
        return np.where(shape < 0, SKY, np.where(is_front, texel, BACK))

    return texel_hit


def mitsuba_hits(mi: Any, scene: Any, shapes: Sequence[Any]) -> FirstHits:
    """Ray tracer of Mitsuba, for shapes without triangles; one call for each ray."""
    number = {shape: k for k, shape in enumerate(shapes)}

    def hit(origin: list[float], direction: list[float]) -> tuple[int, float, float, bool]:
        at = scene.ray_intersect(mi.Ray3f(origin, direction))
        if not at.is_valid():
            return _MISS
        (u, v), (x, y, z) = at.uv, at.n
        cosine = x * direction[0] + y * direction[1] + z * direction[2]
        return number[at.shape], u, v, cosine < 0

    def first_hits(origins: NDArray[np.float64], directions: NDArray[np.float64]) -> ShapeHits:
        # Convert to lists: Mitsuba takes six times as long to read rows of arrays.
        rows = map(hit, origins.tolist(), directions.tolist())
        found = np.array(list(rows), np.float64).reshape(-1, 4)
        return ShapeHits(found[:, 0].astype(np.int64), found[:, 1:3], found[:, 3] > 0)

    return first_hits


def charts(mi: Any, shapes: Sequence[Any], width: int) -> Surface:
    """Rows of charts, each the unit square of the UV coordinates of its shape.

    Texels without a surface, and those to the right of or below the last charts, stay empty. Where
    the UV coordinates of a shape overlap, the chart shows one of its layers.
    """
    # Divide the lightmap into a square grid of charts.
    grid = ceil(sqrt(len(shapes)))
    side = width // grid
    if not side:
        raise EnvLightsError(f"{len(shapes)} shapes need a lightmap {grid} wide; got {width}")
    # Fill position, normal and albedo chart by chart.
    maps = np.zeros((3, width, width, 3))
    for k, shape in enumerate(shapes):
        row, column = divmod(k, grid)
        chart = maps[:, row * side : (row + 1) * side, column * side : (column + 1) * side]
        for i, j in np.ndindex(side, side):
            chart[:, i, j] = _texel(mi, shape, ((j + 0.5) / side, (i + 0.5) / side))
    return Surface(*maps)


def _texel(mi: Any, shape: Any, uv: tuple[float, float]) -> NDArray[np.float64]:
    """Position, normal and albedo of a shape at `uv`; zeros where the shape has no point."""
    try:
        at = shape.eval_parameterization(mi.Point2f(*uv), int(mi.RayFlags.All))
    except RuntimeError as error:
        raise EnvLightsError(
            f"the shape '{shape.id()}' has no chart: {in_one_line(error)};"
            " give a lightmap of your own"
        ) from None
    if not at.is_valid():
        return np.zeros((3, 3))
    albedo = shape.bsdf().eval_diffuse_reflectance(at)
    return np.array([at.p, at.sh_frame.n, albedo])
