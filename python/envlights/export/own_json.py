"""The package's own JSON: everything, without loss, with its format, version, frame and units."""

from __future__ import annotations

import json
import os

from envlights.export.files import save_scene
from envlights.kernels.sphere import FRAME
from envlights.lights import Lights
from envlights.rig import Rig

#: Of lights alone, whose `to_dict` is a part of other formats too.
_LIGHTS = {
    "format": "envlights lights",
    "version": 1,
    "frame": FRAME,
    "units": "irradiance: at normal incidence; linear Rec.709 RGB; angular_radius: radians",
}


def save_json(rig: Rig | Lights, path: str | os.PathLike[str]) -> None:
    """Write all that `to_dict` gives; `load` of the same class reads it back."""
    data = rig.to_dict()
    if "format" not in data:
        data = {**_LIGHTS, **data}
    save_scene(path, json.dumps(data, indent=2, allow_nan=False) + "\n")
