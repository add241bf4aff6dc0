"""A closed room under many lights, without noise, for models of indirect light.

Two boxes are in a cube. Their 16 faces are the charts of the lightmap, four by four. Light
bounces between patches (radiosity), so the indirect light is exact for those patches, and linear in
the direct light.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import count
from envlights._common.interruptible import interruptible
from envlights._native import EnvLightsError
from envlights.kernels.image import area_means
from envlights.synthetic.shapes import smoothstep
from envlights.transfer.files.database import ImagePairs

#: Corners of the room, whose inner faces are used, and of the boxes, with outer faces; in metres.
_ROOM = np.array([[-1.0, 0.0, -1.0], [1.0, 2.0, 1.0]])
_BOXES = np.array([[[-0.7, 0.0, -0.6], [-0.1, 1.2, 0.0]], [[0.2, 0.0, 0.0], [0.7, 0.6, 0.6]]])

#: Numbers along a side: charts per lightmap, patches per chart, direct-light samples per patch.
_CHARTS, _PATCHES, _SAMPLES = 4, 8, 2
#: Least distance in metres between a lamp and a wall. A lamp that touches a wall lights one texel
#: of the direct image, which says little about its place.
_CLEARANCE = 0.2
#: Texels along a side of the direct image.
_DIRECT = 16
#: Number of texels whose form factors are computed at once.
_BLOCK = 256


@dataclass(frozen=True, eq=False, repr=False)
class Room(ImagePairs):
    """Pairs of images of the room: irradiance.

    Direct light, (pairs, 16, 16, 3): each texel is the mean over its part of a wall. Indirect
    light, (pairs, width, width, 3).
    """


class Chart(NamedTuple):
    """A part of the lightmap: one face of the room or of a box, in metres, +y up."""

    origin: NDArray[np.float64]
    """The corner of the face at the first row and column, (3,)."""

    rows: NDArray[np.float64]
    """Edge of the face along the rows, (3,)."""

    columns: NDArray[np.float64]
    """Edge of the face along the columns, (3,)."""

    normal: NDArray[np.float64]
    """Unit normal on the visible side, (3,)."""


def room_charts() -> list[Chart]:
    """The 16 parts of the room's lightmap, row by row of four.

    Returns
    -------
    list of Chart
        Six of the room, then five of each box.

    Examples
    --------
    >>> floor = room_charts()[2]
    >>> floor.normal, floor.rows, floor.columns
    (array([0., 1., 0.]), array([2., 0., 0.]), array([0., 0., 2.]))
    """
    return [_chart(*face) for face in _faces()]


def _faces() -> list[tuple[NDArray[np.float64], int, int, int]]:
    """Box, axis, end and outward sign of each face: six of the room, five per box."""
    faces = [(_ROOM, axis, end, -1) for axis in range(3) for end in (0, 1)]
    for box in _BOXES:
        # No light reaches the face on the floor.
        open_faces = [(axis, end) for axis in range(3) for end in (0, 1) if (axis, end) != (1, 0)]
        faces += [(box, axis, end, 1) for axis, end in open_faces]
    return faces


def _chart(box: NDArray[np.float64], axis: int, end: int, outwards: int) -> Chart:
    """One face of a box."""
    sides = np.diag(box[1] - box[0])
    rows, columns = (sides[each] for each in range(3) if each != axis)
    normal = np.zeros(3)
    normal[axis] = outwards * (2 * end - 1)
    return Chart(box[0] + end * sides[axis], rows, columns, normal)


def room(pairs: int = 128, width: int = 64, seed: int = 0) -> Room:
    """A closed room with two boxes, under one to three random lamps in each pair of images.

    Lamps are points or spots of random colour at random places off the walls. The images have all
    shadows and all bounces.

    Parameters
    ----------
    pairs : int
        Number of pairs of images.
    width : int
        Columns and rows of the indirect images: a multiple of 4.
    seed : int
        Seed of the lamps; the room is always the same.

    Returns
    -------
    Room
        Direct and indirect light.

    Examples
    --------
    >>> scene = room(8, width=16)
    >>> scene.direct.shape, scene.indirect.shape
    ((8, 16, 16, 3), (8, 16, 16, 3))
    """
    pairs, width = count("pairs", pairs, least=1), count("width", width, least=_CHARTS)
    if width % _CHARTS:
        raise EnvLightsError(f"width must be a multiple of {_CHARTS}; got {width}")
    rng = np.random.default_rng(count("seed", seed))
    # Light finer samples of the walls directly.
    patches = _charts(_CHARTS * _PATCHES)
    samples = _charts(_CHARTS * _PATCHES * _SAMPLES)
    light = np.stack([_lamps(rng, samples) for _ in range(pairs)])
    # Bounce their means between the patches, and gather the result at the texels.
    radiosity = _radiosity(patches, _means(light, _CHARTS * _PATCHES))
    gathered = _form_factors(_charts(width), patches)
    indirect = interruptible(
        lambda: np.einsum("tp,kpc->ktc", gathered, radiosity, optimize=True),
        gathered.size * 3 * pairs,
    )
    return Room(
        _means(light, _DIRECT).reshape(pairs, _DIRECT, _DIRECT, 3).astype(np.float32),
        indirect.reshape(pairs, width, width, 3).astype(np.float32, order="C"),
    )


@dataclass(frozen=True, eq=False)
class _Texels:
    """Square pieces of the faces, in the order of the lightmap's texels."""

    centre: NDArray[np.float64]
    normal: NDArray[np.float64]
    area: NDArray[np.float64]
    chart: NDArray[np.int64]


