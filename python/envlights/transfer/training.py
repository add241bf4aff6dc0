"""The transfer matrix of a basis, and how far it can be trusted."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights.transfer import leave_one_out
from envlights.transfer.learnt import Learnt
from envlights.transfer.report import TransferReport
from envlights.transfer.ridge import RIDGES, Regression, regression


def solved(
    learnt: Learnt, ridge: float | str, channelwise: bool, notes: tuple[str, ...]
) -> tuple[NDArray[np.float64], TransferReport]:
    """What takes direct light to coefficients, and its errors; "loo" finds the best ridge."""
    solver = regression(learnt.direct, channelwise)
    held = _best_ridge(solver, learnt) if isinstance(ridge, str) else ridge
    transfer = solver.transfer(held, learnt.coefficients)
    return transfer, _report(solver, held, learnt, notes)


def _best_ridge(solver: Regression, learnt: Learnt) -> float:
    """The one with which images that are left out are least wrong."""
    return float(min(RIDGES, key=lambda each: float(np.mean(_unseen(solver, each, learnt)))))


def _report(
    solver: Regression, ridge: float, learnt: Learnt, notes: tuple[str, ...]
) -> TransferReport:
    left = np.trace(learnt.outside, axis1=1, axis2=2)
    missed = solver.residual(ridge, learnt.coefficients)
    inside = np.sum(learnt.coefficients**2)
    return TransferReport(
        pairs=len(learnt.direct),
        rank=learnt.coefficients.shape[2],
        energy=float(inside / (inside + left.sum())),
        ridge=ridge,
        unseen_errors=tuple(_unseen(solver, ridge, learnt).tolist()),
        training_errors=tuple(
            _relative(np.sum(missed**2, axis=(1, 2)) + left, learnt.energy).tolist()
        ),
        notes=notes,
    )


def _unseen(solver: Regression, ridge: float, learnt: Learnt) -> NDArray[np.float64]:
    """Leave-one-out error of each image that is not black."""
    missed = solver.left_out(ridge, learnt.coefficients)
    return _relative(
        leave_one_out.squares(learnt.coefficients, learnt.outside, missed), learnt.energy
    )


def _relative(squares: NDArray[np.float64], energy: NDArray[np.float64]) -> NDArray[np.float64]:
    is_lit = energy > 0
    errors: NDArray[np.float64] = np.sqrt(np.maximum(squares[is_lit], 0) / energy[is_lit])
    return errors
