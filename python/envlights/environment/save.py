"""Files of a map: OpenEXR and Radiance."""

from __future__ import annotations

import os

from envlights._native import EnvLightsError
from envlights.environment.files.image_output import COMPRESSIONS, map_suffix, write_exr, write_hdr
from envlights.environment.pixels import MapPixels


def save_map(
    pixels: MapPixels, path: str | os.PathLike[str], *, half: bool, compression: str
) -> None:
    """Write a map to a file; see `EnvMap.save`."""
    if map_suffix(path) == ".hdr":
        if half or compression != COMPRESSIONS[0]:
            raise EnvLightsError(f"cannot save {path}: half and compression are of .exr files")
        write_hdr(path, pixels.cells(), comments=pixels.notes)
        return
    write_exr(
        path,
        pixels.radiance,
        half=half,
        compression=compression,
        environment="latlong" if pixels.is_border_sampled else "",
        comments=pixels.notes,
        units=pixels.units,
    )
