"""A step from 0 to 1 without kinks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def smoothstep(values: NDArray[np.float64], start: float, end: float) -> NDArray[np.float64]:
    """Hermite's cubic 3 t^2 - 2 t^3: 0 up to `start`, 1 from `end` on."""
    t = np.clip((values - start) / (end - start), 0, 1)
    step: NDArray[np.float64] = t * t * (3 - 2 * t)
    return step
