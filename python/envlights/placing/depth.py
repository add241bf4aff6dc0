"""Distance of the nearest surface in each direction, by an array, a file or the size of a room."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import amount, check_choice, reals
from envlights._common.words import percent
from envlights._native import EnvLightsError
from envlights.environment.decoders.native import open_native
from envlights.environment.decoders.source import kind_of, named_source
from envlights.environment.files.images import MOST_PIXELS
from envlights.kernels.sphere import pixel_directions
from envlights.placing.reading import READINGS, Reals, measured_flatness

#: Names of channels that hold depth, in lower case.
_CHANNELS = ("z", "depth", "distance", "depth.z", "y")
#: Farthest floor of a room in metres: a greater distance is probably in other units.
_FARTHEST_FLOOR = 50.0


def read_depth(
    depth: ArrayLike | str | os.PathLike[str],
    reading: str | None = None,
    scale: float | None = None,
) -> tuple[Reals, list[str]]:
    """Distance along the ray of each pixel, infinite where there is none, with notes.

    Parameters
    ----------
    depth : path-like or array_like, shape (height, 2 * height)
        OpenEXR with a channel Z, PNG of 16 bits, `.npy`, or an array.
    reading : {"ray", "horizontal", "cube axis", "inverse"}, optional
        Meaning of the numbers. Default: the one under which surfaces are flat.
    scale : float, optional
        Metres of a value of 1; of "inverse", 1 / metres. Required for whole numbers.
    """
    if reading is not None:
        check_choice("reading", reading, tuple(READINGS))
    values = _values(depth, scale)
    known = np.isfinite(values) & (values > 0)
    if known.mean() < 0.01:
        raise EnvLightsError("depth must hold finite numbers above 0; less than 1 % are")
    values = np.where(known, values, np.nan)
    name, notes = _reading(values, reading)
    distance = READINGS[name](values, pixel_directions(*values.shape))
    return np.where(known, distance, np.inf), [*notes, *_doubts(distance, known)]


def room_distance(room: ArrayLike, camera: ArrayLike | None, height: int) -> Reals:
    """Distance of the walls of a box along the ray of each pixel.

    Parameters
    ----------
    room : array_like, shape (3,)
        Width along x, height along y, and depth along z, in metres.
    camera : array_like, shape (3,), optional
        Position of the camera from the corner with the least coordinates. Default: the middle.
    height : int
        Rows of pixels.
    """
    size = _triple("room", room)
    if not (size > 0).all():
        raise EnvLightsError(f"room must be three lengths above 0; got {size.tolist()}")
    inside = size / 2 if camera is None else _triple("camera", camera)
    if not ((inside > 0) & (inside < size)).all():
        raise EnvLightsError(
            f"camera must lie in the room of {size.tolist()} m, measured from the corner with the"
            f" least x, y and z; got {inside.tolist()}"
        )
    ray = pixel_directions(height, 2 * height)
    with np.errstate(divide="ignore"):
        distance: Reals = np.where(ray > 0, (size - inside) / ray, -inside / ray).min(axis=-1)
    return distance


def _triple(name: str, values: ArrayLike) -> Reals:
    triple = reals(name, values, 1)
    if triple.shape != (3,) or not np.isfinite(triple).all():
        raise EnvLightsError(f"{name} must be three finite numbers; got {np.asarray(values)!r}")
    return triple


def _values(depth: Any, scale: float | None) -> Reals:
    """Samples of a depth map in metres, or one over metres."""
    if isinstance(depth, str | os.PathLike):
        array, name = _samples(os.fspath(depth)), f"the depth in {depth}"
    else:
        array, name = np.asarray(depth), "depth"
    array = array[..., 0] if array.ndim == 3 and array.shape[2] == 1 else array
    if array.ndim != 2 or array.shape[1] != 2 * array.shape[0] or array.shape[0] < 16:
        raise EnvLightsError(
            f"{name} must have the shape (height, 2 * height) with 16 rows or more, as an"
            f" equirectangular map; got {array.shape}"
        )
    if array.dtype.kind in "iu" and scale is None:
        raise EnvLightsError(
            f"{name} holds whole numbers without a unit; give scale=, the metres of a value of 1,"
            " such as 0.001 for millimetres"
        )
    values = reals("depth", array, 2) * (1.0 if scale is None else amount("scale", scale))
    if (values < 0).any():
        raise EnvLightsError(f"{name} must not be negative; its least value is {values.min():.4g}")
    return values


def _samples(path: str) -> NDArray[Any]:
    """Samples of the depth channel of a file."""
    if Path(path).suffix.lower() == ".npy":
        try:
            return np.asarray(np.load(path, allow_pickle=False))
        except (OSError, ValueError) as error:
            raise EnvLightsError(f"cannot read the depth in {path}: {error}") from None
    source = named_source(path)
    file = open_native(source, kind_of(source, any_format=False), MOST_PIXELS)
    for part, each in enumerate(file.parts):
        names = [name for name in each.channels if name.lower() in _CHANNELS]
        names += each.channels[:1] if len(each.channels) in (1, 3) and not names else []
        if names:
            return file.image(part, names[:1]).samples[..., 0]
    channels = ", ".join(name for each in file.parts for name in each.channels)
    raise EnvLightsError(f"{path} has no channel of depth, such as Z; it has {channels}")


def _reading(values: Reals, wanted: str | None) -> tuple[str, list[str]]:
    """Reading of samples of depth, and a note on it, or a refusal of one that contradicts them."""
    known = values[np.isfinite(values)]
    if np.ptp(known) < 1e-6 * known.max():  # a sphere around the camera
        return wanted or "ray", []
    flat = measured_flatness(values)
    best = min(flat, key=flat.__getitem__)
    words = ", ".join(f"'{name}' {percent(value)}" for name, value in flat.items())
    facts = f"surfaces differ from planes by {words}"
    if wanted is not None and flat[best] < 0.6 * flat[wanted] and flat[wanted] > 5e-3:
        raise EnvLightsError(
            f"the depth contradicts reading='{wanted}': {facts}; give reading='{best}', or leave it"
            " out"
        )
    name = wanted or (best if flat[best] < 0.95 * flat["ray"] else "ray")
    notes = [f"the depth was read as '{name}': {facts}"] if wanted is None else []
    if flat[name] > 0.05:
        notes.append(
            f"the depth shows no flat surfaces ({percent(flat[name])}), so positions are doubtful:"
            " is it inverted, relative, or of another map?"
        )
    return name, notes


def _doubts(distance: Reals, known: NDArray[np.bool_]) -> list[str]:
    """Notes on depth that is incomplete, or too large for a room."""
    notes = []
    floor = np.nanmedian(distance[-len(distance) // 8 :]) if known[-len(known) // 8 :].any() else 1
    if not 1 / _FARTHEST_FLOOR < floor < _FARTHEST_FLOOR:
        notes.append(
            f"the depth puts the floor {floor:.4g} m below the camera, so its unit is doubtful;"
            " give scale=0.001 for millimetres"
        )
    if known.mean() < 0.9:
        notes.append(
            f"the depth is unknown for {percent(1 - known.mean())} of the pixels; their light stays"
            " at infinity"
        )
    return notes
