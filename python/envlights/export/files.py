"""Writer of a scene and its textures; the scene comes last."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any
from unicodedata import category

import numpy as np
from numpy.typing import NDArray

from envlights._check import describe
from envlights._native import EnvLightsError
from envlights.io.files import as_path, check_writable, write_atomically
from envlights.io.image_output import write_exr, write_hdr

#: Control characters of ASCII and of Latin 1.
CONTROLS = tuple(map(chr, (*range(32), *range(127, 160))))


def texture_name(path: str | os.PathLike[str], kind: str = "ambient") -> str:
    """Name of a texture beside `path`: ``scene.ambient.exr`` beside ``scene.usda``.

    A map that only one target can read has its own `kind`, such as "ambient.mitsuba", so that
    files for several targets can share a folder.
    """
    return f"{as_path(path).stem}.{kind}.exr"


def check_link(name: str, target: str, refused: Iterable[str] = ()) -> None:
    """Refuse the name of a texture that `target` would not read back from a scene.

    Parameters
    ----------
    name : str
        Name or path of the texture, as the scene holds it.
    target : str
        Title of the program, for the refusal.
    refused : iterable of str
        Characters or words that mean something else in the files of this program. Bytes that are
        not UTF-8 are refused for all programs.
    """
    # Python keeps undecodable bytes as halves of surrogate pairs.
    bad = [letter for letter in name if category(letter) == "Cs"]
    bad += [each for each in refused if each in name]
    if bad:
        raise EnvLightsError(
            f"{target} cannot read a texture whose name holds {bad[0]!a}; got"
            f" {describe(name)}; give the scene another name"
        )


def save_scene(
    path: str | os.PathLike[str],
    content: str | bytes,
    textures: Mapping[str, NDArray[Any]] | None = None,
) -> None:
    """Write textures, (height, width, 3) by their names beside `path`, and then the scene.

    The order ensures that no scene names a missing texture. Textures are OpenEXR files, or
    Radiance pictures if their names end in ``.hdr``.
    """
    folder = as_path(path).parent
    places = {folder / name: radiance for name, radiance in (textures or {}).items()}
    for place in (*places, path):
        check_writable(place)
    for place, radiance in places.items():
        write = _write_for_radiance if place.suffix == ".hdr" else write_exr
        write(place, np.ascontiguousarray(radiance, np.float32))
    data = content.encode() if isinstance(content, str) else content
    write_atomically(path, lambda beside: beside.write_bytes(data))


def _write_for_radiance(path: Path, radiance: NDArray[np.float32]) -> None:
    """Write a picture for the programs of Radiance."""
    write_hdr(path, radiance, rounds=False)
