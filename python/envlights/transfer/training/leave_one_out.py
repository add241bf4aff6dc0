"""Leave-one-out errors in closed form, for lights outside the training pairs.

A basis adapts to every image that it was made of. Without the image `i`, whose rows are
A_i (3, rank) inside the basis and R_i = (3, 3) in products outside of it, one step of orthogonal
iteration rotates the basis back. With

    H = A_i S^-2 A_i^T    the leverage of the image,
    N = A_i S^-4 A_i^T,
    R' = (I - H)^-1 R_i (I - H)^-1,

the rotated basis misses the energy  tr Q,  Q = R' (I + N R')^-1,  of the image. Coefficients that
are wrong by e_i add |e_i|^2, less the part in the directions that were rotated away:

    error_i^2 = |e_i|^2 + tr Q (I - Z Z^T),    Z = A_i S^-2 e_i^T .
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def squares(
    coefficients: NDArray[np.float64],
    outside: NDArray[np.float64],
    missed: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Squared leave-one-out error of each image, (k,).

    Parameters
    ----------
    coefficients : ndarray, shape (k, 3, rank)
        Of the images in the basis.
    outside : ndarray, shape (k, 3, 3)
        Inner products of the residuals of the three rows of each image.
    missed : ndarray, shape (k, 3, rank)
        Coefficients less what a regression without their image gives.
    """
    turned, leaning = _rotate(coefficients, outside)
    seen = leaning @ missed.swapaxes(1, 2)
    inside = np.einsum("kcr,kcr->k", missed, missed)
    lost = np.einsum("kij,kji->k", turned, np.eye(3) - seen @ seen.swapaxes(1, 2))
    result: NDArray[np.float64] = np.maximum(inside + lost, 0)
    return result


def relative(squares: NDArray[np.float64], energy: NDArray[np.float64]) -> NDArray[np.float64]:
    """Relative error of each image that is not black, from its squared error."""
    is_bright = energy > 0
    return np.asarray(np.sqrt(np.maximum(squares[is_bright], 0) / energy[is_bright]))


def _rotate(
    coefficients: NDArray[np.float64], outside: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Matrices `Q` and ``A S^-2`` of the module docstring."""
    energy = np.einsum("kcr,kcr->r", coefficients, coefficients)
    leaning = coefficients / energy
    # A direction that occurs in only one image (leverage 1) is removed completely, towards the
    # smallest component of the image outside the basis.
    whole = np.einsum("kcr,kcr->k", coefficients, coefficients)[:, None, None]
    least = 1e-9 * np.eye(3)
    free = np.linalg.inv((1 + 1e-9) * np.eye(3) - leaning @ coefficients.swapaxes(1, 2))
    back = free @ (outside + least**2 * whole) @ free
    turned = back @ np.linalg.inv(np.eye(3) + leaning @ leaning.swapaxes(1, 2) @ back)
    return turned, leaning
