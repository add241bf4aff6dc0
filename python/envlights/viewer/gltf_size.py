"""Memory that a glTF file asks for, checked before a library allocates it."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from envlights._native import EnvLightsError

_COLUMNS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
#: Bytes of a number by the constants of OpenGL: bytes, shorts, integers and floats.
_BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}


def check_size(path: Path, most: int) -> None:
    """Refuse arrays or meshes of more than `most` bytes that are larger than the file itself.

    An array without data is zeros, and each mesh gets a copy of its arrays.
    """
    try:
        header = _header(path)
        sizes = [_size(accessor) for accessor in header.get("accessors", ())]
        copied = sum(sizes[row] for row in _arrays_of_meshes(header))
        held = path.stat().st_size + sum(_buffers(path, header))
    except (ArithmeticError, AttributeError, LookupError, struct.error, TypeError, ValueError) as x:
        raise EnvLightsError(
            f"it is not a complete glTF file ({type(x).__name__}: {x}); export it again"
        ) from None
    needed = max(sum(sizes), copied)
    if needed > max(most, held):
        raise EnvLightsError(
            f"its arrays would need {needed / 1e6:.0f} MB, but its files have"
            f" {held / 1e6:.3g} MB; export it again, for example as GLB"
        )


def _header(path: Path) -> Any:
    """JSON of a .gltf file, or of the first chunk of a .glb file."""
    content = path.read_bytes()
    if content[:4] == b"glTF":
        content = content[20 : 20 + struct.unpack_from("<I", content, 12)[0]]
    return json.loads(content)


def _size(accessor: Any) -> int:
    """Bytes of the array of an accessor."""
    return (
        abs(int(accessor["count"])) * _COLUMNS[accessor["type"]] * _BYTES[accessor["componentType"]]
    )


def _arrays_of_meshes(header: Any) -> Iterator[int]:
    """Rows of the accessors that each mesh copies."""
    for mesh in header.get("meshes", ()):
        for primitive in mesh["primitives"]:
            yield from primitive["attributes"].values()
            if "indices" in primitive:
                yield primitive["indices"]


def _buffers(path: Path, header: Any) -> Iterator[int]:
    """Bytes of each file beside this one that holds a buffer."""
    for name in {buffer.get("uri", "data:") for buffer in header.get("buffers", ())}:
        file = path.parent / unquote(name)
        yield file.stat().st_size if not name.startswith("data:") and file.is_file() else 0
