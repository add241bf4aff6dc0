"""Training: a basis from pairs, then the matrix and its errors."""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights.transfer.pairs import Pairs, PairSummary
from envlights.transfer.report import TransferReport
from envlights.transfer.training import cluster, leave_one_out
from envlights.transfer.training.basis import (
    BasisSize,
    basis,
    directions,
    nothing_to_learn,
    outside,
)
from envlights.transfer.training.blocks import blocks
from envlights.transfer.training.gram import gram
from envlights.transfer.training.nonnegative import operator
from envlights.transfer.training.remainder import Estimator, PriorMean, estimator, estimator_around
from envlights.transfer.training.ridge import RIDGES

#: Largest number of blocks of a non-negative operator. In the noise-free room with 128 pairs, 64
#: blocks raise the median error for new lights from 2.8 to 3.1 %, and 1024 do not lower it.
_BLOCKS = 256
#: Largest number of blocks in cross-validation, which reports 3.1 % for that room; 256 blocks would
#: report 2.7 %.
_FOLD_BLOCKS = 64


#: Note of a report without leave-one-out errors.
_FOLDS = "errors for new lights are those of 8 folds instead of leave-one-out"
#: End of the note on copies.
_COPIES = "pairs are copies of others: left out together with them"


class Training(NamedTuple):
    """Result of training: a basis, and a summary of the pairs."""

    basis: NDArray[Any]
    """Orthonormal columns over the lit texels, (lit texels, rank)."""

    lit: NDArray[np.bool_]
    """Texels that are not black in every image, (H, W)."""

    mean: NDArray[Any]
    """Mean of all images in the lit texels, or empty."""

    learnt: PairSummary
    """Summary of the pairs."""

    notes: tuple[str, ...]
    """Notes on requests that the basis does not meet."""


def train(pairs: Pairs, size: BasisSize, centred: bool, progress: bool | None) -> Training:
    """Basis of the `pairs`, around their mean image if `centred`."""
    gram_of, basis_of = (
        (cluster.gram, cluster.basis)
        if pairs.is_lazy
        else (partial(gram, progress=progress), partial(basis, progress=progress))
    )
    # Find the directions of the images from their Gram matrix.
    measured = gram_of(pairs, centred=centred)
    every = directions(measured.products, pairs.dtype, measured.energy.sum())
    if not len(every.values):
        raise nothing_to_learn("the same" if centred else "black")
    # Keep the first directions, and read the images again to compute the columns.
    rank = size.count(every.values)
    first = every.first(rank)
    columns, mean = basis_of(pairs, measured, first, centred=centred)
    coefficients = first.coefficients
    residual = outside(measured.products, coefficients)
    learnt = PairSummary(pairs.direct, coefficients, residual, measured.energy)
    return Training(columns, measured.lit, mean, learnt, size.missed(every.values, rank))


def nonnegative_priors(
    columns: NDArray[Any], lit: NDArray[np.bool_], learnt: PairSummary
) -> tuple[PriorMean, PriorMean]:
    """Non-negative operators as prior means: fine for all pairs, coarse for the folds."""
    fine, coarse = (
        partial(operator, blocks=blocks(columns, lit, learnt.coefficients, most))
        for most in (_BLOCKS, _FOLD_BLOCKS)
    )
    return fine, coarse


def solve(
    learnt: PairSummary,
    ridge: float | str,
    channelwise: bool,
    notes: tuple[str, ...],
    priors: tuple[PriorMean, PriorMean] | None = None,
) -> tuple[NDArray[np.float64], TransferReport]:
    """Matrix from direct light to coefficients, with its errors; "loo" selects the ridge.

    `priors`: prior means that are learnt from all pairs, and from those of a fold.
    """
    apart = distinct(learnt)
    direct, coefficients = apart.learnt.direct, apart.learnt.coefficients
    # Notes of an earlier model are replaced.
    notes = tuple(note for note in notes if not note.endswith((_FOLDS, _COPIES)))
    if priors is None:
        solver = estimator(direct, coefficients, channelwise)
    else:
        solver = estimator_around(direct, coefficients, *priors)
        notes = (*notes, _FOLDS)
    chosen = _best_ridge(solver, apart) if isinstance(ridge, str) else ridge
    if apart.copies:
        notes = (*notes, f"{apart.copies} {_COPIES}")
    unseen = _left_out(solver, chosen, apart)
    report = report_of(apart, chosen, solver.residual(chosen), unseen, notes)
    return solver.transfer(chosen), report


