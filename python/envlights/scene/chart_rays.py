"""Rays of Mitsuba, and the texel of a chart that each of them hits."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights.scene.gather import BACK, SKY, TexelHit

#: Shape, texture coordinates, and cosine between normal and ray, of a ray that hits nothing.
_MISS = (0, 0.0, 0.0, 2.0)


def texel_hits(mi: Any, scene: Any, shapes: Sequence[Any], width: int, size: int) -> TexelHit:
    """Ray tracer of a scene for `gather`.

    `width` is that of the points of the direct images, charts as in `charts.charts`, and `size` the
    number of texels along a side of these images.
    """
    grid = ceil(sqrt(len(shapes)))
    side = width // grid
    number = {shape: k for k, shape in enumerate(shapes)}

    def hit(origin: list[float], direction: list[float]) -> tuple[int, float, float, float]:
        at = scene.ray_intersect(mi.Ray3f(origin, direction))
        if not at.is_valid():
            return _MISS
        (u, v), (x, y, z) = at.uv, at.n
        cosine = x * direction[0] + y * direction[1] + z * direction[2]
        return number[at.shape], u, v, cosine

    def texel_hit(
        origins: NDArray[np.float64], directions: NDArray[np.float64]
    ) -> NDArray[np.int64]:
        # Convert to lists: Mitsuba takes six times as long to read rows of arrays.
        rows = map(hit, origins.tolist(), directions.tolist())
        shape, u, v, cosine = np.array(list(rows)).reshape(-1, 4).T
        # Find the point in the chart, then the texel of the direct image around it.
        chart_row, chart_column = np.divmod(shape.astype(np.int64), grid)
        row = chart_row * side + np.clip((v * side).astype(np.int64), 0, side - 1)
        column = chart_column * side + np.clip((u * side).astype(np.int64), 0, side - 1)
        texel = row * size // width * size + column * size // width
        return np.where(cosine > 1, SKY, np.where(cosine < 0, texel, BACK))

    return texel_hit
