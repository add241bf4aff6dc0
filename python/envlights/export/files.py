"""A scene and its textures on disk: each whole or not at all, the scene last."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights.io.files import as_path, check_writable, write_atomically
from envlights.io.image_output import write_exr, write_hdr


def texture_name(path: str | os.PathLike[str], kind: str = "ambient") -> str:
    """The name of a texture beside `path`: ``scene.ambient.exr`` beside ``scene.usda``.

    A map that one target alone can read has another `kind`, such as "ambient.mitsuba", so that
    files for several targets stand in one folder.
    """
    return f"{as_path(path).stem}.{kind}.exr"


def save_scene(
    path: str | os.PathLike[str],
    content: str | bytes,
    textures: Mapping[str, NDArray[Any]] | None = None,
) -> None:
    """Write textures, (height, width, 3) by their names beside `path`, and then the scene.

    So no scene stands there that names a texture which is missing. Textures are OpenEXR files, or
    Radiance pictures where their names end in ``.hdr``.
    """
    folder = as_path(path).parent
    places = {folder / name: radiance for name, radiance in (textures or {}).items()}
    for place in (*places, path):
        check_writable(place)
    for place, radiance in places.items():
        write = write_hdr if place.suffix == ".hdr" else write_exr
        write(place, np.ascontiguousarray(radiance, np.float32))
    data = content.encode() if isinstance(content, str) else content
    write_atomically(path, lambda beside: beside.write_bytes(data))
