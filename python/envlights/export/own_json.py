"""The package's own JSON: everything, without loss."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING

from envlights.export.files import save_scene

if TYPE_CHECKING:
    from envlights.lights import Lights
    from envlights.rig import Rig


def save_json(rig: Rig | Lights, path: str | os.PathLike[str]) -> None:
    """Write all that `to_dict` gives; `load` of the same class reads it back."""
    save_scene(path, json.dumps(rig.to_dict(), indent=2, allow_nan=False) + "\n")
