"""Training with a prior that knows the geometry of the scene.

The steps, with the prior T0 and direct images X and indirect images Y at norm 1 of the first:

1. The remainder ``Y - X T0`` has its ridge by leave-one-out errors without a basis: T0 comes from
   no pair, so these are exact. They also choose the weights of the direct texels: by their
   indirect light (see `weights.py`), or equal ones where the remainder does not follow the prior,
   as with gloss.
2. The basis comes from the pairs and from virtual lights. With the weights W that the ridge gives
   the pairs, the model predicts ``W Y + (V - W X) T0`` for their direct images V.
3. T0 and the remainder are regressed in the basis. The error for new lights is that without a
   basis, and in squares the part of the pair beyond a basis that was made without it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.words import percent
from envlights._native import EnvLightsError
from envlights.transfer.pairs import Pairs, PairSummary, image_stack, rgb_rows
from envlights.transfer.prior import TransferPrior
from envlights.transfer.report import TransferReport
from envlights.transfer.training import leave_one_out
from envlights.transfer.training.basis import (
    BasisSize,
    Directions,
    basis,
    directions,
    nothing_to_learn,
    outside,
)
from envlights.transfer.training.familiarity import at_norm_1
from envlights.transfer.training.gram import Gram, gram, product
from envlights.transfer.training.ridge import RIDGES, Regression, regression
from envlights.transfer.training.train import Distinct, Training, report_of
from envlights.transfer.training.weights import WeightedRegression, weighted_regression

#: Largest default rank, because the time of a frame grows with the rank.
_MOST_DIRECTIONS = 256
#: Largest truncation error of the default rank, relative to the error for new lights, which it
#: raises by 12 %.
_SHARE = 0.5
#: Approximate default number of virtual lights, which also sets their energy in pairs. Single
#: texels of direct images of 32x32 texels would be spots that no lamp makes: with them the report
#: of the room with 32 pairs stated 7.2 %, where the error for new lights was 4.2 %.
_VIRTUAL_LIGHTS = 256
#: Ridges besides those without a prior. The largest ridge leaves the prior unchanged, for pairs so
#: noisy that training would make it worse.
_RIDGES = (*RIDGES, 10.0, 100.0, 1e4, 1e8)
#: Error of a prior above which a note warns that it does not match the pairs, or that surfaces are
#: not diffuse.
_DOUBTFUL = 0.5


_Solver = TypeVar("_Solver", Regression, WeightedRegression)


class Learning(NamedTuple):
    """Result of training around a prior."""

    training: Training
    transfer: NDArray[np.float64]
    report: TransferReport


class _Remainder(NamedTuple):
    """Regression of the difference between the pairs and a prior, without a basis."""

    solver: WeightedRegression
    ridge: float
    errors: NDArray[np.float64]
    """Leave-one-out error of each pair that is not black."""
    prior_errors: NDArray[np.float64]
    weight: float = 1.0
    """Weight of the training images in the basis."""

    def without_pairs(self) -> _Remainder:
        """Regression that leaves the prior unchanged, with a basis of virtual lights only."""
        # A tiny weight keeps the coefficients of the pairs, but no direction of their noise.
        return self._replace(ridge=_RIDGES[-1], errors=self.prior_errors, weight=1e-3)


def check_prior(
    prior: object, size: tuple[int, int], pairs: Pairs, virtual: ArrayLike | None
) -> NDArray[np.float64]:
    """Direct images of the virtual lights, (n, 3, h * w), after checks against the pairs."""
    if not isinstance(prior, TransferPrior):
        raise EnvLightsError(
            f"prior must be a TransferPrior; got an object of the type {type(prior).__name__}"
        )
    if pairs.is_lazy:
        raise EnvLightsError("prior needs indirect as an array of NumPy; got an array of Dask")
    for name, ours, theirs in (
        ("direct", size, prior.size),
        ("indirect", pairs.indirect.shape[1:3], prior.covered.shape),
    ):
        if tuple(ours) != tuple(theirs):
            given, wanted = ("x".join(map(str, each[::-1])) for each in (ours, theirs))
            raise EnvLightsError(f"{name} must be {wanted} pixels, as in the prior; got {given}")
    if virtual is None:
        return _blocks_alone(pairs.direct, size)
    stack, _ = image_stack("virtual", virtual, size, "prior")
    return at_norm_1(rgb_rows(stack))


def train_around(
    pairs: Pairs,
    prior: TransferPrior,
    virtual: NDArray[np.float64],
    size: BasisSize | None,
    ridge: float | str,
    progress: bool | None,
) -> Learning:
    """Model of the `pairs` and a prior; the errors determine the rank if no `size` is given."""
    own = gram(pairs, centred=False, progress=progress)
    if not own.energy.any():
        raise nothing_to_learn("black")
    rest = _remainder(pairs, prior, own.energy, ridge)
    model = _model_of(rest, pairs, prior, virtual, size, own, progress)
    # Noise of a pair counts twice: with 10 % noise and 4 pairs of the room, a model that reduces
    # the error by 20 % states 1.02 times the error of the prior.
    ours, alone = _medians(model, rest)
    if not isinstance(ridge, str) or ours <= 1.05 * alone:
        return model
    by_prior = _model_of(rest.without_pairs(), pairs, prior, virtual, size, own, progress)
    least, _ = _medians(by_prior, rest)
    if ours <= 1.05 * least:
        return model
    note = (
        f"the prior alone was kept: its median error is {percent(least)}, and that for new"
        f" lights with the pairs {percent(ours)}"
    )
    report = replace(by_prior.report, notes=(*by_prior.report.notes, note))
    return by_prior._replace(report=report)


def _medians(model: Learning, rest: _Remainder) -> tuple[float, float]:
    """Median errors for new lights, of the model and of the prior."""
    return float(np.median(model.report.unseen_errors)), float(np.median(rest.prior_errors))


def _model_of(
    rest: _Remainder,
    pairs: Pairs,
    prior: TransferPrior,
    virtual: NDArray[np.float64],
    size: BasisSize | None,
    own: Gram,
    progress: bool | None,
) -> Learning:
    """Model of a regression: its basis, its matrix, and its errors."""
    every, found = _directions(pairs, prior, virtual, rest)
    # If the basis contains no pairs, their noise must not limit its rank.
    error = _SHARE * float(np.median(rest.errors)) if rest.weight == 1 else None
    limits = size or BasisSize(_MOST_DIRECTIONS, error)
    rank = limits.count(every.values)
    first = every.first(rank)
    columns, mean = basis(*found, first, centred=False, progress=progress)
    # Drop the virtual lights; only the pairs stay.
    k = len(pairs.scale)
    coefficients = first.coefficients[:k] / rest.weight
    outs = outside(found[1].products, first.coefficients)
    learnt = PairSummary(pairs.direct, coefficients, outs[:k] / rest.weight**2, own.energy)
    notes = _notes(rest, pairs, own, every, rank, is_chosen=size is None)
    notes = (*notes, *(limits.missed(every.values, rank) if size else ()))
    training = Training(columns, found[1].lit, mean, learnt, notes)
    prior_mean = _in_basis(prior, columns, found[1].lit)
    seen = product(pairs.direct.swapaxes(0, 1), prior_mean).swapaxes(0, 1)
    left = coefficients - seen
    unseen = np.hypot(rest.errors, _beyond(rest, every, first, outs, own.energy))
    alone = tuple(rest.prior_errors.tolist())
    missed = rest.solver.residual(rest.ridge, left)
    report = report_of(Distinct(learnt, np.arange(k)), rest.ridge, missed, unseen, notes, alone)
    return Learning(training, prior_mean + rest.solver.transfer(rest.ridge, left), report)


def _beyond(
    rest: _Remainder,
    every: Directions,
    first: Directions,
    outs: NDArray[np.float64],
    energy: NDArray[np.float64],
) -> NDArray[np.float64] | float:
    """Relative error of each pair in a basis without it, or of the virtual lights alone."""
    if rest.weight < 1:
        return _truncation(every, len(first.values))
    # Project each pair onto a basis without it; the virtual lights stay in the basis.
    nothing = np.zeros_like(first.coefficients)
    squares = leave_one_out.squares(first.coefficients, outs, nothing)[: len(energy)]
    return leave_one_out.relative(squares, energy)


def _blocks_alone(direct: NDArray[np.float64], size: tuple[int, int]) -> NDArray[np.float64]:
    """Virtual direct-light images, each lighting one block of texels, (blocks, 3, h * w).

    Half of their energy is that of the pairs, the other half is the same for all texels.
    """
    side = ceil(np.sqrt(size[0] * size[1] / _VIRTUAL_LIGHTS))
    row, column = (np.arange(length) // side for length in size)
    block = (row[:, None] * (column[-1] + 1) + column).ravel()
    square = np.mean(direct**2, axis=0)
    square = (square + square.mean(axis=1, keepdims=True)) / 2
    is_lit = np.arange(block[-1] + 1)[:, None] == block
    return np.asarray(is_lit[:, None] * np.sqrt(_VIRTUAL_LIGHTS * square))


def _remainder(
    pairs: Pairs, prior: TransferPrior, energy: NDArray[np.float64], ridge: float | str
) -> _Remainder:
    k = len(pairs.scale)
    identity = np.broadcast_to(np.eye(k), (3, k, k))
    missed = gram(mixtures(pairs, prior, identity, -pairs.direct), centred=False)
    coefficients = _coefficients(missed.products)
    weights = prior.strength, np.ones_like(prior.strength)
    solvers = [weighted_regression(pairs.direct, each) for each in weights]
    ridges = _RIDGES if isinstance(ridge, str) else (ridge,)
    solver, chosen = _best(solvers, ridges, coefficients, energy)
    errors = _left_out(solver, chosen, coefficients, energy)
    is_bright = energy > 0
    alone = np.sqrt(missed.energy[is_bright] / energy[is_bright])
    return _Remainder(solver, chosen, errors, alone)


def _coefficients(products: NDArray[np.float64]) -> NDArray[np.float64]:
    """Coefficients of images along their principal directions, (k, 3, n), from the Gram matrix."""
    energy = float(np.trace(products))
    return directions(products, np.dtype(np.float64), energy).coefficients


def _best(
    solvers: Sequence[_Solver],
    ridges: Sequence[float],
    coefficients: NDArray[np.float64],
    energy: NDArray[np.float64],
) -> tuple[_Solver, float]:
    """Regression and ridge with the least mean leave-one-out error."""

    def error(choice: tuple[_Solver, float]) -> float:
        return float(_left_out(*choice, coefficients, energy).mean())

    return min(((solver, ridge) for solver in solvers for ridge in ridges), key=error)


def _left_out(
    solver: Regression | WeightedRegression,
    ridge: float,
    coefficients: NDArray[np.float64],
    energy: NDArray[np.float64],
) -> NDArray[np.float64]:
    missed = solver.left_out(ridge, coefficients)
    return leave_one_out.relative(np.sum(missed**2, axis=(1, 2)), energy)


def _directions(
    pairs: Pairs, prior: TransferPrior, virtual: NDArray[np.float64], rest: _Remainder
) -> tuple[Directions, tuple[Pairs, Gram]]:
    """Directions of pairs and virtual lights, and both as images with their Gram matrix."""
    weights = rest.solver.shares(rest.ridge, virtual)
    new = virtual - product(weights, pairs.direct.swapaxes(0, 1)).swapaxes(0, 1)
    k = len(pairs.scale)
    identity = np.broadcast_to(rest.weight * np.eye(k), (3, k, k))
    both = mixtures(
        pairs,
        prior,
        np.concatenate([identity, weights], axis=1),
        np.concatenate([np.zeros_like(pairs.direct), new]),
    )
    measured = gram(both, centred=False)
    every = directions(measured.products, pairs.dtype, measured.energy.sum())
    return every, (both, measured)


def _in_basis(
    prior: TransferPrior, columns: NDArray[np.floating], lit: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Matrix of the prior from direct texels to the basis, (3, direct texels, rank)."""
    pixels, rank = prior.visible.size, columns.shape[1]
    received = np.zeros((3, pixels, rank))
    basis = np.zeros((lit.size, rank), np.float32)
    basis[lit.ravel()] = columns
    basis = basis[prior.covered.ravel()]
    for first in range(0, len(basis), 4096):
        some = slice(first, first + 4096)
        factors = prior.factors(some).T
        for channel in range(3):
            reflected = prior.reflectance[some, channel, None] * basis[some]
            received[channel] += product(factors, reflected)
    return product(prior.leaving.swapaxes(1, 2), received)


