"""A lightmap for the shapes of a Mitsuba scene: one square chart for each shape."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._native import EnvLightsError
from envlights.scene.mitsuba.renderer import in_one_line
from envlights.scene.surface import Surface


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
