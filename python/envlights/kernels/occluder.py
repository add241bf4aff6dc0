"""Light that balls and convex polyhedra block and reflect, in closed form."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native
from envlights._common.check import colour, flag, reals
from envlights._native import EnvLightsError
from envlights.kernels.solids import Stage


def hidden_fractions(
    stage: Stage, directions: ArrayLike, angular_radius: ArrayLike, *, floor: bool = False
) -> NDArray[np.float64]:
    r"""Fractions of an ambient term and of discs that all solids together hide.

    Parameters
    ----------
    stage : Stage
        Solids, and points with normals.
    directions : array_like, shape (m, 3)
        Unit vectors towards the discs.
    angular_radius : array_like, shape (m,)
        In radians from 0 to pi / 2; 0 is a point.
    floor : bool
        True: no ambient light comes from below the horizon.

    Returns
    -------
    ndarray, shape (n, 1 + m)
        Hidden irradiance of the ambient term, relative to :math:`\pi L_a`, and of each disc,
        relative to its irradiance at normal incidence. The part behind a horizon is not hidden.

    Raises
    ------
    EnvLightsError
        If an array has another shape, a vector not the length 1, or a radius is out of range.

    See Also
    --------
    rig_irradiance : the irradiance with nothing in the way.

    Notes
    -----
    The cosine-weighted solid angle of a region is half the integral of
    :math:`n \cdot (\omega \times d\omega)` along its border (Lambert 1760; Arvo 1994, "The
    irradiance Jacobian for partially occluded polyhedral sources"). Borders consist of arcs of
    circles: a disc and a ball are caps, a polyhedron is a polygon. Several solids together are
    exact, by inclusion and exclusion. The error is below 1e-9 of the irradiance of a source.

    Examples
    --------
    A ball at the height h hides :math:`h R^2 / d^3` of the sky from a floor, and all of a sun:

    >>> from envlights.kernels.solids import Ball, Stage
    >>> stage = Stage.floor(Ball((0, 2, 0), 1), [[0, 0, 0]])
    >>> hidden_fractions(stage, [[0, 1, 0]], [0.005]).round(9)
    array([[0.25, 1.  ]])
    """
    _check(stage)
    arrays = reals("directions", directions, 2), _radii(angular_radius)
    return _native.hidden_fractions(stage, *arrays, flag("floor", floor))


def form_factors(stage: Stage) -> NDArray[np.float64]:
    r"""Fraction of uniform irradiance that arrives from the directions of each solid.

    Parameters
    ----------
    stage : Stage
        Solids, and points with normals.

    Returns
    -------
    ndarray, shape (n, solids)
        :math:`\frac{1}{\pi} \int \max(0, n \cdot \omega)\, d\omega` over the directions to each
        solid; 0 for the solid on which the point lies. Solids do not hide each other here.

    Raises
    ------
    EnvLightsError
        If `stage` is not a `Stage`.

    Examples
    --------
    >>> from envlights.kernels.solids import Ball, Box, Stage
    >>> solids = [Ball((0, 2, 0), 1), Box((9, 1, 0), (1, 1, 1))]
    >>> form_factors(Stage.floor(solids, [[0, 0, 0]])).round(4)
    array([[0.25  , 0.0023]])
    """
    _check(stage)
    return _native.form_factors(stage)


class _Lighting:
    """Rig and albedos, in the form that the kernel reads."""

    directions: NDArray[np.float64]
    radii: NDArray[np.float64]
    irradiance: NDArray[np.float64]
    ambient: Sequence[float]
    albedo: list[list[float]]
    floor_albedo: Sequence[float]
    floor: bool


def reflected_irradiance(
    stage: Stage,
    ambient: ArrayLike,
    directions: ArrayLike,
    irradiance: ArrayLike,
    angular_radius: ArrayLike,
    *,
    albedo: ArrayLike,
    floor_albedo: ArrayLike,
    floor: bool = True,
) -> NDArray[np.float64]:
    r"""Irradiance with shadows, and with light reflected by the floor and the solids.

    Parameters
    ----------
    stage : Stage
        Solids on a floor, the plane y = 0, and points with normals.
    ambient : array_like, shape (3,)
        Radiance of the ambient term.
    directions, irradiance, angular_radius : array_like, shape (m, 3), (m, 3) and (m,)
        Discs, as in `rig_irradiance`.
    albedo : array_like, shape (solids, 3)
        Reflectance of each solid.
    floor_albedo : array_like, shape (3,)
        Reflectance of the floor.
    floor : bool
        True: no ambient light comes from below the horizon, and the floor reflects light.

    Returns
    -------
    ndarray, shape (n, 3)
        Irradiance at each point.

    Raises
    ------
    EnvLightsError
        If an array has another shape, or holds a value that is not possible.

    Notes
    -----
    Direct light and its shadows are exact. Reflected light is a model: a floor point sees each
    solid by the side that faces it, with the normal m, the form factor F and the albedo r:

    .. math:: E = \frac{e + \sum F r E_o(m)}{1 - \sum F r f (1 - m_y) / 2}

    with the direct light e, the light :math:`E_o` without obstacles, and the albedo f of the floor.
    A solid sees the floor at one point.

    Examples
    --------
    A dark ball on a white floor casts a shadow; a white ball brightens it:

    >>> from envlights.kernels.solids import Ball, Stage
    >>> stage = Stage.floor(Ball((0, 1, 0), 1), [[1, 0, 0]])
    >>> lit = dict(directions=[[0, 1, 0]], irradiance=[[1, 1, 1]], angular_radius=[0.1])
    >>> for albedo in (0, 1):
    ...     reflected_irradiance(stage, [1, 1, 1], **lit, albedo=[[albedo] * 3],
    ...                          floor_albedo=[1, 1, 1])[0, :1].round(3)
    array([2.541])
    array([3.873])
    """
    _check(stage)
    lighting = _Lighting()
    lighting.directions = reals("directions", directions, 2)
    lighting.radii = _radii(angular_radius)
    lighting.irradiance = reals("irradiance", irradiance, 2)
    lighting.ambient = colour("ambient", ambient)
    lighting.albedo = [_reflectance("albedo", row) for row in reals("albedo", albedo, 2)]
    lighting.floor_albedo = _reflectance("floor_albedo", floor_albedo)
    lighting.floor = flag("floor", floor)
    if not np.isfinite(lighting.irradiance).all() or (lighting.irradiance < 0).any():
        raise EnvLightsError("irradiance must be finite and not negative")
    return _native.reflected_irradiance(stage, lighting)


def _check(stage: object) -> None:
    if not isinstance(stage, Stage):
        raise EnvLightsError(
            "stage must be a Stage of solids, points and normals;"
            f" got an object of the type {type(stage).__name__}"
        )


def _radii(values: ArrayLike) -> NDArray[np.float64]:
    """Angular radii; raises an error for impossible values."""
    radii = reals("angular_radius", values, 1)
    bad = radii[~((radii >= 0) & (radii <= np.pi / 2))]
    if len(bad):
        raise EnvLightsError(f"angular_radius must lie from 0 to pi / 2; got {bad[0]:g}")
    return radii


def _reflectance(name: str, values: ArrayLike) -> list[float]:
    """Red, green and blue reflectance from 0 to 1; raises an error for other values."""
    channels = colour(name, values)
    if max(channels) > 1:
        raise EnvLightsError(f"{name} must lie from 0 to 1; got {max(channels):g}")
    return channels
