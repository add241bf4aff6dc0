"""Images that are sums of indirect images of pairs and of predictions of a prior.

They are computed part by part, so that many of them need no memory.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights.transfer.pairs import Pairs
from envlights.transfer.prior import TransferPrior
from envlights.transfer.training.gram import product


@dataclass(frozen=True, eq=False)
class Mixtures:
    """Sums of images at one scale; slices of rows of all of them are arrays."""

    images: NDArray[Any]
    """Indirect images, (k, H, W, 3)."""

    weights: NDArray[np.float64]
    """Weight of each image in each mixture, by channel, (3, n, k)."""

    prior: TransferPrior
    """Prior that predicts the rest."""

    light: NDArray[np.float64]
    """Light that leaves the direct texels in each mixture, (n, 3, h * w)."""

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """Shape as an array."""
        _, height, width, _ = self.images.shape
        return len(self.light), height, width, 3

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the slices: that of the images, and at least float32."""
        return np.result_type(self.images.dtype, np.float32)

    def __getitem__(self, key: tuple[slice, slice]) -> NDArray[Any]:
        """Some rows of all mixtures; `key`: all mixtures, and the slice of rows."""
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
    """Sums of scaled images and of predictions of a prior for `direct` light (n, 3, h * w).

    `weights` of the images have the shape (3, n, k).
    """
    sums = Mixtures(pairs.indirect, weights * pairs.scale, prior, prior.bounces(direct))
    return Pairs(direct, sums, np.ones(len(direct)), pairs.notes)
