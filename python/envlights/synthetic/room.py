"""A closed room under many lights, without noise: for models of indirect light.

Two boxes stand in a cube. Each of their 16 faces is a chart of the lightmap, four by four charts.
Light bounces between patches (radiosity), so the indirect light is exact for those patches, and
linear in the direct light.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._check import count
from envlights._native import EnvLightsError

#: Corners of the room, which is seen from inside, and of the boxes, from outside; in metres.
_ROOM = np.array([[-1.0, 0.0, -1.0], [1.0, 2.0, 1.0]])
_BOXES = np.array([[[-0.7, 0.0, -0.6], [-0.1, 1.2, 0.0]], [[0.2, 0.0, 0.0], [0.7, 0.6, 0.6]]])

#: Charts along a side of the lightmap, patches along a side of a chart, and samples of direct light
#: along a side of a patch.
_CHARTS, _PATCHES, _SAMPLES = 4, 8, 2
#: Metres between a lamp and the nearest wall. A lamp that touches a wall lights one texel of the
#: direct image, which says little about where it is.
_CLEARANCE = 0.2
#: Texels along a side of the direct image.
_DIRECT = 16


@dataclass(frozen=True, eq=False)
class Room:
    """Pairs of images of the room: irradiance, linear RGB."""

    direct: NDArray[np.float32]
    """Direct light, (pairs, 16, 16, 3); each texel is the mean over its part of a wall."""

    indirect: NDArray[np.float32]
    """Indirect light, (pairs, width, width, 3)."""


def room(pairs: int = 128, width: int = 64, seed: int = 0) -> Room:
    """A closed room with two boxes, under one to three random lamps in each pair of images.

    Lamps are points or spots, of any colour, anywhere in the free air. All shadows are cast and all
    bounces counted.

    Parameters
    ----------
    pairs : int
        How many lightings.
    width : int
        Columns and rows of the indirect images: a multiple of 4.
    seed : int
        Of the lamps; the room is always the same.

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
    patches = _charts(_CHARTS * _PATCHES)
    samples = _charts(_CHARTS * _PATCHES * _SAMPLES)
    light = np.stack([_lamps(rng, samples) for _ in range(pairs)])
    radiosity = _radiosity(patches, _means(light, _CHARTS * _PATCHES))
    gathered = _form_factors(_charts(width), patches)
    indirect = np.einsum("tp,kpc->ktc", gathered, radiosity, optimize=True)
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
    """The lightmap of `width` columns: chart after chart, six of the room, five of each box."""
    side = width // _CHARTS
    faces = [_face(_ROOM, axis, end, side, -1) for axis in range(3) for end in (0, 1)]
    for box in _BOXES:
        # No light reaches the face on the floor.
        seen = [(axis, end) for axis in range(3) for end in (0, 1) if (axis, end) != (1, 0)]
        faces += [_face(box, axis, end, side, 1) for axis, end in seen]
    arrays = [np.stack(each) for each in zip(*faces, strict=True)]
    chart = np.repeat(np.arange(len(faces)), side * side).reshape(len(faces), -1)
    return _Texels(*(_in_rows(array, side) for array in (*arrays, chart)))


