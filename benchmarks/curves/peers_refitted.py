"""Other ways to an ambient term and a few lights, with the probe of a fit and its bounds.

Radiances are linear in the irradiance, so each peer has the best ones that are not negative
(Lawson and Hanson 1974, through SciPy), at the 320 normals of the fit.
"""

from functools import cache
from types import SimpleNamespace

import numpy as np
from curves.errors_of_rigs import Surroundings
from curves.peers_of_lights import k_means, median_cut, solve
from scipy.optimize import least_squares, nnls
from scipy.special import eval_legendre, ive
from tests.helpers import NORMALS, SOLID_ANGLES
from tests.reference import peers

import envlights as el
from envlights import kernels

#: Columns of the map that a fit works on.
_COLUMNS = 256
#: Radii at which discs start and end, in radians.
_FIRST, _LEAST, _LARGEST = 0.1, 0.005, 1.5
#: Sharpness of spherical Gaussians, as its logarithm: at the start, at least and at most.
_SHARPNESS = (np.log(20.0), np.log(0.5), np.log(1e4))
#: Degrees of the harmonics of a lobe; all odd ones above 1 vanish.
_DEGREES = np.array([0, 1, *range(2, 41, 2)])
#: Relative change at which a generic optimiser stops.
_TOLERANCE = 1e-6


def k_means_refitted(radiance, count):
    """Directions by k-means; ambient term and radiances by least squares."""
    return _refit(radiance, k_means(radiance, count).lights.direction)


def median_cut_refitted(radiance, count):
    """Directions by median cut; ambient term and radiances by least squares."""
    return _refit(radiance, median_cut(radiance, count).lights.direction)


def _refit(radiance, directions):
    radii = np.zeros(len(directions))
    solution = _solution(_disc_columns(directions, radii), working_probe(radiance))
    return _rig(directions, solution, radii)


def working_probe(radiance):
    """Irradiance at the normals of the fit, from the map that a fit works on."""
    return kernels.working_irradiance(radiance, NORMALS, columns=_COLUMNS)[0]


def discs_by_scipy(radiance, count):
    """Discs by SciPy's least squares with numerical derivatives, from the clusters of k-means."""
    probe, start = working_probe(radiance), k_means(radiance, count).lights.direction

    def columns(x):
        directions, radii = _shapes(start, x)
        return _disc_columns(directions, radii)

    x = _descend(columns, probe, len(start), (_FIRST, _LEAST, _LARGEST))
    directions, radii = _shapes(start, x)
    return _rig(directions, _solution(columns(x), probe), radii)


def gaussians_by_scipy(radiance, count):
    """Spherical Gaussians and an even ambient term, fitted as the discs are."""
    probe, start = working_probe(radiance), k_means(radiance, count).lights.direction

    def columns(x):
        axes, logarithms = _shapes(start, x)
        return _lobe_columns(NORMALS, axes, np.exp(logarithms))

    x = _descend(columns, probe, len(start), _SHARPNESS)
    axes, logarithms = _shapes(start, x)
    return _lobes(axes, np.exp(logarithms), _solution(columns(x), probe))


def _descend(columns, probe, count, size):
    """Turn and resize the lights; each step has the best radiances (variable projection)."""
    root = np.sqrt(SOLID_ANGLES)[:, None]
    first, least, largest = size
    scale = np.linalg.norm(root * probe)

    def residual(x):
        basis = columns(x)
        return (root * (basis @ _solution(basis, probe) - probe)).ravel() / scale

    start = np.tile([0.0, 0.0, first], (count, 1)).ravel()
    low = np.tile([-np.inf, -np.inf, least], count)
    high = np.tile([np.inf, np.inf, largest], count)
    stop = dict.fromkeys(("ftol", "xtol", "gtol"), _TOLERANCE)
    return least_squares(residual, start, bounds=(low, high), x_scale="jac", **stop).x


def _shapes(start, x):
    """Directions and sizes: two tangential displacements and a size for each start."""
    across, along, size = x.reshape(-1, 3).T
    pole = np.where(np.abs(start[:, 1:2]) < 0.9, [[0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0]])
    one = np.cross(pole, start)
    one /= np.linalg.norm(one, axis=1, keepdims=True)
    moved = start + across[:, None] * one + along[:, None] * np.cross(start, one)
    return moved / np.linalg.norm(moved, axis=1, keepdims=True), size


def _solution(columns, probe):
    """Ambient radiance and strengths that are not negative, for each channel, (1 + n, 3)."""
    root = np.sqrt(SOLID_ANGLES)[:, None]
    return np.stack([nnls(root * columns, root[:, 0] * each)[0] for each in probe.T], axis=1)


def _disc_columns(directions, radii):
    """Irradiance of an ambient radiance of 1, and of discs of irradiance 1 at normal incidence."""
    lights = zip(directions, radii, strict=True)
    none, one = np.zeros(3), np.ones((1, 3))
    columns = [
        kernels.rig_irradiance(NORMALS, none, direction[None], one, np.array([radius]))[:, 0]
        for direction, radius in lights
    ]
    return np.stack([np.full(len(NORMALS), np.pi), *columns], axis=1)


def _rig(directions, solution, radii):
    lit = (solution[1:] > 0).any(axis=1)
    lights = el.Lights(directions[lit], solution[1:][lit], radii[lit])
    return SimpleNamespace(lights=lights, ambient=solution[0])


def _lobe_columns(normals, axes, sharpness):
    """Irradiance of an ambient radiance of 1, and of lobes of amplitude 1.

    A lobe is a zonal function, and the clamped cosine turns it into another: the coefficient of
    each degree is multiplied by that of the cosine (Ramamoorthi and Hanrahan 2001).
    """
    cosines = normals @ axes.T
    terms = eval_legendre(_DEGREES, cosines[..., None]) * (2 * _DEGREES + 1) / (4 * np.pi)
    bessel = np.sqrt(np.pi / (2 * sharpness[:, None])) * ive(_DEGREES + 0.5, sharpness[:, None])
    irradiance = (terms * 4 * np.pi * bessel * _clamped_cosine()).sum(axis=-1)
    return np.concatenate([np.full((len(normals), 1), np.pi), irradiance], axis=1)


@cache
def _clamped_cosine():
    """Factor of the clamped cosine for each of the degrees, by quadrature on the half sphere."""
    nodes, weights = np.polynomial.legendre.leggauss(64)
    cosine = (nodes + 1) / 2
    return np.pi * eval_legendre(_DEGREES[:, None], cosine) @ (weights * cosine)


def _lobes(axes, sharpness, solution):
    """A rig without lights whose surroundings hold the lobes and the ambient term."""

    def radiance(at):
        return solution[0] + np.exp(sharpness * (at @ axes.T - 1)) @ solution[1:]

    return SimpleNamespace(
        lights=el.Lights(np.zeros((0, 3)), np.zeros((0, 3))),
        ambient=Surroundings(radiance, lambda at: _lobe_columns(at, axes, sharpness) @ solution),
    )


def points_by_scipy(radiance, count):
    """SciPy's bounded least squares on the paper's equations, from an even start."""
    return solve(
        working_probe(radiance),
        count,
        lambda problem, start: peers.by_scipy(problem, start, has_bounds=True, tolerance=1e-8),
    )


def points_by_jaxopt(radiance, count):
    """JAXopt's Levenberg-Marquardt from the same start, with radiances as squares."""
    return solve(
        working_probe(radiance),
        count,
        lambda problem, start: peers.by_jaxopt(problem, start, 1e-8, has_bounds=True),
    )
