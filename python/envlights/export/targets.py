"""Which suffix is which target, and what the target keeps of a rig and loses."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from numpy.typing import ArrayLike

from envlights._native import EnvLightsError
from envlights.envmap import EnvMap
from envlights.export.blender import save_blender
from envlights.export.csv import save_csv
from envlights.export.engine import save_unity, save_unreal
from envlights.export.gltf import save_gltf
from envlights.export.mitsuba import save_mitsuba
from envlights.export.own_json import save_json
from envlights.export.pbrt import save_pbrt
from envlights.export.radiance import save_radiance
from envlights.export.three import save_three
from envlights.export.usd import save_usd
from envlights.io.files import PICTURES, as_path

if TYPE_CHECKING:
    from envlights.lights import Lights
    from envlights.rig import Rig


class Target(NamedTuple):
    """A program, or a format, for which rigs can be written."""

    name: str
    """The name of its file here, and of its public function."""

    title: str
    """Its own name."""

    suffixes: tuple[str, ...]
    """Ends of file names, in lower case; the first is the usual one."""

    save: Callable[..., None]
    """Takes a rig or lights and a path; then a map as `environment`, if it takes maps."""

    takes_map: bool
    """Whether the ambient term can be a map."""

    keeps: str
    loses: str


#: In the order in which the help lists them.
TARGETS = (
    Target(
        "json",
        "envlights itself",
        (".json",),
        save_json,
        False,
        "everything",
        "nothing",
    ),
    Target(
        "csv",
        "a table of numbers",
        (".csv",),
        save_csv,
        False,
        "lights, sizes, ambient, harmonics, error, floor",
        "report, notes",
    ),
    Target(
        "gltf",
        "glTF 2.0",
        (".gltf",),
        save_gltf,
        False,
        "lights",
        "sizes and the ambient term, which stand in extras",
    ),
    Target(
        "three",
        "three.js",
        (".three.json",),
        save_three,
        True,
        "lights, ambient, harmonics, floor, map",
        "sizes, which stand in userData",
    ),
    Target(
        "usd",
        "OpenUSD",
        (".usda", ".usdc", ".usd"),
        save_usd,
        True,
        "lights, sizes, ambient, harmonics (as a map), floor, map",
        "negative parts of harmonics",
    ),
    Target(
        "mitsuba",
        "Mitsuba 3",
        (".xml",),
        save_mitsuba,
        True,
        "lights, sizes (in a map), ambient, harmonics (as a map), floor, map",
        "negative parts of harmonics",
    ),
    Target(
        "blender",
        "Blender, a script",
        (".py",),
        save_blender,
        True,
        "lights, sizes, ambient, harmonics, floor, map",
        "negative parts of harmonics",
    ),
    Target(
        "radiance",
        "Radiance",
        (".rad",),
        save_radiance,
        True,
        "lights, sizes, ambient, harmonics, floor, map",
        "negative parts of harmonics",
    ),
    Target(
        "pbrt",
        "pbrt-v4",
        (".pbrt",),
        save_pbrt,
        True,
        "lights, sizes from 0.7 degrees, ambient, harmonics, floor, map",
        "smaller sizes, negative parts of harmonics",
    ),
    Target(
        "unity",
        "Unity",
        (".unity.json",),
        save_unity,
        True,
        "lights, sizes, ambient, harmonics, floor (as a map), map",
        "nothing that Unity has",
    ),
    Target(
        "unreal",
        "Unreal Engine",
        (".unreal.json",),
        save_unreal,
        True,
        "lights, sizes, ambient, harmonics, floor (as a map), map",
        "where the map looks: turn it by hand",
    ),
)

#: What is asked for at times, and what to write in its place.
_INSTEAD = {
    ".blend": "give .py, a script that Blender runs",
    ".glb": "give .gltf",
    ".usdz": "give .usda",
    **dict.fromkeys(PICTURES, "`plot.save` writes pictures"),
    **dict.fromkeys((".exr", ".hdr"), "`to_map` makes a map, whose `save` writes it"),
}
#: All that can be written.
SUFFIXES = tuple(suffix for target in TARGETS for suffix in target.suffixes)


def target_of(path: str | os.PathLike[str]) -> Target:
    """The target that the end of a file's name stands for; the longest one that fits."""
    name = as_path(path).name.lower()[1:]
    fits = [
        (len(suffix), target)
        for target in TARGETS
        for suffix in target.suffixes
        if name.endswith(suffix)
    ]
    if not fits:
        wanted = ", ".join(SUFFIXES)
        hint = _INSTEAD.get(as_path(path).suffix.lower())
        raise EnvLightsError(
            f"cannot write {path}: {f'{hint}; ' if hint else ''}the suffix must be one of {wanted}"
        )
    return max(fits, key=lambda fit: fit[0])[1]


def save(
    rig: Rig | Lights,
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
        A map in place of the ambient term, such as the rest of a split map.

    Raises
    ------
    EnvLightsError
        If the suffix is unknown, the target takes no map but is given one, or the file cannot be
        written.
    """
    target = target_of(path)
    if environment is None:
        target.save(rig, path)
    elif target.takes_map:
        target.save(rig, path, environment)
    else:
        raise EnvLightsError(f"cannot write {path}: {target.title} takes no map as environment")