def _truncation(every: Directions, rank: int) -> float:
    """Relative RMS error of pairs and virtual lights in a basis of the first `rank` directions."""
    return float(np.sqrt(max(1 - every.values[:rank].sum() / every.values.sum(), 0.0)))


def _notes(
    rest: _Remainder, pairs: Pairs, own: Gram, every: Directions, rank: int, is_chosen: bool
) -> tuple[str, ...]:
    """Notes on the rank, and on a prior that does not fit the pairs."""
    notes = []
    if is_chosen:
        fraction = percent(_truncation(every, rank), 2)
        notes.append(
            f"rank {rank}: the basis leaves out {fraction} of new light, where the median"
            f" error without a basis is {percent(np.median(rest.errors), 2)}"
        )
    coefficients = _coefficients(own.products)
    plain = regression(pairs.direct, channelwise=True)
    best = _best([plain], RIDGES, coefficients, own.energy)
    without = np.median(_left_out(*best, coefficients, own.energy))
    ours, alone = np.median(rest.errors), np.median(rest.prior_errors)
    if len(pairs.scale) > 1 and without < ours:
        notes.append(
            f"the prior does not help: the median error for new lights is {percent(ours)} with"
            f" it and {percent(without)} without; fit without it"
        )
    if ours > 1.01 * alone:
        notes.append(
            f"the pairs make the prior worse: the median error for new lights is {percent(ours)}"
            f" with them and {percent(alone)} by the prior alone; give ridge='loo' or more pairs"
        )
    if alone > _DOUBTFUL:
        notes.append(
            f"the prior does not describe the pairs: its own median error is {percent(alone)};"
            " check that scene, units and orientation are those of the pairs, and surfaces diffuse"
        )
    return tuple(notes)


