"""Export of rigs and lights to other programs, each in its own axes and units.

| step                                                     | file           |
|----------------------------------------------------------|----------------|
| table of targets: suffixes, axes, units, and what each can show | `targets.py` |
| error of a rig as a target shows it                      | `capabilities.py` |
| format of a suffix, and warnings about losses            | `saving.py`    |
| several files with one map                               | `links.py`     |
| lights, and a constant or a map around them              | `scene.py`     |
| from our frame to the target's                           | `../frames.py` |
| from lux and cd/m2 to the target's units                 | `units.py`     |
| scale of pixels that end at 1                            | `exposure.py`  |
| cards as panels in front of the map                      | `panels.py`    |
| discs in a map, for targets whose lights have no size    | `discs.py`     |
| pixels of a map in given directions                      | `look_up.py`   |
| textures beside the file, and the file last              | `textures.py`, `files.py` |
| one file for each target, and readers of our own JSON and CSV | `formats/` |

Each target has two functions: one with its name, which returns the target's own form, and one with
`save_` and its name, which writes a file. `save` selects the target by the suffix. A target's file
is imported when it is first used.
"""

from typing import TYPE_CHECKING

from envlights.export.formats.csv_table import read_csv
from envlights.export.saving import save
from envlights.export.targets import AXES, TARGETS, Target, function_named, target_of
from envlights.frames import Axes

if TYPE_CHECKING:
    from envlights.export.formats.blender import add_to_blender, blender, save_blender
    from envlights.export.formats.csv import csv, save_csv
    from envlights.export.formats.engine import (
        engine,
        save_engine,
        save_unity,
        save_unreal,
        unity,
        unreal,
    )
    from envlights.export.formats.gltf import gltf, save_gltf
    from envlights.export.formats.godot import godot, save_godot
    from envlights.export.formats.mitsuba import mitsuba, save_mitsuba
    from envlights.export.formats.mujoco import mujoco, save_mujoco
    from envlights.export.formats.pbrt import pbrt, save_pbrt
    from envlights.export.formats.radiance import radiance, save_radiance
    from envlights.export.formats.simulators import genesis, sapien, save_genesis, save_sapien
    from envlights.export.formats.three import save_three, three
    from envlights.export.formats.usd import save_usd, usd

__all__ = [
    "AXES",
    "TARGETS",
    "Axes",
    "Target",
    "add_to_blender",
    "blender",
    "csv",
    "engine",
    "genesis",
    "gltf",
    "godot",
    "mitsuba",
    "mujoco",
    "pbrt",
    "radiance",
    "read_csv",
    "sapien",
    "save",
    "save_blender",
    "save_csv",
    "save_engine",
    "save_genesis",
    "save_gltf",
    "save_godot",
    "save_mitsuba",
    "save_mujoco",
    "save_pbrt",
    "save_radiance",
    "save_sapien",
    "save_three",
    "save_unity",
    "save_unreal",
    "save_usd",
    "target_of",
    "three",
    "unity",
    "unreal",
    "usd",
]


def __getattr__(name: str) -> object:
    if name not in __all__:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return function_named(name)


def __dir__() -> list[str]:
    return sorted(__all__)
