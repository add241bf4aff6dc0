"""Export of rigs and lights to other programs, each in its own axes and units.

| step                                                     | file           |
|----------------------------------------------------------|----------------|
| lights, and a constant or a map around them              | `scene.py`     |
| from our frame to the target's                           | `axes.py`      |
| from lux and cd/m2 to the target's units                 | `units.py`     |
| cards as panels in front of the map                      | `panels.py`    |
| pixels of a map in given directions                      | `look_up.py`   |
| textures beside the file, and the file last              | `files.py`     |
| the package's own JSON                                   | `own_json.py`  |
| a table of numbers                                       | `csv.py`       |
| glTF 2.0                                                 | `gltf.py`      |
| three.js                                                 | `three.py`     |
| OpenUSD                                                  | `usd.py`       |
| MuJoCo                                                   | `mujoco.py`    |
| Godot 4                                                  | `godot.py`     |
| Unity, Unreal, and engines with axes to choose           | `engine.py`    |
| Mitsuba 3                                                | `mitsuba.py`   |
| Blender                                                  | `blender.py`   |
| discs in a map, for targets whose lights have no size    | `discs.py`     |
| Radiance                                                 | `radiance.py`  |
| pbrt-v4                                                  | `pbrt.py`      |
| table of targets: suffixes, and what each can show     | `targets.py`   |

Cards of a target are in a file of its name and `_cards`; `three_things.py` and `usd_text.py` hold
the parts that both files of a target need.

Each target has a file with two functions: one with its name, which returns the target's own form,
and one with `save_` and its name, which writes a file. `save` selects the target by the suffix.
"""

from envlights.export.axes import AXES, Axes
from envlights.export.blender import add_to_blender, blender, save_blender
from envlights.export.csv import csv, save_csv
from envlights.export.engine import engine, save_engine, save_unity, save_unreal, unity, unreal
from envlights.export.gltf import gltf, save_gltf
from envlights.export.godot import godot, save_godot
from envlights.export.mitsuba import mitsuba, save_mitsuba
from envlights.export.mujoco import mujoco, save_mujoco
from envlights.export.pbrt import pbrt, save_pbrt
from envlights.export.radiance import radiance, save_radiance
from envlights.export.targets import TARGETS
from envlights.export.three import save_three, three
from envlights.export.usd import save_usd, usd
from envlights.rigs.csv_table import read_csv
from envlights.rigs.targets import Target, save, target_of

__all__ = [
    "AXES",
    "TARGETS",
    "Axes",
    "Target",
    "add_to_blender",
    "blender",
    "csv",
    "engine",
    "gltf",
    "godot",
    "mitsuba",
    "mujoco",
    "pbrt",
    "radiance",
    "read_csv",
    "save",
    "save_blender",
    "save_csv",
    "save_engine",
    "save_gltf",
    "save_godot",
    "save_mitsuba",
    "save_mujoco",
    "save_pbrt",
    "save_radiance",
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


def __dir__() -> list[str]:
    return sorted(__all__)
