"""Conversion of arguments (files, arrays, maps) to maps, with reading options."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from inspect import signature
from typing import Any, TypeAlias, TypeVar

from numpy.typing import ArrayLike

from envlights._common.check import describe
from envlights._native import EnvLightsError, UnusableSamplesError
from envlights.environment.envmap import EnvMap
from envlights.environment.open import unchecked_map
from envlights.environment.picture_files import PictureSource, is_picture_source

_T = TypeVar("_T")

#: Map, its file as path, bytes or file object, six files of a cube, or radiance as an array.
AnyMap: TypeAlias = EnvMap | PictureSource | ArrayLike
#: Options for reading a file: arguments of `EnvMap.open`, `levelled`, `calibrated`, `rotated`.
Reading: TypeAlias = Mapping[str, Any]
#: Methods that are called after opening a file.
_STEPS = ("levelled", "calibrated", "rotated")


def as_envmap(env: Any, reading: Reading | None = None) -> EnvMap:
    """Map of an `AnyMap`, read with the options `reading`; a map is returned unchanged."""
    if isinstance(env, EnvMap):
        return env
    is_file = is_picture_source(env)
    opened, *steps = _steps(reading, EnvMap.open if is_file else EnvMap)
    world = EnvMap.open(env, **opened) if is_file else EnvMap(env, **opened)
    for name, given in zip(_STEPS, steps, strict=True):
        if given.keys() - {"fill"}:  # a fill without a meter reading does not calibrate
            world = getattr(world, name)(**given)
    return world


def check_reading(reading: Reading | None) -> None:
    """Raise an error for unknown reading options, before a file is read."""
    _steps(reading, EnvMap.open)


def _steps(reading: Reading | None, opener: Callable[..., Any]) -> list[dict[str, Any]]:
    """Arguments of the opener and of each method; raises an error for unknown options."""
    if reading is None:
        return [{}, *({} for _ in _STEPS)]
    if not isinstance(reading, Mapping):
        raise EnvLightsError(
            "reading must map names of options on how a map is read to values, such as"
            f" {{'colour': 'srgb', 'lux': 900}}; got {describe(reading)}"
        )
    functions = (opener, *(getattr(EnvMap, name) for name in _STEPS))
    names = [[*signature(each).parameters][1:] for each in functions]
    known = [name for each in names for name in each]
    for name in reading:
        if name not in known:
            raise EnvLightsError(
                f"reading must hold options on how a map is read, {', '.join(known)}; got"
                f" {describe(name)}"
            )
    return [{name: reading[name] for name in each if name in reading} for each in names]


def apply_to_map(env: Any, work: Callable[[EnvMap], _T]) -> tuple[EnvMap, _T]:
    """Map of an `AnyMap`, and the result of `work` on it.

    An array is cleaned only if a kernel refuses it.

    Kernels read every sample anyway and refuse those that are not radiance, so the usual array
    needs no check of its own.
    """
    if isinstance(env, EnvMap) or is_picture_source(env):
        world = as_envmap(env)
        return world, work(world)
    try:
        world = EnvMap._of(unchecked_map(env))
        return world, work(world)
    except UnusableSamplesError:
        world = EnvMap(env)
        return world, work(world)
