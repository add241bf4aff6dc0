"""Ridge regression that weights direct texels by the norm of their indirect light.

A prior errs by a fraction of what each direct texel sends: by where the light falls within the
texel, and by what a few rays miss. So the remainder of the pairs, R = Y - X T0, has the prior
variance w_s^2 in each direct texel s, and the noise of the image i grows with its light. In each
channel, with W = diag(w) and N = diag(n), n_i = |x_i W|, this is the ridge of `ridge.py` for

    features  N^-1 X W,  images  N^-1 R,

whose rows have norm 1. Its matrix T becomes W T.

A ridge on the texels themselves lets one texel in a corner, whose light is strong nearby, explain
images of other texels.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from envlights.transfer.training.gram import product
from envlights.transfer.training.ridge import Regression, regression


@dataclass(frozen=True, eq=False)
class WeightedRegression:
    """Regression on direct images, with a weight for each direct texel."""

    weights: NDArray[np.float64]
    """Weight of each direct texel, (3, texels)."""

    norms: NDArray[np.float64]
    """Norms of the weighted images, (k, 3, 1); 1 for black images."""

    solver: Regression
    """Regression on weighted images scaled to norm 1."""

    def transfer(self, ridge: float, coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
        """Matrix from direct light to coefficients, (3, texels, rank)."""
        matrix = self.solver.transfer(ridge, coefficients / self.norms)
        return self.weights[..., None] * matrix

    def residual(self, ridge: float, coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
        """Residual coefficients of the fit to all images, (k, 3, rank)."""
        return self.norms * self.solver.residual(ridge, coefficients / self.norms)

    def left_out(self, ridge: float, coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
        """Leave-one-out residuals of the coefficients, (k, 3, rank)."""
        return self.norms * self.solver.left_out(ridge, coefficients / self.norms)

    def shares(self, ridge: float, direct: NDArray[np.float64]) -> NDArray[np.float64]:
        """Weight of each training image in predictions for `direct` (n, 3, texels), (3, n, k)."""
        solver = self.solver
        rows = (self.weights * direct).swapaxes(0, 1)
        turned = product(product(rows, solver.features.swapaxes(1, 2)), solver.vectors)
        turned /= solver.regularised_eigenvalues(ridge)[:, None]
        shares = product(turned, solver.vectors.swapaxes(1, 2))
        return np.asarray(shares / self.norms.transpose(1, 2, 0))


def weighted_regression(
    direct: NDArray[np.float64], weights: NDArray[np.float64]
) -> WeightedRegression:
    """Regression on direct images (k, 3, texels) with weights (3, texels)."""
    rows = weights * direct
    norms = np.linalg.norm(rows, axis=2, keepdims=True)
    norms[norms == 0] = 1.0
    return WeightedRegression(weights, norms, regression(rows / norms, channelwise=True))
