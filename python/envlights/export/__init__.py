"""Rigs and lights for other programs, each in its own axes and units.

| step                                                     | file           |
|----------------------------------------------------------|----------------|
| lights, and a constant or a map around them              | `scene.py`     |
| from our frame to the target's                           | `axes.py`      |
| textures beside the file, and the file last              | `files.py`     |
| the package's own JSON                                   | `own_json.py`  |
| a table of numbers                                       | `csv.py`       |
| glTF 2.0                                                 | `gltf.py`      |
| three.js                                                 | `three.py`     |
| Mitsuba 3                                                | `mitsuba.py`   |
| which suffix is which target, what it keeps and loses    | `targets.py`   |

A target is a file here. Its public function has its name and returns the target's own form; `save_`
and its name writes that at a path. `save` takes the target from the suffix.
"""

from envlights.export.axes import AXES, Axes
from envlights.export.csv import csv, read_csv, save_csv
from envlights.export.gltf import gltf, save_gltf
from envlights.export.mitsuba import mitsuba, save_mitsuba
from envlights.export.targets import TARGETS, Target, save, target_of
from envlights.export.three import save_three, three

__all__ = [
    "AXES",
    "TARGETS",
    "Axes",
    "Target",
    "csv",
    "gltf",
    "mitsuba",
    "read_csv",
    "save",
    "save_csv",
    "save_gltf",
    "save_mitsuba",
    "save_three",
    "target_of",
    "three",
]
