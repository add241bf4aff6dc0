"""Loss between two sets of lights of different sizes, by optimal transport."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._native import EnvLightsError
from envlights.kernels.image import LUMINANCE
from envlights.layers.arrays import Array, on_host
from envlights.layers.lights import Lights, check_lights


def matching_loss(lights: Lights, target: Lights) -> Array:
    r"""Difference between lights and a target, (...), of any number and order; 0 if equal.

    The ambient term does not count. `el.comparison.compare_lights` reports angles of the same plan.

    Notes
    -----
    The plan :math:`p_{ij}` moves the luminance of the lights to that of the target at the least
    mean angle (Peyré and Cuturi 2019, equation 2.11), on the CPU; derivatives hold it constant.
    It assigns :math:`T_i = \sum_j p_{ij} T_j / \sum_k p_{kj}` of the target to each light:

    .. math:: \sum_{ij} p_{ij} (|l_i - l_j|^2 + (a_i - a_j)^2)
              + \sum_i |E_i - T_i|^2 / \textstyle\sum_i (|E_i|^2 + |T_i|^2) .

    Examples
    --------
    >>> arrays = [[0.0, 1.0, 0.0]], [[2.0, 2.0, 2.0]], [0.1], [0.0, 0.0, 0.0]
    >>> one = Lights(*map(np.array, arrays))
    >>> float(matching_loss(one._replace(irradiance=one.irradiance / 2), one))
    0.2
    """
    (xp, lights), (_, target) = check_lights(lights), check_lights(target)
    *batch, n, _ = lights.direction.shape
    *other, m, _ = target.direction.shape
    if batch != other:
        raise EnvLightsError(f"target must have the leading axes {batch} of lights; got {other}")
    plan = on_host(_plans, (*batch, n, m), *lights[:2], *target[:2])
    away = lights.direction[..., :, None, :] - target.direction[..., None, :, :]
    wider = lights.angular_radius[..., :, None] - target.angular_radius[..., None, :]
    moved = xp.sum(plan * (xp.sum(away * away, axis=-1) + wider * wider), axis=(-2, -1))
    whole = xp.sum(plan, axis=-2, keepdims=True)
    assigned = xp.matmul(plan / xp.where(whole > 0, whole, 1.0), target.irradiance)
    square = xp.sum(lights.irradiance**2 + assigned * assigned, axis=(-2, -1))
    change = xp.sum((lights.irradiance - assigned) ** 2, axis=(-2, -1))
    return moved + change / xp.where(square > 0, square, 1.0)


def _plans(*arrays: NDArray[Any]) -> NDArray[np.float64]:
    """Transport plan for each row of a batch, (..., n, m); 0 if either set is black."""
    one, light, other, other_light = (each.astype(np.float64) for each in arrays)
    out = np.zeros((*one.shape[:-1], other.shape[-2]))
    for row in np.ndindex(one.shape[:-2]):
        weights = [np.maximum(each[row] @ LUMINANCE, 0) for each in (light, other_light)]
        rows, columns = map(np.flatnonzero, weights)
        if len(rows) and len(columns):
            sets = (one[row][rows], weights[0][rows], other[row][columns], weights[1][columns])
            for directions in sets[::2]:
                directions /= np.linalg.norm(directions, axis=1, keepdims=True)
            _, pairs, fractions = _native.transport_plan(*sets)
            out[row][rows[pairs[:, 0]], columns[pairs[:, 1]]] = fractions
    return out
