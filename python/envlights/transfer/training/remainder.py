"""Ridge regression around a prior mean, with errors for lights outside the training pairs.

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

#: Number of folds for cross-validation.
_FOLDS = 8

#: Function that computes a prior mean, (3, direct texels, rank), from direct images and
#: coefficients of pairs.
PriorMean = Callable[[Regression, NDArray[np.float64]], NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class Estimator:
    """Regression of coefficients on direct light, around a prior mean."""

    solver: Regression
    """Regression on the direct images of all pairs."""

    mean: NDArray[np.float64] | None
    """Prior mean of the matrix, (3, direct texels, rank); None means 0."""

    remainder: NDArray[np.float64]
    """Coefficients minus the coefficients of the prior mean, (k, 3, rank)."""

    folds: tuple[Fold, ...] | None = None
    """Regressions that each omit a part of the pairs; None if errors have a closed form."""

    def transfer(self, ridge: float) -> NDArray[np.float64]:
        """Matrix from direct light to coefficients, (3, features, rank)."""
        own = self.solver.transfer(ridge, self.remainder)
        return own if self.mean is None else self.mean + own

    def residual(self, ridge: float) -> NDArray[np.float64]:
        """Residual coefficients of the fit to all pairs, (k, 3, rank)."""
        return self.solver.residual(ridge, self.remainder)

    def left_out(self, ridge: float) -> NDArray[np.float64]:
        """Residual coefficients of each image in a fit without its image or fold, (k, 3, rank)."""
        if self.folds is None:
            return self.solver.left_out(ridge, self.remainder)
        missed = np.empty_like(self.remainder)
        for fold in self.folds:
            missed[fold.which] = fold.missed(ridge)
        return missed


@dataclass(frozen=True, eq=False)
class Fold:
    """Regression on all pairs outside a fold, ready for any ridge."""

    which: NDArray[np.intp]
    """Indices of the pairs in the fold, (n,)."""

    solver: Regression
    """Regression on the pairs outside the fold."""

    products: NDArray[np.float64]
    """Inner products of direct images in the fold with the eigenvectors, (3, n, k)."""

    turned: NDArray[np.float64]
    """Remainder of the other pairs in these eigenvectors, (3, k, rank)."""

    remainder: NDArray[np.float64]
    """Remainder of the pairs in the fold, (n, 3, rank)."""

    def missed(self, ridge: float) -> NDArray[np.float64]:
        """Residual coefficients of the fold in the fit to the other pairs, (n, 3, rank)."""
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
    """Regression around a prior mean that is itself learnt from the pairs.

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
    # With a single pair, train on one black pair instead.
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
