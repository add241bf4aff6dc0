"""Reader for files of a rig, of lights or of detected lights."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Callable

from envlights._common.errors import FileError
from envlights._common.files import MAPS, as_path, read_text
from envlights._common.printable import printable
from envlights.detection.lights import DetectedLights
from envlights.export.formats.csv_table import read_csv
from envlights.rigs.lights import Lights
from envlights.rigs.rig import Rig

#: Suffixes of the native file formats.
SUFFIXES = (".json", ".csv")
#: Readers by the value of `format` in the file.
_READERS: dict[str, Callable[[str | os.PathLike[str]], Lights]] = {
    "envlights lights": Lights.load,
    "envlights detected lights": DetectedLights.load,
}


def load_lights(path: str | os.PathLike[str]) -> Rig | Lights:
    """Rig or lights of a file; raises an error for other files."""
    suffix = as_path(path).suffix.lower()
    if suffix in MAPS:
        raise FileError(
            f"{printable(str(path))} is a picture, not a rig: `envlights fit` or `el.fit` makes a"
            " rig of it, which can then be exported"
        )
    if suffix == ".csv":
        return Lights.load(path) if read_csv(path).ambient is None else Rig.load(path)
    kind = None
    with contextlib.suppress(ValueError, RecursionError, AttributeError):
        kind = json.loads(read_text(path)).get("format")
    reader = _READERS.get(kind) if isinstance(kind, str) else None
    return reader(path) if reader else Rig.load(path)
