"""Lossless JSON of the package, with format, version, frame and units."""

from __future__ import annotations

import json
import os

from envlights._common.units import statement
from envlights.export.files import save_scene
from envlights.rigs.lights import LIGHTS_HEADER, Lights
from envlights.rigs.rig import Rig


def save_json(rig: Rig | Lights, path: str | os.PathLike[str]) -> None:
    """Write the result of `to_dict`, which `load` of the same class reads."""
    data = rig.to_dict()
    if "format" not in data:
        units = f"{LIGHTS_HEADER['units']}; {statement(data['scale'])}"
        data = {**LIGHTS_HEADER, "units": units, **data}
    save_scene(path, json.dumps(data, indent=2, allow_nan=False) + "\n")
