"""What a model keeps of its pairs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Learnt:
    """What a model keeps of its pairs, so that more can be added: no texel of them."""

    direct: NDArray[np.float64]
    """Direct images at norm 1, (k, 3, h * w)."""

    coefficients: NDArray[np.float64]
    """Of the indirect images in the basis, (k, 3, rank)."""

    outside: NDArray[np.float64]
    """Inner products of what the basis leaves of the three rows of each image, (k, 3, 3)."""

    energy: NDArray[np.float64]
    """Sum of squares of each indirect image, (k,)."""
