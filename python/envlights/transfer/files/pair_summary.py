"""Summary of the pairs of a model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from envlights._common.result import Result


@dataclass(frozen=True, eq=False, repr=False)
class PairSummary(Result):
    """Summary of the pairs of a model, without their texels, so that more pairs can be added."""

    direct: NDArray[np.float64]
    """Direct images at norm 1, (k, 3, h * w)."""

    coefficients: NDArray[np.float64]
    """Coefficients of the indirect images in the basis, (k, 3, rank)."""

    outside: NDArray[np.float64]
    """Inner products of the residuals of the three rows of each image, (k, 3, 3)."""

    energy: NDArray[np.float64]
    """Sum of squares of each indirect image, (k,)."""

    def in_short(self) -> str:
        """Number of pairs, and rank."""
        return f"{len(self.energy)} pairs at rank {self.coefficients.shape[2]}"
