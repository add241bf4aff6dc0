"""Ridge regression of what a prior mean leaves over, and its errors for lights outside the pairs.

With a prior mean T0 of the matrix, the ridge (see `ridge.py`) pulls towards T0 instead of 0:

    T = T0 + X^T (X X^T + ridge I)^-1 (A - X T0) .

A prior mean that was itself learnt from the pairs has no closed form without one of them, so its
errors come from folds: both T0 and the regression are learnt without each eighth of the pairs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from envlights.transfer.training.gram import product
from envlights.transfer.training.ridge import Regression, regression

#: Parts of the pairs that are left out, one after the other.
_FOLDS = 8

#: Prior mean, (3, direct texels, rank), from the direct images and the coefficients of pairs.
PriorMean = Callable[[Regression, NDArray[np.float64]], NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class Estimator:
    """Regression of coefficients on direct light, around a prior mean."""

    solver: Regression
    """Regression on the direct images of all pairs."""

    mean: NDArray[np.float64] | None
    """Prior mean of the matrix, (3, direct texels, rank); absent: 0."""

    remainder: NDArray[np.float64]
    """Coefficients less those of the prior mean, (k, 3, rank)."""

    folds: tuple[Fold, ...] | None = None
    """Regressions without a part of the pairs; absent: errors have a closed form."""

    def transfer(self, ridge: float) -> NDArray[np.float64]:
        """Matrix from direct light to coefficients, (3, features, rank)."""
        own = self.solver.transfer(ridge, self.remainder)
        return own if self.mean is None else self.mean + own

    def residual(self, ridge: float) -> NDArray[np.float64]:
        """Coefficients less what the fit to all of them gives, (k, 3, rank)."""
        return self.solver.residual(ridge, self.remainder)

    def left_out(self, ridge: float) -> NDArray[np.float64]:
        """Coefficients less what a fit without their image or fold gives, (k, 3, rank)."""
        if self.folds is None:
            return self.solver.left_out(ridge, self.remainder)
        missed = np.empty_like(self.remainder)
        for fold in self.folds:
            missed[fold.which] = fold.missed(ridge)
        return missed


@dataclass(frozen=True, eq=False)
class Fold:
    """Regression on all pairs but those of one part, ready for any ridge."""

    which: NDArray[np.intp]
    """Pairs of the part, (n,)."""

    solver: Regression
    """Regression on the other pairs."""

    products: NDArray[np.float64]
    """Inner products of direct images of the part with eigenvectors of the others, (3, n, k)."""

    turned: NDArray[np.float64]
    """Remainder of the others in these eigenvectors, (3, k, rank)."""

    remainder: NDArray[np.float64]
    """Remainder of the part, (n, 3, rank)."""

    def missed(self, ridge: float) -> NDArray[np.float64]:
        """Coefficients of the part less what the others give, (n, 3, rank)."""
        weights = self.products / self.solver.regularised_eigenvalues(ridge)[:, None]
        missed: NDArray[np.float64] = self.remainder - product(weights, self.turned).swapaxes(0, 1)
        return missed


def estimator(
    direct: NDArray[np.float64],
    coefficients: NDArray[np.float64],
    channelwise: bool,
) -> Estimator:
    """Regression without a prior mean."""
    return Estimator(regression(direct, channelwise), None, coefficients)


def estimator_around(
    direct: NDArray[np.float64],
    coefficients: NDArray[np.float64],
    prior: PriorMean,
    prior_of_folds: PriorMean,
) -> Estimator:
    """Regression around a prior mean that is learnt from the pairs.

    `prior_of_folds` may be a faster, less accurate version.
    """
    solver = regression(direct, channelwise=True)
    mean = prior(solver, coefficients)
    folds = tuple(
        _fold(direct, coefficients, np.arange(first, len(direct), _FOLDS), prior_of_folds)
        for first in range(min(_FOLDS, len(direct)))
    )
    return Estimator(solver, mean, _remainder(solver, mean, coefficients), folds)


def _fold(
    direct: NDArray[np.float64],
    coefficients: NDArray[np.float64],
    which: NDArray[np.intp],
    prior: PriorMean,
) -> Fold:
    # Learn from one black pair where there is no other.
    black = len(which) == len(direct)
    others = (
        (0 * direct[:1], 0 * coefficients[:1])
        if black
        else (
            np.delete(direct, which, axis=0),
            np.delete(coefficients, which, axis=0),
        )
    )
    solver = regression(others[0], channelwise=True)
    mean = prior(solver, others[1])
    own = direct[which].swapaxes(0, 1)
    products = product(product(own, solver.features.swapaxes(1, 2)), solver.vectors)
    left = _remainder(solver, mean, others[1]).swapaxes(0, 1)
    turned = product(solver.vectors.swapaxes(1, 2), left)
    remainder = coefficients[which] - product(own, mean).swapaxes(0, 1)
    return Fold(which, solver, products, turned, remainder)


def _remainder(
    solver: Regression, mean: NDArray[np.float64], coefficients: NDArray[np.float64]
) -> NDArray[np.float64]:
    remainder: NDArray[np.float64] = coefficients - product(solver.features, mean).swapaxes(0, 1)
    return remainder
