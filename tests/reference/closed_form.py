"""The fit at infinitely many normals: every sum over normals is an integral with a closed form.

For unit vectors a and b at the angle g, over all unit normals n,

    int max(0, n.a) max(0, n.b) dn = 2/3 (sin g + (pi - g) cos g)
    int max(0, n.a) dn = pi           int dn = 4 pi

so a world of point sources and a constant ambient term is fitted without any normal. Slow and
plain: radiances by scipy's NNLS, directions by its BFGS.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize, nnls


def overlap(a, b):
    """Integrals of the products of the lobes of `a`, (m, 3), and `b`, (n, 3)."""
    cosine = np.clip(a @ b.T, -1, 1)
    angle = np.arccos(cosine)
    return 2 / 3 * (np.sin(angle) + (np.pi - angle) * cosine)


def slope(a, b):
    """Derivative of `overlap` by the cosine."""
    return 2 / 3 * (np.pi - np.arccos(np.clip(a @ b.T, -1, 1)))


class World(NamedTuple):
    """Point sources before a constant environment."""

    direction: np.ndarray
    irradiance: np.ndarray
    ambient: np.ndarray

    def probe(self, normals):
        return np.pi * self.ambient + np.maximum(normals @ self.direction.T, 0) @ self.irradiance


def products(one, two):
    """Integral of the product of two worlds' irradiance, over all channels."""
    ambient = 4 * np.pi**3 * one.ambient @ two.ambient
    mixed = np.pi**2 * (one.ambient @ two.irradiance.sum(0) + two.ambient @ one.irradiance.sum(0))
    lobes = overlap(one.direction, two.direction)
    return ambient + mixed + np.sum(lobes * (one.irradiance @ two.irradiance.T))


def cost(rig, world):
    """Integral of the squared difference of two worlds, over that of the second."""
    energy = products(world, world)
    return (products(rig, rig) - 2 * products(rig, world) + energy) / energy


def best_radiances(world, directions):
    """The rig with lights in these directions that is nearest to `world`, none negative."""
    count = len(directions)
    gram = np.full((count + 1, count + 1), np.pi**2)
    gram[0, 0], gram[1:, 1:] = 4 * np.pi**3, overlap(directions, directions)
    rhs = np.empty((count + 1, 3))
    rhs[0] = 4 * np.pi**3 * world.ambient + np.pi**2 * world.irradiance.sum(axis=0)
    rhs[1:] = np.pi**2 * world.ambient + overlap(directions, world.direction) @ world.irradiance
    factor = np.linalg.cholesky(gram)
    # |L^T x - L^-1 b| is the cost, but for a constant.
    x = np.stack([nnls(factor.T, np.linalg.solve(factor, b))[0] for b in rhs.T], axis=1)
    return World(directions, x[1:], x[0])


def cost_and_gradient(flat, world):
    """`cost` with the best radiances, and its gradient by the directions."""
    vectors = flat.reshape(-1, 3)
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    rig = best_radiances(world, vectors / length)
    # At the best radiances, their change adds nothing to the gradient.
    towards_rig = slope(rig.direction, rig.direction) * (rig.irradiance @ rig.irradiance.T)
    towards_world = slope(rig.direction, world.direction) * (rig.irradiance @ world.irradiance.T)
    gradient = 2 * (towards_rig @ rig.direction - towards_world @ world.direction)
    along = (gradient * rig.direction).sum(axis=1, keepdims=True)
    across = (gradient - along * rig.direction) / length / products(world, world)
    return cost(rig, world), across.ravel()


def fit(world, start):
    """The best rig near lights in the directions `start`, and its cost."""
    tight = {"gtol": 1e-10, "maxiter": 500}
    given = start.ravel(), (world,), "BFGS"
    found = minimize(cost_and_gradient, *given, jac=True, options=tight)
    directions = found.x.reshape(-1, 3)
    rig = best_radiances(world, directions / np.linalg.norm(directions, axis=1, keepdims=True))
    return rig, found.fun
