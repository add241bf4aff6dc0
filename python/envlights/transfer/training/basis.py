"""Directions that hold most of the energy of the indirect images.

With the eigensystem of G = Y Y^T = V S^2 V^T, the columns of

    B = Y^T V S^-1

are orthonormal already, and the coefficients of the images in them are V S. This needs no QR, and
the images are not read again for the coefficients.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._common.check import amount, check_choice, count, flag
from envlights._native import EnvLightsError
from envlights.transfer.pairs import Pairs
from envlights.transfer.training.gram import (
    Gram,
    eigensystem,
    is_for_kernels,
    parts,
    product,
    texel_rows,
)

#: Ends of the notes of `BasisSize.missed`.
FEW, MISSED = "directions above rounding", "was not reached; allow a higher rank"


@dataclass(frozen=True)
class BasisSize:
    """Limits on the number of directions in a basis."""

    rank: int | float
    """Largest number of directions (int), or fraction of the energy to keep (float)."""

    error: float | None
    """Largest accepted relative RMS error of the images in the basis."""

    @classmethod
    def checked(cls, rank: object, error: object) -> BasisSize:
        """Limits from the arguments of a user; raises an error for invalid ones."""
        bound = None if error is None else amount("error", error)
        if not isinstance(rank, float | np.floating):
            return cls(count("rank", rank, least=1), bound)
        fraction = amount("rank as a share of the energy", float(rank), most=1.0)
        if fraction == 0:
            raise EnvLightsError("rank as a share of the energy must be more than 0; got 0.0")
        return cls(fraction, bound)

    def missed(self, values: NDArray[np.float64], rank: int, lost: float = 0.0) -> tuple[str, ...]:
        """Notes if the directions are fewer, or the error larger, than requested.

        `lost`: energy of the images that is in none of the directions.
        """
        notes = []
        if len(values) < self.rank:
            notes.append(f"the images have no more than {len(values)} {FEW}")
        residual = np.sqrt(max(1 - values[:rank].sum() / (values.sum() + lost), 0.0))
        if self.error is not None and residual > self.error:
            notes.append(f"the error {self.error:g} {MISSED}")
        return tuple(notes)

    def count(self, values: NDArray[np.float64]) -> int:
        """Smallest sufficient number of directions; `values`: energy in each, largest first."""
        energy = np.cumsum(values)
        most = len(values)
        if isinstance(self.rank, float):
            # Allow for rounding, so that a fraction of 1.0 means all of the energy.
            enough = self.rank * energy[-1] * (1 - 1e-12)
            most = min(int(np.searchsorted(energy, enough)) + 1, most)
        else:
            most = min(most, self.rank)
        if self.error is not None:
            residual = np.sqrt(np.maximum(1 - energy / energy[-1], 0))
            reached = np.flatnonzero(residual[:most] <= self.error)
            most = int(reached[0]) + 1 if len(reached) else most
        return most


def check_parameters(
    rank: object,
    ridge: object,
    error: object,
    nonnegative: object = False,
    prior: object = False,
) -> BasisSize:
    """Check the parameters of `TransferModel.fit`."""
    if isinstance(ridge, str):
        check_choice("ridge", ridge, ("loo",))
    else:
        amount("ridge", ridge)
    flag("nonnegative", nonnegative)
    flag("prior", prior)
    return BasisSize.checked(rank, error)


@dataclass(frozen=True, eq=False)
class Directions:
    """Eigenvectors of the Gram matrix, in descending order of energy."""

    values: NDArray[np.float64]
    """Energy in each direction, (n,)."""

    vectors: NDArray[np.float64]
    """Weight of each image channel in each direction, (3 k, n)."""

    @property
    def coefficients(self) -> NDArray[np.float64]:
        """Coefficients of the images in the directions, (k, 3, n)."""
        images = len(self.vectors) // 3
        return (self.vectors * np.sqrt(self.values)).reshape(images, 3, len(self.values))

    def first(self, rank: int) -> Directions:
        """The first `rank` directions."""
        return Directions(self.values[:rank], self.vectors[:, :rank])


def nothing_to_learn(what: str) -> EnvLightsError:
    """Error for indirect images without any direction."""
    return EnvLightsError(f"indirect is {what} in every image; there is nothing to learn")


def directions(products: NDArray[np.float64], dtype: np.dtype[Any], energy: float) -> Directions:
    """Directions with more energy than the rounding of `dtype` adds to images of this `energy`."""
    values, vectors = eigensystem(products)
    values, vectors = values[::-1], vectors[:, ::-1]
    is_real = values > 8 * np.finfo(dtype).eps * energy
    return Directions(values[is_real], vectors[:, is_real])


def outside(
    products: NDArray[np.float64], coefficients: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Inner products of the residuals of the three colour channels of each image, (k, 3, 3)."""
    k = np.arange(len(coefficients))
    own: NDArray[np.float64] = products.reshape(len(k), 3, len(k), 3)[k, :, k]
    return own - coefficients @ coefficients.swapaxes(1, 2)


def basis(
    pairs: Pairs,
    measured: Gram,
    first: Directions,
    centred: bool,
    progress: bool | None = False,
) -> tuple[Any, Any]:
    """Orthonormal columns over the lit texels, (lit texels, rank), and the mean image there.

    The values of one texel are adjacent: a frame reads them twice as fast as columns.
    """
    weights = first.vectors / np.sqrt(first.values)
    if centred:
        # Append the mean as another mixture; the weights of all other mixtures add up to 0.
        weights = np.column_stack([weights, np.full(len(weights), 1 / len(weights))])
    # Fill the rows of the basis, one part of the texels at a time.
    columns = np.empty((np.count_nonzero(measured.lit), weights.shape[1]), pairs.dtype)
    end = 0
    # Overflow of the mean raises an error below.
    with np.errstate(over="ignore", invalid="ignore"):
        for where, part in parts(pairs, progress):
            mixed = mixtures(pairs, part, measured.lit[where], weights)
            begin, end = end, end + len(mixed)
            columns[begin:end] = mixed
    if centred:
        if not np.isfinite(columns).all():
            raise EnvLightsError(
                f"the mean of indirect at direct light of norm 1 overflows {pairs.dtype}; scale the"
                " images or give float64"
            )
        return np.ascontiguousarray(columns[:, :-1]), columns[:, -1].copy()
    return columns, np.zeros(0, pairs.dtype)


def mixtures(
    pairs: Pairs, part: NDArray[Any], lit: NDArray[np.bool_], weights: NDArray[np.float64]
) -> NDArray[Any]:
    """Mixtures of all images in the lit texels of one part, (lit texels, rank)."""
    # Direct light of 1e30 with indirect light of 1e-31 has weights beyond float32. A power of two,
    # which causes no rounding, is moved from the weights to the scale.
    unit = np.ldexp(1.0, np.frexp(np.abs(weights).max(initial=0))[1])
    scale, shares = (pairs.scale * unit).astype(part.dtype), (weights / unit).astype(part.dtype)
    if is_for_kernels(pairs):
        return _native.transfer_columns(part, scale, lit.ravel(), shares)
    return product(texel_rows(part[:, lit.ravel()], scale), shares)