def _charts(width: int) -> _Texels:
    """Texels of a lightmap with `width` columns: six charts of the room, five per box."""
    side = width // _CHARTS
    faces = [_face(chart, side) for chart in room_charts()]
    # Put their texels into the order of the lightmap's rows.
    arrays = [np.stack(each) for each in zip(*faces, strict=True)]
    chart = np.repeat(np.arange(len(faces)), side * side).reshape(len(faces), -1)
    return _Texels(*(_in_rows(array, side) for array in (*arrays, chart)))


def _face(
    chart: Chart, side: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Centres, normals and areas of one face, `side` by `side` pieces."""
    steps = (np.arange(side) + 0.5) / side
    along = steps[:, None, None] * chart.rows + steps[None, :, None] * chart.columns
    centre = (chart.origin + along).reshape(-1, 3)
    area = np.linalg.norm(np.cross(chart.rows, chart.columns)) / side**2
    return centre, np.tile(chart.normal, (side * side, 1)), np.full(side * side, area)


def _in_rows(values: NDArray[Any], side: int) -> NDArray[Any]:
    """Values (chart, texel of the chart, ...) reordered to lightmap rows."""
    tail = values.shape[2:]
    grid = values.reshape(_CHARTS, _CHARTS, side, side, *tail)
    return grid.swapaxes(1, 2).reshape(-1, *tail)


def _means(values: NDArray[np.float64], width: int) -> NDArray[np.float64]:
    """Lightmaps (k, texels, 3) reduced to `width` columns."""
    fine = int(np.sqrt(values.shape[1]))
    stacked = area_means(values.reshape(-1, fine, 3), len(values) * width, width)
    return stacked.reshape(len(values), -1, 3)


def _lamps(rng: np.random.Generator, at: _Texels) -> NDArray[np.float64]:
    """Irradiance of one to three random lamps."""
    light = np.zeros((len(at.centre), 3))
    for _ in range(rng.integers(1, 4)):
        # Draw a place, a target and a colour.
        position, target = _free_place(rng), rng.uniform(*_ROOM)
        colour = rng.gamma(2.0, 0.5, 3)
        # Shine on every texel that sees the lamp.
        towards = position - at.centre
        distance = np.linalg.norm(towards, axis=1)
        towards /= distance[:, None]
        cosine = np.maximum(np.sum(towards * at.normal, axis=1), 0)
        shine = cosine / (distance**2 + 0.01) * _open(at.centre, position[None])
        # Make every second lamp a spot.
        if rng.random() < 0.5:
            axis = (position - target) / np.linalg.norm(position - target)
            shine *= _cone(towards @ axis)
        light += shine[:, None] * colour
    return light


def _free_place(rng: np.random.Generator) -> NDArray[np.float64]:
    """Random point in the room, with distance to walls and boxes."""
    while True:
        place = rng.uniform(_ROOM[0] + _CLEARANCE, _ROOM[1] - _CLEARANCE)
        outside = np.maximum(_BOXES[:, 0] - place, place - _BOXES[:, 1]).max(axis=1)
        if (outside > _CLEARANCE).all():
            return np.asarray(place)


def _cone(cosine: NDArray[np.float64]) -> NDArray[np.float64]:
    """Fraction of a spot's light: 1 up to 25 degrees from its axis, 0 from 40 degrees on."""
    outer, inner = np.cos(np.deg2rad([40, 25]))
    return smoothstep(cosine, outer, inner)


def _radiosity(patches: _Texels, light: NDArray[np.float64]) -> NDArray[np.float64]:
    """Radiosity of each patch with all bounces: ``(I - albedo F)^-1 albedo E``, (k, patches, 3)."""
    # Draw the colours of the walls, the same each time.
    albedo = np.random.default_rng(7).uniform(0.25, 0.75, (_CHARTS**2, 3))[patches.chart]
    # Solve for all bounces, channel by channel.
    between = _form_factors(patches, patches)
    leaving = np.empty(light.shape)
    for channel in range(3):
        reflected = albedo[:, channel, None]
        bounces = np.eye(len(between)) - reflected * between
        leaving[..., channel] = np.linalg.solve(bounces, reflected * light[..., channel].T).T
    return leaving


def _form_factors(at: _Texels, patches: _Texels) -> NDArray[np.float64]:
    """Irradiance at each texel for the radiosity of each patch, (texels, patches).

    A patch of area A counts as a disc: cos cos A / (pi r^2 + A), which stays finite in corners.
    """
    factors = np.empty((len(at.centre), len(patches.centre)))
    for first in range(0, len(factors), _BLOCK):
        some = slice(first, first + _BLOCK)
        towards = patches.centre - at.centre[some, None]
        square = np.einsum("tpi,tpi->tp", towards, towards) + 1e-12
        here = np.maximum(np.einsum("tpi,ti->tp", towards, at.normal[some]), 0)
        there = np.maximum(-np.einsum("tpi,pi->tp", towards, patches.normal), 0)
        shape = here * there / square * patches.area / (np.pi * square + patches.area)
        factors[some] = shape * _open(at.centre[some, None], patches.centre[None])
    return factors


def _open(start: NDArray[np.float64], end: NDArray[np.float64]) -> NDArray[np.bool_]:
    """True if no box lies between two points, ignoring the faces that contain the points."""
    clear = np.ones(np.broadcast_shapes(start.shape, end.shape)[:-1], np.bool_)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = 1.0 / (end - start)
        for box in _BOXES:
            near, far = (box[0] - start) * inverse, (box[1] - start) * inverse
            enter = np.nanmax(np.minimum(near, far), axis=-1, initial=1e-6)
            leave = np.nanmin(np.maximum(near, far), axis=-1, initial=1 - 1e-6)
            clear &= enter >= leave - 1e-9
    return clear
