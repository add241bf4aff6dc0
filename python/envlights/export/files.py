"""Writer for a scene and its textures; the scene is written last."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any
from unicodedata import category

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import describe
from envlights._common.files import as_path, check_writable, write_content
from envlights._native import EnvLightsError
from envlights.environment.files.image_output import write_exr, write_hdr

#: Name of a file.
AnyPath = str | os.PathLike[str]

#: Control characters of ASCII and of Latin 1.
CONTROLS = tuple(map(chr, (*range(32), *range(127, 160))))


def check_link(name: str, target: str, refused: Iterable[str] = ()) -> None:
    """Raise an error for a texture name that `target` could not read in a scene.

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
    # Undecodable bytes are lone surrogates in Python.
    bad = [letter for letter in name if category(letter) == "Cs"]
    bad += [each for each in refused if each in name]
    if bad:
        raise EnvLightsError(
            f"{target} cannot read a texture whose name holds {bad[0]!a}; got"
            f" {describe(name)}; give the scene another name"
        )


def json_text(data: Any, indent: int | None = 2) -> str:
    """Content of a JSON file, without NaN and infinity, which JSON does not have."""
    import json  # here, so that `import envlights` does not wait for it

    return json.dumps(data, indent=indent, allow_nan=False) + "\n"


def save_scene(
    path: AnyPath,
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
    write_content(path, content)


def _write_for_radiance(path: Path, radiance: NDArray[np.float32]) -> None:
    """Write a picture for the Radiance programs."""
    write_hdr(path, _dither(radiance), rounds=False)


def _dither(radiance: NDArray[np.float32]) -> NDArray[np.float32]:
    """Radiance dithered by up to half a mantissa step, so that means over pixels are exact.

    Radiance adds half a step to a mantissa. Without the dither, a map from a Radiance file, whose
    mantissas are whole already, was 0.3 % too bright. The additive recurrence R2 of M. Roberts
    (2018) gives neighbours different fractions of a step.
    """
    height, width, _ = radiance.shape
    row, column = np.ogrid[:height, :width]
    fraction = (0.7548776662466927 * column + 0.5698402909980532 * row) % 1 - 0.5
    _, exponent = np.frexp(radiance.max(axis=2))
    step = np.ldexp(np.float32(1 / 256), exponent)
    added = (fraction.astype(np.float32) * step)[..., None]
    dithered: NDArray[np.float32] = np.maximum(radiance + added, np.float32(0))
    return dithered