def _best_ridge(solver: Estimator, apart: Distinct) -> float:
    """Ridge with the smallest mean leave-one-out error."""
    return float(min(RIDGES, key=lambda each: float(np.mean(_left_out(solver, each, apart)))))


def report_of(
    apart: Distinct,
    ridge: float,
    missed: NDArray[np.float64],
    unseen: NDArray[np.float64],
    notes: tuple[str, ...],
    prior_errors: tuple[float, ...] = (),
) -> TransferReport:
    """Report of a regression with coefficient residuals `missed`, (k, 3, rank).

    `unseen` are the errors for new lights.
    """
    learnt = apart.learnt
    # Split the energy of the images into the parts inside and outside of the basis.
    inside = np.sum(learnt.coefficients**2)
    residual = np.trace(learnt.outside, axis1=1, axis2=2)
    # Add the error of the regression inside the basis to the residual outside.
    squares = np.sum(missed**2, axis=(1, 2)) + residual
    return TransferReport(
        pairs=len(apart.group),
        rank=learnt.coefficients.shape[2],
        energy=float(inside / (inside + residual.sum())),
        ridge=ridge,
        unseen_errors=tuple(unseen.tolist()),
        training_errors=tuple(_relative(squares, apart).tolist()),
        prior_errors=prior_errors,
        notes=notes,
    )


def _left_out(solver: Estimator, ridge: float, apart: Distinct) -> NDArray[np.float64]:
    """Leave-one-out error of each image that is not black."""
    learnt = apart.learnt
    missed = solver.left_out(ridge)
    squares = leave_one_out.squares(learnt.coefficients, learnt.outside, missed)
    return _relative(squares, apart)


def _relative(squares: NDArray[np.float64], apart: Distinct) -> NDArray[np.float64]:
    """Relative error of each image that is not black, including copies."""
    return leave_one_out.relative(squares[apart.group], apart.learnt.energy[apart.group])


#: Largest relative difference between two copies, due to single-precision rounding.
_SAME = 1e-6


class Distinct(NamedTuple):
    """Distinct pairs, with an index from all pairs to the distinct ones."""

    learnt: PairSummary
    """Summary of the distinct pairs, each scaled by the square root of its number of copies."""

    group: NDArray[np.intp]
    """Index of the distinct pair that each pair equals, (k,)."""

    @property
    def copies(self) -> int:
        """Number of copies."""
        return len(self.group) - len(self.learnt.energy)


def distinct(learnt: PairSummary) -> Distinct:
    """Merge equal pairs."""
    first = _first(learnt)
    kept, group, times = np.unique(first, return_inverse=True, return_counts=True)
    root = np.sqrt(times)[:, None, None]
    together = PairSummary(
        learnt.direct[kept] * root,
        learnt.coefficients[kept] * root,
        learnt.outside[kept] * root**2,
        learnt.energy[kept] * times,
    )
    return Distinct(together, group.ravel())


def _first(learnt: PairSummary) -> NDArray[np.intp]:
    """Index of the first pair that equals each pair, (k,); its own index if it is the first."""
    count = len(learnt.energy)
    direct = learnt.direct.reshape(count, -1)
    first = np.arange(count)
    # Direct images have norm 1, so only images whose product is 1 can be equal.
    for i, j in np.argwhere(np.tril(direct @ direct.T > 1 - _SAME, -1)):
        are_same = first[j] == j and all(
            np.linalg.norm(part[i] - part[j]) <= _SAME * np.linalg.norm(part[i])
            for part in (direct, learnt.coefficients, learnt.energy)
        )
        if are_same and first[i] == i:
            first[i] = j
    return first
