"""`place`: the lights of a map where they hang."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from envlights._common.notes import log
from envlights._native import EnvLightsError
from envlights.cards import CardSplit
from envlights.environment.envmap import EnvMap
from envlights.environment.fill import ENOUGH_SEEN, Fill
from envlights.environment.reading import AnyMap
from envlights.kernels.image import luminance
from envlights.placing.depth import box_distance, corners_of, read_depth, triple, without_holes
from envlights.placing.patches import patches_of
from envlights.placing.placed_lights import PlacedLights
from envlights.placing.planes import Reals
from envlights.placing.position import place_cards
from envlights.placing.shading import hang
from envlights.placing.triangulate import triangulate
from envlights.splitting.split import Split, split

#: Map of a place, or its cards and remainder.
AnyParts = AnyMap | CardSplit


def place(
    env: AnyParts | Sequence[tuple[AnyParts, ArrayLike]],
    depth: ArrayLike | str | os.PathLike[str] | None = None,
    *,
    reading: str | None = None,
    scale: float | None = None,
    room: ArrayLike | None = None,
    camera: ArrayLike | None = None,
    fill: Fill = None,
) -> PlacedLights:
    r"""Give the lights of a map positions in metres, by the depth of its pixels.

    Cards of `split` become planes or spheres in space. A window, which has no depth, lies in the
    wall around it; a light with no surface around it, such as a sun, stays at infinity. The
    remainder becomes 512 diffuse patches at their depth. Without `depth` and `room`, two or more
    maps of one room give the positions of the lights that they share.

    Parameters
    ----------
    env : EnvMap, path, array_like or CardSplit
        The map, or ``el.split(env, shapes=True)``. Or pairs of a map and its position in metres,
        ``[(env, (0, 0, 0)), (other, (1.2, 0, 0))]``, all with the axes of the first; results are
        relative to the first.
    depth : path-like or array_like, shape (height, 2 * height), optional
        Depth in metres, equirectangular as the map, of any size: OpenEXR with a channel Z, PNG of
        16 bits, `.npy` or an array. Zero, NaN and infinity mean that it is unknown.
    reading : {"ray", "horizontal", "cube axis", "inverse"}, optional
        Distance along the ray, distance in the horizontal plane, depth along the axis of a cube's
        face, or one over the distance. Default: the reading under which surfaces are flat, with a
        note.
    scale : float, optional
        Metres of a value of 1, such as 0.001 for millimetres; of "inverse", 1 / metres. Required
        for whole numbers. Default: 1.
    room : array_like, shape (3,), optional
        Instead of a depth, width along x, height along y and depth along z of a box, in metres. The
        light on its walls shows how far round lamps hang. Rectangles stay in their wall, and also
        lamps for which both are possible, with a note.
    camera : array_like, shape (3,), optional
        Position of the camera in the room, from the corner with the least x, y and z. Default: the
        middle.
    fill : {"black", "harmonic", "ground"}, float or array_like, shape (3,), optional
        Radiance where the (first) map shows nothing; see `EnvMap.filled`. With less than 85 % of
        the sphere seen, `irradiance`, `at` and `map_at` need it; positions do not.

    Returns
    -------
    PlacedLights
        `irradiance`, `at` and `map_at` give the light at a point of the room.

    Raises
    ------
    EnvLightsError
        If there is neither depth nor a second map, the depth has another shape, is negative or
        unknown nearly everywhere, contradicts `reading`, or is of whole numbers without `scale`; or
        the camera is not in the room.

    See Also
    --------
    split : the cards.

    Notes
    -----
    On a plane, 1 / depth is linear in the direction: a robust linear fit to the pixels around a
    light gives the plane. A light that is more than 4 % nearer than that plane hangs, and is a
    sphere of radius :math:`D \sin a` at the distance D for the angular radius a. Its pixels show
    its front, at :math:`D (\cos t - \sqrt{\sin^2 a - \sin^2 t})` along a ray at the angle t from
    its centre.

    With `room`, the radiance of each wall is fitted by its albedo times the direct light of the
    lamps, plus a multiple of the light of the other walls, plus a linear function. A lamp hangs
    where the squared residual is less than on the wall by 13 % or more. The note states the
    residual: 2 to 5 % in five rooms, 14 % with furniture, 39 % or more in photographs of rooms of
    unknown size.

    Examples
    --------
    A room of 6 x 3 x 5 m, with the camera in the middle and a panel in the ceiling:

    >>> import envlights as el
    >>> lamp = el.synthetic.Rectangle((0, 1, 0), 30.0, 30.0, (9, 9, 9))
    >>> world = el.synthetic.scene(64, background=[0.2] * 3, shapes=[lamp])
    >>> placed = el.place(world.radiance, room=(6, 3, 5))
    >>> placed[0]
    <PlacedLight: plane, 0.80 m x 0.80 m, at 1.50 m>
    >>> rig = placed.at([0, 0.5, 0])
    >>> len(rig.lights), rig.error < 0.01
    (4, True)
    """
    pairs = _pairs(env)
    parts = [_parts(each) for each, _ in pairs]
    corners = _corners(room, camera, depth, reading, scale)
    remainder, assumed = _with_fill(parts[0].remainder, fill)
    if depth is None and room is None:
        _check_several(parts, reading, scale)
        where = [place - pairs[0][1] for _, place in pairs]
        lights, notes = triangulate([each.cards for each in parts], where)
        log(notes)
        return PlacedLights(lights, remainder, np.zeros((0, 10)), None, (*assumed, *notes))
    if len(parts) > 1:
        raise EnvLightsError("give depth or several maps, not both; the depth is that of one map")
    if corners is None:
        distance, notes = read_depth(depth, reading, scale)
    else:
        distance, notes = box_distance(corners, 256), []
    cards = parts[0].cards
    light = luminance(cards.to_map(2 * len(distance)).radiance)
    lights, behind = place_cards(cards, distance, light)
    surfaces = without_holes(behind)
    patches = patches_of(remainder, surfaces)
    if corners is not None:
        lights, note = hang(lights, cards, remainder, patches, corners)
        notes.append(note)
    log(notes)
    return PlacedLights(lights, remainder, patches, surfaces, (*assumed, *notes))


def _with_fill(remainder: EnvMap, fill: Fill) -> tuple[EnvMap, tuple[str, ...]]:
    """Remainder with a fill where the map shows nothing, and a note on it; see `place`."""
    if remainder.coverage is None or (fill is None and remainder.coverage_fraction < ENOUGH_SEEN):
        return remainder, ()
    filled = remainder.filled(fill)
    return filled, filled.notes[-1:]


def _check_several(parts: list[CardSplit], reading: object, scale: object) -> None:
    """Raise an error unless there are maps of one scale, and nothing that belongs to a depth."""
    if len(parts) < 2:
        raise EnvLightsError(
            "place needs depth=, room=(width, height, depth) in metres, or a second map of the"
            " room with its position"
        )
    if reading is not None or scale is not None:
        raise EnvLightsError("reading= and scale= belong to a depth; leave them out")
    if len({each.remainder.units for each in parts}) > 1:
        raise EnvLightsError("maps of one room must have the same units; calibrate all, or none")


def _corners(
    room: ArrayLike | None, camera: ArrayLike | None, *of_depth: object
) -> tuple[Reals, Reals] | None:
    """Corners of a room, if there is one; it replaces a depth."""
    if room is None:
        if camera is not None:
            raise EnvLightsError("camera is a position in a room; give room= as well")
        return None
    if any(each is not None for each in of_depth):
        raise EnvLightsError("room replaces depth=, reading= and scale=; leave them out")
    return corners_of(room, camera)


def _pairs(env: Any) -> list[tuple[Any, Reals]]:
    """Maps and their positions."""
    is_list = type(env) in (list, tuple) and len(env) > 0
    if is_list and all(type(each) is tuple and len(each) == 2 for each in env):
        return [(each, triple("the position of a map", position)) for each, position in env]
    return [(env, np.zeros(3))]


def _parts(env: Any) -> CardSplit:
    """Cards and remainder of a map."""
    if isinstance(env, Split):
        raise EnvLightsError("place needs cards; give the map, or el.split(env, shapes=True)")
    return env if isinstance(env, CardSplit) else split(env, shapes=True)
