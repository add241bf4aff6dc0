"""Shadows of solids on a floor as a `ShadowOverlay`."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import kernels
from envlights._common.check import colour, count, one_or_more, reals
from envlights._native import EnvLightsError
from envlights.kernels.solids import Ball, Solid, Stage, solids_of
from envlights.rigs.rig import Rig
from envlights.scene.direct import AnyLights, as_rig
from envlights.scene.overlay import ShadowOverlay
from envlights.scene.solids import source_light

#: Length of a shadow in an automatic picture, relative to the height of the solid.
_LENGTH = 2.0
#: Visible fraction of the sky below which a point counts as under a solid.
_COVERED = 1e-9


def shadow_overlay(
    rig: AnyLights,
    solids: Solid | Iterable[Solid],
    points: ArrayLike | None = None,
    *,
    columns: int = 256,
    floor_albedo: ArrayLike = (0.5, 0.5, 0.5),
    albedo: ArrayLike | None = None,
) -> ShadowOverlay:
    r"""Ratios by which shadows of solids darken a floor: section 4 of Madsen et al. (2003).

    Parameters
    ----------
    rig : Rig, Lights or DetectedLights
        Lights without a rig have no ambient term.
    solids : Ball, Box or Polyhedron, or several
        Solids on the floor.
    points : array_like, shape (n, 3) or (height, width, 3), optional
        Points of the floor, whose normal is +y. Default: a square picture of the plane y = 0 around
        the solids and their shadows, from above, with +x to the right and +z down.
    columns : int
        Width and height of that picture.
    floor_albedo : array_like, shape (3,)
        Reflectance of the floor, for the colour of the overlay and for reflected light.
    albedo : array_like, shape (3,) or (solids, 3), optional
        Reflectance of the solids: include the light that floor and solids reflect to each other, by
        the model of `kernels.reflected_irradiance`. Default: shadows alone.

    Returns
    -------
    ShadowOverlay

    Raises
    ------
    EnvLightsError
        If a solid is below the floor, or an argument has another shape.

    Notes
    -----
    With the irradiance E of the floor and the hidden part :math:`H_j` of each source, the radiance
    of a diffuse floor changes by the ratio

    .. math:: r = 1 - \sum_j H_j / E

    for each channel. It is exact for any colour of the floor, because its albedo cancels. One alpha
    for three channels is exact for one colour of the floor only. The product of the ratios of
    single lights is always too bright where several are hidden: two equal lights give
    :math:`(1 - 1/2)^2 = 1/4` instead of 0. All of it holds in linear light.

    The hidden part of the ambient term is the contact shadow. Reflected light brightens it again,
    by more than half on bright floors, so use both or neither; then `ratio` may exceed 1, and the
    product and the single ratios have no reflected light.

    Under an ambient term of harmonics, the hidden fraction is exact, and its radiance is the mean
    over rays.

    References
    ----------
    C. B. Madsen, M. K. D. Sørensen, M. Vittrup: "Estimating positions and radiances of a small
    number of light sources for real-time image-based lighting", Eurographics 2003.

    Examples
    --------
    >>> import envlights as el
    >>> rig = el.fit(el.synthetic.hall(64).radiance, lights=2, floor=True)
    >>> shadow = shadow_overlay(rig, el.scene.Box((0, 0.5, 0), (0.5, 0.5, 0.5)), columns=64)
    >>> shadow.ratio.shape, shadow.single.shape
    ((64, 64, 3), (3, 64, 64, 3))
    """
    rig, solids = as_rig(rig), solids_of(solids)
    notes = _floor_notes(solids)
    size = count("columns", columns, least=1)
    where = _picture(solids, size) if points is None else _points(points)
    stage = Stage.floor(solids, where.reshape(-1, 3))
    reflectance = np.array(colour("floor_albedo", floor_albedo))
    light = source_light(rig, stage)
    sky = kernels.hidden_fractions(stage, np.zeros((0, 3)), np.zeros(0), floor=True)[:, 0]
    whole = light.whole.sum(axis=0)[:1] if len(where) else rig.probe([[0.0, 1.0, 0.0]])
    # Avoid division by 0 on a floor without light.
    unit = np.where(whole > 0, whole, 1.0)
    single = 1 - light.hidden / unit
    ratio = 1 - light.hidden.sum(axis=0) / unit
    if albedo is not None:
        ratio = _reflected_light(rig, stage, reflectance, albedo) / unit
        notes += ("the ratio includes a model of reflected light; single ratios do not",)
    shape = where.shape
    return ShadowOverlay(
        where,
        whole[0],
        single.reshape(-1, *shape),
        np.maximum(ratio, 0.0).reshape(shape),
        reflectance,
        (sky >= 1 - _COVERED).reshape(shape[:-1]),
        notes,
    )


def _reflected_light(
    rig: Rig, stage: Stage, floor_albedo: NDArray[np.float64], albedo: ArrayLike
) -> NDArray[np.float64]:
    """Irradiance of the floor with shadows and reflected light."""
    if rig.ambient.ndim == 2:
        raise EnvLightsError(
            "albedo needs a rig with a constant ambient term; this one has harmonics, (9, 3);"
            " leave albedo out, or fit with ambient='constant'"
        )
    each, is_one = one_or_more("albedo", albedo)
    wanted = (len(stage.solids), 3)
    if each.shape != wanted and not (is_one and each.shape == (1, 3)):
        raise EnvLightsError(f"albedo must have the shape (3,) or {wanted}; got {np.shape(albedo)}")
    each = np.broadcast_to(each, wanted)
    lights = rig.lights
    return kernels.reflected_irradiance(
        stage,
        rig.ambient,
        lights.direction,
        lights.irradiance,
        lights.angular_radius,
        albedo=each,
        floor_albedo=floor_albedo,
    )


def _floor_notes(solids: tuple[Solid, ...]) -> tuple[str, ...]:
    """Notes on solids that reach below the floor; raises an error for solids entirely below."""
    notes = []
    for row, solid in enumerate(solids):
        name = f"solid {row} ({type(solid).__name__})"
        if _highest(solid) <= 0:
            raise EnvLightsError(
                f"{name} is below the floor, the plane y = 0: its highest point is at"
                f" {_highest(solid):g}; raise it, +y is up"
            )
        if solid.lowest < -1e-6 * _highest(solid):
            notes.append(f"{name} reaches {-solid.lowest:.3g} below the floor, where it is cut off")
    return tuple(notes)


def _highest(solid: Solid) -> float:
    if isinstance(solid, Ball):
        return solid.centre[1] + solid.radius
    return max(vertex[1] for vertex in solid.vertices)


def _picture(solids: tuple[Solid, ...], columns: int) -> NDArray[np.float64]:
    """Centres of the pixels of a square around solids and their shadows, (columns, columns, 3)."""
    low, high = np.array([-1.0, -1.0]), np.array([1.0, 1.0])
    if solids:
        boxes = [_footprint(solid) for solid in solids]
        low, high = np.min([b[0] for b in boxes], axis=0), np.max([b[1] for b in boxes], axis=0)
    middle, half = (low + high) / 2, float((high - low).max()) / 2
    steps = (2 * np.arange(columns) + 1) / columns - 1
    x, z = np.meshgrid(middle[0] + half * steps, middle[1] + half * steps)
    return np.stack([x, np.zeros_like(x), z], axis=-1)


def _footprint(solid: Solid) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Corners of a rectangle around a solid with its shadows, in x and z."""
    rim = _LENGTH * _highest(solid)
    if isinstance(solid, Ball):
        low = high = np.array(solid.centre)[[0, 2]]
        rim += solid.radius
    else:
        corners = np.array(solid.vertices)[:, [0, 2]]
        low, high = corners.min(axis=0), corners.max(axis=0)
    return low - rim, high + rim


def _points(points: ArrayLike) -> NDArray[np.float64]:
    """Points on a floor; raises an error for other values."""
    array = reals("points", points, None)
    if array.ndim not in (2, 3) or array.shape[-1] != 3:
        raise EnvLightsError(
            f"points must have the shape (n, 3) or (height, width, 3); got {array.shape}"
        )
    return array
