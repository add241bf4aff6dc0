"""Pixels of a map in given directions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights.environment.envmap import EnvMap
from envlights.kernels import sphere


def looked_up(env: EnvMap, directions: NDArray[np.float64]) -> NDArray[np.float32]:
    """Pixel of a map in each direction, (n, 3)."""
    cells = env.cells()
    uv = sphere.direction_to_uv(directions)
    columns = (uv[:, 0] * env.width).astype(int) % env.width
    rows = np.minimum((uv[:, 1] * env.height).astype(int), env.height - 1)
    pixels: NDArray[np.float32] = cells[rows, columns]
    return pixels