@dataclass(frozen=True, eq=False)
class Mixtures:
    """Weighted sums of images and predictions of a prior; a slice of rows is computed on access."""

    images: NDArray[Any]
    """Indirect images, (k, H, W, 3)."""

    weights: NDArray[np.float64]
    """Weight of each image in each mixture, by channel, (3, n, k)."""

    prior: TransferPrior
    """Prior whose predictions are added to the weighted images."""

    light: NDArray[np.float64]
    """Light that leaves the direct texels in each mixture, (n, 3, h * w)."""

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """Shape of the array that the mixtures stand for, (n, H, W, 3)."""
        _, height, width, _ = self.images.shape
        return len(self.light), height, width, 3

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the computed slices: the type of the images, but at least float32."""
        return np.result_type(self.images.dtype, np.float32)

    def __getitem__(self, key: tuple[slice, slice]) -> NDArray[Any]:
        """Rows of all mixtures as an array; `key`: a full slice, and the slice of rows."""
        where = key[1]
        part = self.images[:, where]
        flat = part.reshape(len(part), -1, 3)
        out = np.empty((len(self.light), flat.shape[1], 3), self.dtype)
        for channel, weights in enumerate(self.weights):
            out[..., channel] = product(weights.astype(self.dtype), flat[..., channel])
        covered = self.prior.covered
        first = int(np.count_nonzero(covered[: where.start]))
        texels = slice(first, first + int(np.count_nonzero(covered[where])))
        out[:, covered[where].ravel()] += self.prior.gathered(self.light, texels)
        return out.reshape(len(out), *part.shape[1:])


def mixtures(
    pairs: Pairs,
    prior: TransferPrior,
    weights: NDArray[np.float64],
    direct: NDArray[np.float64],
) -> Pairs:
    """Weighted sums of scaled images plus predictions of a prior for `direct` light (n, 3, h * w).

    `weights` of the images have the shape (3, n, k).
    """
    sums = Mixtures(pairs.indirect, weights * pairs.scale, prior, prior.bounces(direct))
    return Pairs(direct, sums, np.ones(len(direct)), pairs.notes)
