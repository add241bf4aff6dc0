"""Errors of lights under a map as losses, equal to the relative errors that `el.fit` reports."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from envlights import _native
from envlights._common.check import check_choice, count
from envlights.environment.reading import AnyMap, as_envmap
from envlights.fitting.reduction import reduction_of
from envlights.kernels import gloss
from envlights.layers.arrays import Array, constant
from envlights.layers.lights import Lights, check_lights, spread_and_flux
from envlights.layers.products import expand_lights, mean_distances

#: Weights of the probe and shadow objectives; the weights of "mixed" are in `fit/settings.rs`.
KINDS = {"shadows": (0.0, 1.0), "probe": (1.0, 0.0), "mixed": (0.973, 0.027)}


class MapTerms(NamedTuple):
    """Arrays of a map: harmonics of its dim cells, and its bright parts as discs."""

    dull: Array
    """Coefficients of the dim cells, (order, degree, 6), as in `kernels.expand_map`."""
    bright: Array
    """Coefficients of the bright parts, with the same shape."""
    fine: Array
    """Integral of the squared radiance that the coefficients of dim cells omit, (3,)."""
    direction: Array
    """Unit vectors to the bright parts, (p, 3)."""
    flux: Array
    """Integral of the radiance of each bright part, (p, 3)."""
    spread: Array
    """Disc extent of each bright part, sin^2(a/2) for a disc of radius a, (p,)."""
    distances: Array
    """Sum over pairs of bright parts of mean distance times both fluxes, (3,)."""


def map_terms(env: AnyMap, degree: int = 40) -> MapTerms:
    """Arrays of a map for `lighting_error` and `gloss_error`, by the kernels of `el.fit`.

    Parameters
    ----------
    env : EnvMap, array_like or path
        Parts that it does not show are filled as by `el.fit`.
    degree : int
        Highest degree, 40 to 96: 40 for `lighting_error`, 96 for `gloss_error`.

    Returns
    -------
    MapTerms
        Float64 arrays of NumPy, of the same shapes for all maps.

    Examples
    --------
    >>> import envlights as el
    >>> map_terms(el.synthetic.hall(32).radiance).dull.shape
    (41, 41, 6)
    """
    degree = count("degree", degree, least=40, most=_native.GLOSS_DEGREE)
    reduced = reduction_of(as_envmap(env), False).cells
    dull, fine, direction, flux, spread = _native.expand_reduced(reduced)
    # Add black parts, so that the arrays of all maps have the same shape.
    black = np.zeros((_native.MOST_PARTS - len(spread), 3))
    up = np.tile([0.0, 1.0, 0.0], (len(black), 1))
    direction, flux = np.vstack([direction, up]), np.vstack([flux, black])
    spread = np.append(spread, np.full(len(black), 1e-3))
    radius = 2 * np.arcsin(np.sqrt(spread))
    bright = _native.expand_discs(direction, flux * (1 - spread)[:, None], radius, degree)
    more = (0, degree + 1 - len(dull))
    dull = np.pad(dull, (more, more, (0, 0)))
    apart = mean_distances(np, direction, spread, direction, spread)
    distances = np.sum(flux * (apart @ flux), axis=0)
    return MapTerms(dull, bright, np.array(fine), direction, flux, spread, distances)


def lighting_error(lights: Lights, terms: MapTerms, kind: str = "shadows") -> Array:
    r"""Relative RMS error of lights under a map, (...), differentiable by the arrays of the lights.

    Parameters
    ----------
    lights, terms : Lights, MapTerms
    kind : {"shadows", "probe", "mixed"}
        "shadows": irradiance at every normal behind every blocking plane, as
        `FitReport.shadow_error`. "probe": at every normal, as `Rig.error`. "mixed": their mean,
        as `FitReport.objective_error`.

    Notes
    -----
    With the map L and its difference D from the lights, it is the root of
    :math:`\langle D, D \rangle / \langle L, L \rangle`, at least 1e-8. The kernel is a smooth
    part, in harmonics, less a cone, the mean distance. Radii below 0.003 degrees count as that.

    Examples
    --------
    >>> import envlights as el
    >>> env = el.EnvMap(el.synthetic.hall(128).radiance)
    >>> rig = el.fit(env, lights=4)
    >>> ratio = lighting_error(Lights.of(rig), map_terms(env)) / rig.report.shadow_error
    >>> bool(abs(ratio - 1) < 0.02)
    True
    """
    check_choice("kind", kind, tuple(KINDS))
    xp, lights = check_lights(lights)
    terms = MapTerms(*(constant(each, lights.irradiance) for each in terms))
    whole, smooth, cone = _kernel(kind, 40)
    dull, bright = (each[:41, :41] for each in terms[:2])
    sky, direct = expand_lights(xp, lights, 40)

    def product(dull: Array, bright: Array, distances: Array) -> Array:
        fine = (whole[-2:].mean() / 4) * xp.sum(terms.fine) - cone * distances
        mixed = _weighted_sum(xp, dull * (dull + 2 * bright), whole)
        return mixed + _weighted_sum(xp, bright * bright, smooth) + fine

    distances = xp.sum(terms.distances)
    change = _change_of_distances(xp, lights, terms) if cone else 0.0
    cost = product(dull - sky, bright - direct, distances + change)
    return _relative(xp, cost, product(dull, bright, distances))


def gloss_error(
    lights: Lights, terms: MapTerms, roughness: float = 0.33, material: str = "metal"
) -> Array:
    """Relative RMS error of images of a rough ball over all views, (...), as in `FitReport`.

    It needs ``map_terms(env, degree=96)``; fewer degrees show less of bright lights. Roughness and
    material are those of `kernels.gloss.spectrum`, from 0.3 to 1.
    """
    check_choice("material", material, gloss.MATERIALS)
    xp, lights = check_lights(lights)
    terms = MapTerms(*(constant(each, lights.irradiance) for each in terms))
    degree = terms.dull.shape[0] - 1
    factors = gloss.factors(gloss.checked_roughness(roughness), material, degree)
    # Beyond degree 40, the energy of the dim cells falls off as the square of the degree.
    fine = xp.sum(terms.fine) * float((factors[41:] / np.arange(41, degree + 1) ** 2).sum() * 40.5)
    both, (sky, direct) = terms.dull + terms.bright, expand_lights(xp, lights, degree)
    squares = both * both, (both - sky - direct) ** 2
    energy, cost = (_weighted_sum(xp, each, factors) + fine for each in squares)
    return _relative(xp, cost, energy)


@lru_cache
def _kernel(kind: str, degree: int) -> tuple[Any, Any, float]:
    """Factors per degree, factors without the cone, and the factor of the cone."""
    probe, shadows = _native.kernel_spectra(degree)
    of_probe, of_shadows = KINDS[kind]
    whole = of_probe * probe / probe[0] + of_shadows * shadows / shadows[0]
    cone, k = float(of_shadows / (3 * shadows[0])), np.arange(degree + 1)
    return whole, whole - cone * 16 * np.pi / ((2 * k - 1) * (2 * k + 1) * (2 * k + 3)), cone


def _weighted_sum(xp: Any, values: Array, factors: Any) -> Array:
    """Sum of coefficients, (..., order, degree, 6), weighted by a factor per degree."""
    return xp.sum(values * constant(factors[:, None], values), axis=(-3, -2, -1))


def _change_of_distances(xp: Any, lights: Lights, terms: MapTerms) -> Array:
    """Change of the summed mean distances when the lights are subtracted from the bright parts."""
    spread, flux = spread_and_flux(xp, lights)
    own = lights.direction, xp.clip(spread, 6e-10, None)
    plain = (terms.direction, terms.spread, -2 * terms.flux)
    parts = (xp.broadcast_to(each, (*spread.shape[:-1], *each.shape)) for each in plain)
    pairs = zip((*own, flux), parts, strict=True)
    direction, size, fluxes = (xp.concat(pair, axis=spread.ndim - 1) for pair in pairs)
    within = mean_distances(xp, *own, direction, size)
    return xp.sum(flux * xp.matmul(within, fluxes), axis=(-2, -1))


def _relative(xp: Any, cost: Array, energy: Array) -> Array:
    """Square root of a cost relative to the energy of the map, bounded for a finite gradient."""
    return xp.sqrt(xp.clip(cost / xp.where(energy > 0, energy, 1.0), 1e-16, None))
