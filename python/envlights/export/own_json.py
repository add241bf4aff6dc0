"""Lossless JSON of the package, with format, version, frame and units."""

from __future__ import annotations

import json
import os

from envlights._units import statement
from envlights.export.files import save_scene
from envlights.kernels.sphere import FRAME
from envlights.lights import Lights
from envlights.rig import Rig

#: Header of a file of lights, because `Lights.to_dict` holds only arrays.
_LIGHTS = {
    "format": "envlights lights",
    "version": 2,
    "frame": FRAME,
    "units": "irradiance: at normal incidence; linear Rec.709 RGB; angular_radius: radians",
}


def save_json(rig: Rig | Lights, path: str | os.PathLike[str]) -> None:
    """Write the result of `to_dict`, which `load` of the same class reads."""
    data = rig.to_dict()
    if "format" not in data:
        units = f"{_LIGHTS['units']}; {statement(data['scale'])}"
        data = {**_LIGHTS, "units": units, **data}
    save_scene(path, json.dumps(data, indent=2, allow_nan=False) + "\n")
