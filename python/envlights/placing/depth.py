"""Distance of the nearest surface in each direction, by an array, a file or the size of a room."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import amount, check_choice, reals
from envlights._common.files import DAMAGE
from envlights._common.words import percent
from envlights._native import EnvLightsError
from envlights.environment.decoders.native import open_native
from envlights.environment.decoders.source import kind_of, named_source
from envlights.environment.envmap import EnvMap
from envlights.environment.files.images import MOST_PIXELS
from envlights.kernels.sphere import pixel_directions
from envlights.placing.planes import READINGS, Reals, flatness

#: Names of channels of depth, in lower case.
_CHANNELS = ("z", "depth", "distance", "depth.z")
#: Largest unknown fraction that is taken for holes in walls, not for a sky: a window of 3 % whose
#: light is left at infinity costs 50 % at 2 m.
_MOST_HOLES = 0.25
#: Farthest floor of a room in metres: a greater distance is probably in other units.
_FARTHEST_FLOOR = 50.0


def read_depth(depth: Any, reading: str | None, scale: float | None) -> tuple[Reals, list[str]]:
    """Distance along the ray of each pixel, infinite if unknown, with notes; see `place`."""
    values = _values(depth, scale)
    known = np.isfinite(values) & (values > 0)
    if known.mean() < 0.01:
        raise EnvLightsError("depth must hold finite numbers above 0; less than 1 % are")
    values = np.where(known, values, np.nan)
    name, notes = _reading(values, reading)
    distance = READINGS[name](values, pixel_directions(*values.shape))
    return np.where(known, distance, np.inf), [*notes, *_doubts(distance)]


def corners_of(room: ArrayLike, camera: ArrayLike | None) -> tuple[Reals, Reals]:
    """Least and largest coordinates of a box, from the camera; see `place`."""
    size = triple("room", room)
    if not (size > 0).all():
        raise EnvLightsError(f"room must have positive sides in metres; got {size.tolist()}")
    inside = size / 2 if camera is None else triple("camera", camera)
    if not ((inside > 0) & (inside < size)).all():
        raise EnvLightsError(
            f"camera must lie in the room of {size.tolist()} m, measured from the corner with the"
            f" least x, y and z; got {inside.tolist()}"
        )
    return -inside, size - inside


def box_distance(corners: tuple[Reals, Reals], height: int) -> Reals:
    """Distance of the walls of a box along the ray of each pixel."""
    ray, (low, high) = pixel_directions(height, 2 * height), corners
    with np.errstate(divide="ignore"):
        distance: Reals = np.where(ray > 0, high / ray, low / ray).min(axis=-1)
    return distance


def triple(name: str, values: ArrayLike) -> Reals:
    """Three finite numbers below 1e12, or a refusal that names them."""
    numbers = reals(name, values, 1)
    if numbers.shape != (3,) or not (np.abs(numbers) < 1e12).all():
        raise EnvLightsError(
            f"{name} must be three finite numbers in metres; got {numbers.tolist()}"
        )
    return numbers


def _values(depth: Any, scale: float | None) -> Reals:
    """Samples of a depth map in metres, or one over metres."""
    is_file = isinstance(depth, str | os.PathLike)
    name = f"the depth in {depth}" if is_file else "depth"
    if isinstance(depth, list | tuple):
        reals(name, depth, None)
    array = _samples(os.fspath(depth)) if is_file else np.asarray(depth)
    array = array[..., 0] if array.shape[2:] == (1,) else array
    if array.ndim != 2 or array.shape[1] != 2 * array.shape[0] or len(array) < 16:
        raise EnvLightsError(
            f"{name} must have the shape (height, 2 * height), 16 rows or more, as a map that shows"
            f" the whole sphere; got {array.shape}"
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
            # A map of the file, because a header may claim more than the file has.
            return np.array(np.lib.format.open_memmap(path, mode="r"))
        except (OSError, *DAMAGE) as error:
            raise EnvLightsError(f"cannot read the depth in {path}: {error}") from None
    source = named_source(path)
    file = open_native(source, kind_of(source, any_format=False), MOST_PIXELS)
    for part, each in enumerate(file.parts):
        names = [name for name in each.channels if name.lower() in _CHANNELS][:1]
        # A picture of grey, perhaps stored as three equal channels.
        names = names or (list(each.channels) if len(each.channels) in (1, 3) else [])
        samples = file.image(part, names).samples if names else np.zeros((1, 1, 0))
        if names and np.array_equal(samples[..., 1:], samples[..., :-1], equal_nan=True):
            return samples[..., 0]
    channels = ", ".join(name for each in file.parts for name in each.channels)
    raise EnvLightsError(
        f"{path} has no channel of depth, such as Z, and is not grey; it has {channels}"
    )


def _reading(values: Reals, wanted: str | None) -> tuple[str, list[str]]:
    """Reading of samples of depth, and a note on it, or a refusal of one that contradicts them."""
    if wanted is not None:
        check_choice("reading", wanted, tuple(READINGS))
    if np.nanmax(values) - np.nanmin(values) < 1e-6 * np.nanmax(values):  # a sphere
        return wanted or "ray", []
    with np.errstate(all="ignore"):
        flat = flatness(values)
    if np.isnan(list(flat.values())).any():
        if wanted is None:
            raise EnvLightsError(
                "depth is unknown around nearly every pixel, so flat surfaces do not show how it"
                f" was stored; give reading=, one of {', '.join(map(repr, READINGS))}"
            )
        return wanted, []
    best = min(flat, key=flat.__getitem__)
    words = ", ".join(f"'{name}' {percent(value)}" for name, value in flat.items())
    facts = f"surfaces differ from planes by {words}"
    if wanted is not None and flat[best] < 0.6 * flat[wanted] and flat[wanted] > 0.005:
        raise EnvLightsError(
            f"the depth contradicts reading='{wanted}': {facts}; give reading='{best}', or leave it"
            " out"
        )
    name = wanted or (best if flat[best] < 0.95 * flat["ray"] else "ray")
    unit = " in 1 / m" * (name == "inverse")
    notes = [] if wanted else [f"the depth was read as '{name}'{unit}: {facts}"]
    if flat[name] > 0.06:
        notes.append(
            f"the depth shows no flat surfaces ({percent(flat[name])}), so positions are doubtful:"
            " is it inverted, relative, or of another map?"
        )
    return name, notes


def _doubts(distance: Reals) -> list[str]:
    """Notes on depth that is incomplete, or too large for a room."""
    notes, known = [], np.isfinite(distance)
    bottom = distance[-len(distance) // 8 :]
    floor = np.median(bottom[np.isfinite(bottom)]) if np.isfinite(bottom).any() else 1.0
    if not 1 / _FARTHEST_FLOOR < floor < _FARTHEST_FLOOR:
        notes.append(
            f"the depth puts the floor {floor:.4g} m below the camera, so its unit is doubtful;"
            " give scale=0.001 for millimetres"
        )
    if known.mean() < 1:
        is_sky = known.mean() < 1 - _MOST_HOLES
        way = "stays at infinity" if is_sky else "is placed on the surfaces around them"
        notes.append(
            f"the depth is unknown for {percent(1 - known.mean())} of the pixels; their light {way}"
        )
    return notes


def without_holes(distance: Reals) -> Reals:
    """Distance with small unknown parts continued from around them; a sky stays infinite."""
    known = np.isfinite(distance)
    if known.all() or known.mean() < 1 - _MOST_HOLES:
        return distance
    inverse = np.where(known, 1 / distance, 0)[..., None]
    grey = EnvMap(inverse.repeat(3, axis=2), coverage=known.astype(np.float32)).filled("harmonic")
    return np.where(known, distance, 1 / np.maximum(grey.radiance[..., 0], 1e-12))
