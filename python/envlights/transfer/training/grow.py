"""Addition of pairs to a trained model without training from scratch.

The basis `B` and the coefficients `A` represent the earlier pairs. New rows `Z` have the
coefficients `C = Z B` in it and the residual `E = Z - C B^T`, whose inner products are
``Z Z^T - C C^T = U D^2 U^T``: so ``Q = E^T U D^-1`` is orthonormal and at right angles to `B`. All
rows together are

    [A  0  ]
    [C  U D] [B Q]^T

and the directions of the small matrix on the left rotate [B Q] into the new basis (sequential
Karhunen-Loeve; Levy and Lindenbaum 2000).
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights.transfer.pairs import Pairs, PairSummary
from envlights.transfer.training.basis import (
    FEW,
    MISSED,
    BasisSize,
    Directions,
    directions,
    mixtures,
)
from envlights.transfer.training.gram import eigensystem, gram, parts, product, texel_rows


def extend(
    basis: NDArray[Any], lit: NDArray[np.bool_], learnt: PairSummary, pairs: Pairs, size: BasisSize
) -> tuple[NDArray[Any], NDArray[np.bool_], PairSummary, NDArray[np.float64]]:
    """Basis, lit texels, summary, and energy by direction after the addition of `pairs`."""
    new = gram(pairs, centred=False)
    inside = _inside(basis, lit, pairs)
    residual = directions(new.products - product(inside, inside.T), pairs.dtype, new.energy.sum())
    old = learnt.coefficients.reshape(-1, basis.shape[1])
    rows = np.block(
        [
            [old, np.zeros((len(old), len(residual.values)))],
            [inside, residual.vectors * np.sqrt(residual.values)],
        ]
    )
    values, turn = eigensystem(product(rows.T, rows))
    values, turn = values[::-1], turn[:, ::-1]
    real = values[values > values[0] * np.finfo(pairs.dtype).eps]
    rank = size.count(real)
    coefficients = product(rows, turn[:, :rank]).reshape(-1, 3, rank)
    together = replace(
        learnt,
        direct=np.concatenate([learnt.direct, pairs.direct]),
        coefficients=coefficients,
        outside=_outside(learnt, rows, coefficients),
        energy=np.concatenate([learnt.energy, new.energy]),
    )
    union = lit | new.lit
    columns = _rotate(basis, lit, union, pairs, (inside, residual, turn[:, :rank]))
    return columns, union, together, real


def noting_missed(
    notes: tuple[str, ...],
    size: BasisSize,
    values: NDArray[np.float64],
    rank: int,
    before: PairSummary,
) -> tuple[str, ...]:
    """Notes, with those of `BasisSize.missed` replaced by the current ones.

    `before`: the pairs of the earlier model.
    """
    # What an earlier basis left out stays lost; it is noted where that basis missed the error.
    was_missed = any(note.endswith(MISSED) for note in notes)
    lost = float(np.trace(before.outside, axis1=1, axis2=2).sum()) if was_missed else 0.0
    # A basis that an error has cut does not tell how many directions its images had.
    known = MISSED if size.error is not None else (FEW, MISSED)
    missed = (note for note in size.missed(values, rank, lost) if note.endswith(known))
    return (*(note for note in notes if not note.endswith((FEW, MISSED))), *missed)


def _inside(basis: NDArray[Any], lit: NDArray[np.bool_], pairs: Pairs) -> NDArray[np.float64]:
    """Coefficients of the new images in the old basis, (3 n, rank)."""
    inside = np.zeros((3 * len(pairs.scale), basis.shape[1]))
    end = 0
    scale = pairs.scale.astype(pairs.dtype)
    for where, part in parts(pairs):
        block = texel_rows(part[:, lit[where].ravel()], scale)
        begin, end = end, end + len(block)
        inside += block.T @ basis[begin:end]
    return inside


def _outside(
    learnt: PairSummary, rows: NDArray[np.float64], coefficients: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Inner products of the residuals of all images in the new basis, (k, 3, 3)."""
    rows = rows.reshape(len(coefficients), 3, -1)
    outside: NDArray[np.float64] = rows @ rows.swapaxes(1, 2)
    outside -= coefficients @ coefficients.swapaxes(1, 2)
    outside[: len(learnt.outside)] += learnt.outside
    return outside


def _rotate(
    basis: NDArray[Any],
    lit: NDArray[np.bool_],
    union: NDArray[np.bool_],
    pairs: Pairs,
    rotation: tuple[NDArray[np.float64], Directions, NDArray[np.float64]],
) -> NDArray[Any]:
    """New basis over the texels that are lit in old or new images."""
    inside, residual, turn = rotation
    rank = basis.shape[1]
    from_new = residual.vectors / np.sqrt(residual.values) @ turn[rank:]
    from_old = (turn[:rank] - inside.T @ from_new).astype(basis.dtype)
    out = np.empty((np.count_nonzero(union), from_old.shape[1]), basis.dtype)
    end = old_end = 0
    for where, part in parts(pairs):
        ours = union[where]
        block = mixtures(pairs, part, ours, from_new).astype(basis.dtype, copy=False)
        old_begin, old_end = old_end, old_end + int(np.count_nonzero(lit[where]))
        block[lit[where][ours]] += basis[old_begin:old_end] @ from_old
        begin, end = end, end + len(block)
        out[begin:end] = block
    return out
