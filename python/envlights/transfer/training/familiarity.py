"""Residual of direct images that no mixture of the training images explains.

With the direct images X (k, texels) of norm 1, the residual of an image x is

    r = x - X^T (X X^T + ridge I)^-1 X x .

The error of a prediction follows |r| / |x|, which is known before the image. Once the image x is
among the pairs too, the residual of another one, x_j, becomes (Sherman and Morrison 1950)

    r_j - r (x . r_j) / (ridge + x . r) .
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights.transfer.training.gram import product
from envlights.transfer.training.ridge import regression

#: Ridge parameter for direct images of norm 1.
_RIDGE = 1e-3


def residuals(pairs: NDArray[np.float64], direct: NDArray[np.float64]) -> NDArray[np.float64]:
    """Residuals of the `direct` images, (n, 3, texels), after a regression on the `pairs`."""
    solver = regression(pairs, channelwise=True)
    values = solver.regularised_eigenvalues(_RIDGE)[:, None]
    directions = product(solver.vectors.swapaxes(1, 2), solver.features)
    images = direct.swapaxes(0, 1)
    explained = product(product(images, directions.swapaxes(1, 2)) / values, directions)
    left: NDArray[np.float64] = direct - explained.swapaxes(0, 1)
    return left


def unfamiliarity(pairs: NDArray[np.float64], direct: NDArray[np.float64]) -> NDArray[np.float64]:
    """Norm of the residual relative to the norm of each image, (n,); 0 for black images."""
    sizes: NDArray[np.float64] = np.linalg.norm(residuals(pairs, at_norm_1(direct)), axis=(1, 2))
    return sizes


def most_unfamiliar(
    pairs: NDArray[np.float64], direct: NDArray[np.float64], count: int
) -> NDArray[np.int64]:
    """Indices of images, (count,), each the most unfamiliar after the previous choices."""
    images = at_norm_1(direct)
    left = residuals(pairs, images)
    chosen: list[int] = []
    for _ in range(count):
        sizes = np.linalg.norm(left, axis=(1, 2))
        sizes[chosen] = -1.0
        best = int(np.argmax(sizes))
        chosen.append(best)
        # Remove the chosen image from all residuals, channel by channel.
        weights = np.einsum("cs,ncs->nc", images[best], left)
        weights /= _RIDGE + weights[best]
        left = left - weights[..., None] * left[best]
    return np.array(chosen, np.int64)


def at_norm_1(direct: NDArray[np.float64]) -> NDArray[np.float64]:
    """Images (n, 3, texels) scaled to norm 1; black images stay black."""
    norm = np.linalg.norm(direct, axis=(1, 2), keepdims=True)
    scaled: NDArray[np.float64] = np.divide(direct, norm, out=np.zeros_like(direct), where=norm > 0)
    return scaled