def _face(
    box: NDArray[np.float64], axis: int, end: int, side: int, outwards: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Centres, normals and areas of one face of a box, `side` by `side` pieces."""
    steps = (np.arange(side) + 0.5) / side
    centre = np.empty((side, side, 3))
    others = [each for each in range(3) if each != axis]
    lengths = (box[1] - box[0])[others]
    centre[..., axis] = box[end, axis]
    centre[..., others[0]] = (box[0, others[0]] + steps * lengths[0])[:, None]
    centre[..., others[1]] = (box[0, others[1]] + steps * lengths[1])[None, :]
    normal = np.zeros((side * side, 3))
    normal[:, axis] = outwards * (2 * end - 1)
    return centre.reshape(-1, 3), normal, np.full(side * side, lengths.prod() / side**2)


def _in_rows(values: NDArray[Any], side: int) -> NDArray[Any]:
    """Values of (chart, texel of the chart, ...) in the order of the lightmap's rows."""
    tail = values.shape[2:]
    grid = values.reshape(_CHARTS, _CHARTS, side, side, *tail)
    return grid.swapaxes(1, 2).reshape(-1, *tail)


def _means(values: NDArray[np.float64], width: int) -> NDArray[np.float64]:
    """Lightmaps (k, texels, 3) reduced to `width` columns."""
    fine = int(np.sqrt(values.shape[1]))
    step = fine // width
    grid = values.reshape(len(values), width, step, width, step, 3)
    reduced: NDArray[np.float64] = grid.mean(axis=(2, 4)).reshape(len(values), -1, 3)
    return reduced


def _lamps(rng: np.random.Generator, at: _Texels) -> NDArray[np.float64]:
    """Irradiance of one to three random lamps."""
    light = np.zeros((len(at.centre), 3))
    for _ in range(rng.integers(1, 4)):
        position, target = _free_place(rng), rng.uniform(*_ROOM)
        colour = rng.gamma(2.0, 0.5, 3)
        towards = position - at.centre
        distance = np.linalg.norm(towards, axis=1)
        towards /= distance[:, None]
        cosine = np.maximum(np.sum(towards * at.normal, axis=1), 0)
        shine = cosine / (distance**2 + 0.01) * _open(at.centre, position[None])
        if rng.random() < 0.5:
            axis = (position - target) / np.linalg.norm(position - target)
            shine *= _cone(towards @ axis)
        light += shine[:, None] * colour
    return light


def _free_place(rng: np.random.Generator) -> NDArray[np.float64]:
    """A point of the room, off the walls and the boxes."""
    while True:
        place = rng.uniform(_ROOM[0] + _CLEARANCE, _ROOM[1] - _CLEARANCE)
        outside = np.maximum(_BOXES[:, 0] - place, place - _BOXES[:, 1]).max(axis=1)
        if (outside > _CLEARANCE).all():
            return np.asarray(place)


def _cone(cosine: NDArray[np.float64]) -> NDArray[np.float64]:
    """A spot of 40 degrees around its axis that fades from 25 degrees on."""
    outer, inner = np.cos(np.deg2rad([40, 25]))
    share = np.clip((cosine - outer) / (inner - outer), 0, 1)
    faded: NDArray[np.float64] = share * share * (3 - 2 * share)
    return faded


def _radiosity(patches: _Texels, light: NDArray[np.float64]) -> NDArray[np.float64]:
    """What leaves each patch, from all bounces: ``(I - albedo F)^-1 albedo E``, (k, patches, 3)."""
    # Walls of any colour; the same room each time.
    albedo = np.random.default_rng(7).uniform(0.25, 0.75, (_CHARTS**2, 3))[patches.chart]
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
    for first in range(0, len(factors), 256):
        some = slice(first, first + 256)
        towards = patches.centre - at.centre[some, None]
        square = np.einsum("tpi,tpi->tp", towards, towards) + 1e-12
        here = np.maximum(np.einsum("tpi,ti->tp", towards, at.normal[some]), 0)
        there = np.maximum(-np.einsum("tpi,pi->tp", towards, patches.normal), 0)
        shape = here * there / square * patches.area / (np.pi * square + patches.area)
        factors[some] = shape * _open(at.centre[some, None], patches.centre[None])
    return factors


def _open(start: NDArray[np.float64], end: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether no box stands between two points; their own faces do not."""
    clear = np.ones(np.broadcast_shapes(start.shape, end.shape)[:-1], np.bool_)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = 1.0 / (end - start)
        for box in _BOXES:
            near, far = (box[0] - start) * inverse, (box[1] - start) * inverse
            enter = np.nanmax(np.minimum(near, far), axis=-1, initial=1e-6)
            leave = np.nanmin(np.maximum(near, far), axis=-1, initial=1 - 1e-6)
            clear &= enter >= leave - 1e-9
    return clear
