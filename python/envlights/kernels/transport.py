"""Optimal transport between two sets of weighted directions."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native
from envlights._common.check import reals


def transport_plan(
    from_directions: ArrayLike,
    from_weights: ArrayLike,
    to_directions: ArrayLike,
    to_weights: ArrayLike,
) -> tuple[float, NDArray[np.int64], NDArray[np.float64]]:
    r"""Optimal transport plan between two sets of directions, with the smallest mean angle.

    The weights of either set are divided by their sum. The result is exact: all weight is moved,
    split where that is cheaper, and no other plan has a smaller mean angle. Of several such plans,
    it is one with the least mean square angle.

    Parameters
    ----------
    from_directions : array_like, shape (n, 3)
        Unit vectors.
    from_weights : array_like, shape (n,)
        Finite and not negative, one of them above 0.
    to_directions : array_like, shape (m, 3)
        Unit vectors.
    to_weights : array_like, shape (m,)
        Finite and not negative, one of them above 0.

    Returns
    -------
    mean_angle : float
        Mean angle of the movement in radians: the Wasserstein distance W1.
    pairs : ndarray of int64, shape (k, 2)
        Rows of both sets, in rising order; at most n + m - 1 pairs.
    shares : ndarray, shape (k,)
        Fraction of the weight that moves between each pair, above 1e-14. Smaller ones are left out.

    Raises
    ------
    EnvLightsError
        If a shape is wrong, a vector has another length than 1, a weight is negative or not finite,
        or all weights of a set are 0.

    Notes
    -----
    With the shares :math:`p_{ij}` and the angles :math:`\alpha_{ij}`, it is the least
    :math:`\sum_{ij} p_{ij} \alpha_{ij}` under :math:`\sum_j p_{ij} = a_i`,
    :math:`\sum_i p_{ij} = b_j` and :math:`p_{ij} \ge 0` (Peyré and Cuturi 2019, "Computational
    Optimal Transport", equation 2.11), solved by the simplex method (Dantzig 1951,
    "Application of the simplex method to a transportation problem").

    Examples
    --------
    Half of the light moves by a quarter turn:

    >>> angle, pairs, shares = transport_plan([[0, 1, 0]], [5], [[0, 1, 0], [1, 0, 0]], [1, 1])
    >>> round(angle / np.pi, 6), pairs.tolist(), shares.tolist()
    (0.25, [[0, 0], [0, 1]], [0.5, 0.5])
    """
    return _native.transport_plan(
        reals("from_directions", from_directions, 2),
        reals("from_weights", from_weights, 1),
        reals("to_directions", to_directions, 2),
        reals("to_weights", to_weights, 1),
    )
