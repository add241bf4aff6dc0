"""Registry of the targets that lights and rigs can be written for; `envlights.export` fills it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from numpy.typing import ArrayLike

from envlights._native import EnvLightsError
from envlights.envmap import EnvMap
from envlights.io.files import PICTURES, as_path

#: End of the name of a map that a program reads as a panorama in our axes.
PANORAMA = ".ambient.exr"


class Target(NamedTuple):
    """Program or format that rigs can be exported to."""

    name: str
    """Name of its module and of its public function."""

    title: str
    """Full name."""

    suffixes: tuple[str, ...]
    """Suffixes in lower case, the usual one first."""

    save: Callable[..., None]
    """Writer: takes a rig or lights, a path, and an `environment` map if it accepts one."""

    takes_map: bool
    """True if the ambient term can be a map."""

    keeps: str
    """Parts of a rig that it keeps."""

    loses: str
    """Parts of a rig that it loses."""

    texture: str = ""
    """End of the name of the map beside a file; empty if there is no such map.

    For `PANORAMA` the writer accepts the keyword `texture`, the name of an existing map."""


_TARGETS: list[Target] = []
_LOADERS: list[Callable[[], object]] = []

#: Suffixes that no target has, and advice for each.
_INSTEAD = {
    ".blend": "give .py, a script that Blender runs",
    ".glb": "give .gltf",
    ".usdz": "give .usda",
    **dict.fromkeys(PICTURES, "`plot.save` writes pictures"),
    **dict.fromkeys((".exr", ".hdr"), "`to_map` makes a map, whose `save` writes it"),
}


def register(added: Iterable[Target]) -> None:
    """Add targets to those that `save` knows."""
    _TARGETS.extend(added)


def register_later(load: Callable[[], object]) -> None:
    """Call `load`, which registers targets, before they are first needed."""
    _LOADERS.append(load)


def targets() -> tuple[Target, ...]:
    """All registered targets."""
    for load in _LOADERS:
        load()
    return tuple(_TARGETS)


def target_of(path: str | os.PathLike[str]) -> Target:
    """Target of a file name; the longest matching suffix decides."""
    name = as_path(path).name.lower()[1:]
    fits = [
        (len(suffix), target)
        for target in targets()
        for suffix in target.suffixes
        if name.endswith(suffix)
    ]
    if not fits:
        wanted = ", ".join(suffix for target in targets() for suffix in target.suffixes)
        hint = _INSTEAD.get(as_path(path).suffix.lower())
        raise EnvLightsError(
            f"cannot write {path}: {f'{hint}; ' if hint else ''}the suffix must be one of {wanted}"
        )
    return max(fits, key=lambda fit: fit[0])[1]


def save(
    rig: Any,
    path: str | os.PathLike[str],
    environment: EnvMap | ArrayLike | None = None,
) -> None:
    """Write a rig, or lights alone, in the format that the suffix of `path` names.

    Parameters
    ----------
    rig : Rig or Lights
    path : path-like
        Textures are written beside it, ``scene.ambient.exr`` beside ``scene.usda``.
    environment : EnvMap or array_like, optional
        Map that replaces the ambient term, such as the remainder of a split map.

    Raises
    ------
    EnvLightsError
        If the suffix is unknown, the target accepts no map but `environment` is one, or the file
        cannot be written.
    """
    target = target_of(path)
    if environment is None:
        target.save(rig, path)
    elif target.takes_map:
        target.save(rig, path, environment)
    else:
        raise EnvLightsError(f"cannot write {path}: {target.title} accepts no environment map")
