"""Products and eigensystems of matrices with a side of thousands: Ctrl-C does not wait for them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.interruptible import interruptible


def product(left: NDArray[Any], right: NDArray[Any]) -> NDArray[Any]:
    """``left @ right``."""
    whole: NDArray[Any] = interruptible(lambda: left @ right, left.size * right.shape[-1])
    return whole


def eigensystem(symmetric: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Eigenvalues, least first, and eigenvectors as columns, of one matrix or a stack."""
    values, vectors = interruptible(
        lambda: np.linalg.eigh(symmetric), 10 * symmetric.size * symmetric.shape[-1]
    )
    return values, vectors
