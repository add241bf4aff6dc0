"""Ridge regression from direct light to coefficients, by k x k systems.

With direct images `X` (k, texels) and coefficients `A` (k, rank), the matrix

    T = X^T (X X^T + ridge I)^-1 A  =  (X^T X + ridge I)^-1 X^T A

is found on the smaller side: k images are fewer than their texels and channels. The eigensystem of
X X^T serves every ridge. What the image `i` would get from a fit without it is, in closed form,

    a_i - â_(i) = [C A]_i / C_ii,    C = (X X^T + ridge I)^-1 .
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from envlights.transfer.training.gram import eigensystem, product

#: Candidate ridges for "loo", from clean to noisy images, for direct images of norm 1.
RIDGES = tuple(10.0 ** (exponent / 2) for exponent in range(-16, 1))


@dataclass(frozen=True, eq=False)
class Regression:
    """Direct images, decomposed so that any ridge can be solved."""

    features: NDArray[np.float64]
    """Direct texels of each image: (3, k, texels) by channel, or (1, k, 3 * texels) joint."""

    values: NDArray[np.float64]
    """Eigenvalues of the Gram matrix of the features, (3 or 1, k)."""

    vectors: NDArray[np.float64]
    """Eigenvectors of the Gram matrix, (3 or 1, k, k)."""

    def transfer(self, ridge: float, coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
        """Matrix from direct light to coefficients, (3, features, rank)."""
        turned = product(self.features.swapaxes(1, 2), self.vectors)
        return product(turned, self._weighted(ridge, coefficients))

    def residual(self, ridge: float, coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
        """Residual coefficients of the fit to all images, (k, 3, rank)."""
        fitted = product(self.features, self.transfer(ridge, coefficients))
        missed: NDArray[np.float64] = coefficients - fitted.swapaxes(0, 1)
        return missed

    def left_out(self, ridge: float, coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
        """Leave-one-out residuals of the coefficients, (k, 3, rank)."""
        own = np.einsum("cik,ck->ci", self.vectors**2, 1 / self.regularised_eigenvalues(ridge))
        missed = product(self.vectors, self._weighted(ridge, coefficients))
        missed /= own[..., None]
        return missed.swapaxes(0, 1)

    def _weighted(self, ridge: float, coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
        """Coefficients in the eigenvectors, divided by the eigenvalues.

        The inverse matrix would lose all digits for nearly equal images.
        """
        turned = product(self.vectors.swapaxes(1, 2), coefficients.swapaxes(0, 1))
        weighted: NDArray[np.float64] = turned / self.regularised_eigenvalues(ridge)[..., None]
        return weighted

    def regularised_eigenvalues(self, ridge: float) -> NDArray[np.float64]:
        """Eigenvalues of ``X X^T + ridge I``; the ridge is at least the rounding error."""
        k = self.values.shape[1]
        least = k * np.finfo(np.float64).eps * self.values.max(axis=1, keepdims=True)
        least += np.finfo(np.float64).tiny
        values: NDArray[np.float64] = np.maximum(self.values, 0) + np.maximum(ridge, least)
        return values


def regression(direct: NDArray[np.float64], channelwise: bool) -> Regression:
    """Regression on direct images (k, 3, texels)."""
    features = direct.swapaxes(0, 1) if channelwise else direct.reshape(1, len(direct), -1)
    values, vectors = eigensystem(product(features, features.swapaxes(1, 2)))
    return Regression(features, values, vectors)
