"""Training: from pairs to a basis, and from a basis to its matrix and errors."""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._native import EnvLightsError
from envlights.transfer import cluster, leave_one_out
from envlights.transfer.basis import Wanted, basis, directions, outside
from envlights.transfer.copies import Distinct, distinct
from envlights.transfer.gram import gram
from envlights.transfer.learnt import Learnt
from envlights.transfer.pairs import Pairs
from envlights.transfer.report import TransferReport
from envlights.transfer.ridge import RIDGES, Regression, regression


class Trained(NamedTuple):
    """A basis, and what a model keeps of its pairs."""

    basis: NDArray[Any]
    """Orthonormal columns over the lit texels, (lit texels, rank)."""

    lit: NDArray[np.bool_]
    """Texels that are not black in every image, (H, W)."""

    mean: NDArray[Any]
    """Mean of all rows in those texels, or empty."""

    learnt: Learnt
    """The summary of the pairs."""

    notes: tuple[str, ...]
    """Where the basis falls short of what was asked for."""


def trained(pairs: Pairs, wanted: Wanted, centred: bool, progress: bool | None) -> Trained:
    """The basis of the `pairs`; `centred`: around the mean of their rows."""
    gram_of, basis_of = (
        (cluster.gram, cluster.basis)
        if pairs.is_lazy
        else (partial(gram, progress=progress), partial(basis, progress=progress))
    )
    # Find the directions of the images from their inner products.
    measured = gram_of(pairs, centred=centred)
    found = directions(measured.products, pairs.dtype, measured.energy.sum())
    if not len(found.values):
        what = "the same in every image" if centred else "black in every image"
        raise EnvLightsError(f"indirect is {what}; there is nothing to learn")
    # Keep the first of them, and read the images once more for their columns.
    rank = wanted.count(found.values)
    kept = found.first(rank)
    columns, mean = basis_of(pairs, measured, kept, centred=centred)
    coefficients = kept.coefficients
    left = outside(measured.products, coefficients)
    learnt = Learnt(pairs.direct, coefficients, left, measured.energy)
    return Trained(columns, measured.lit, mean, learnt, wanted.missed(found.values, rank))


def solved(
    learnt: Learnt, ridge: float | str, channelwise: bool, notes: tuple[str, ...]
) -> tuple[NDArray[np.float64], TransferReport]:
    """The matrix from direct light to coefficients, and its errors; "loo" finds the best ridge."""
    apart = distinct(learnt)
    solver = regression(apart.learnt.direct, channelwise)
    chosen = _best_ridge(solver, apart) if isinstance(ridge, str) else ridge
    if apart.copies:
        notes = (*notes, f"{apart.copies} pairs are copies of others: left out together with them")
    transfer = solver.transfer(chosen, apart.learnt.coefficients)
    return transfer, _report(solver, chosen, apart, notes)


def _best_ridge(solver: Regression, apart: Distinct) -> float:
    """The ridge with the least mean of leave-one-out errors."""
    return float(min(RIDGES, key=lambda each: float(np.mean(_left_out(solver, each, apart)))))


def _report(
    solver: Regression, ridge: float, apart: Distinct, notes: tuple[str, ...]
) -> TransferReport:
    learnt = apart.learnt
    # Split the energy of the images into that inside and that outside of the basis.
    inside = np.sum(learnt.coefficients**2)
    left = np.trace(learnt.outside, axis1=1, axis2=2)
    # Add what the regression misses inside to what the basis misses outside.
    missed = solver.residual(ridge, learnt.coefficients)
    squares = np.sum(missed**2, axis=(1, 2)) + left
    return TransferReport(
        pairs=len(apart.group),
        rank=learnt.coefficients.shape[2],
        energy=float(inside / (inside + left.sum())),
        ridge=ridge,
        unseen_errors=tuple(_left_out(solver, ridge, apart).tolist()),
        training_errors=tuple(_relative(squares, apart).tolist()),
        notes=notes,
    )


def _left_out(solver: Regression, ridge: float, apart: Distinct) -> NDArray[np.float64]:
    """Leave-one-out error of each image that is not black."""
    learnt = apart.learnt
    missed = solver.left_out(ridge, learnt.coefficients)
    squares = leave_one_out.squares(learnt.coefficients, learnt.outside, missed)
    return _relative(squares, apart)


def _relative(squares: NDArray[np.float64], apart: Distinct) -> NDArray[np.float64]:
    """Relative error of each image that is not black, copies among them."""
    squares, energy = squares[apart.group], apart.learnt.energy[apart.group]
    is_bright = energy > 0
    errors: NDArray[np.float64] = np.sqrt(np.maximum(squares[is_bright], 0) / energy[is_bright])
    return errors
