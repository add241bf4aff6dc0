"""Picture sources: one picture, or six cube faces as list, mapping, folder or pattern."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import count, describe
from envlights._common.errors import FileError
from envlights._native import EnvLightsError
from envlights.environment.decoders.source import AnySource, is_source, name_of
from envlights.environment.files.images import (
    MOST_PIXELS,
    Image,
    open_image,
    read_image,
    whole_image,
)
from envlights.environment.layouts.face_names import order_of_names
from envlights.environment.layouts.faces import check_square

#: Suffixes of face files in a folder.
_SUFFIXES = {".hdr", ".exr", ".png", ".jpg", ".jpeg", ".tif", ".tiff", ".pic", ".rgbe"}
#: Wildcards for the face name in a pattern; "%" is used by exrenvmap.
_WILDCARDS = ("{face}", "%", "*")

#: One file, or six files: a sequence, a mapping from names, a folder, or a name with "{face}", "*"
#: or "%".
PictureSource: TypeAlias = AnySource | Sequence[AnySource] | Mapping[str, AnySource]


class _Files(NamedTuple):
    """Six files, with their names without suffixes, and a name for messages."""

    name: str
    stems: list[str]
    files: list[AnySource]


def is_picture_source(value: Any) -> bool:
    """True for anything that is read as one file, or as six files of a cube."""
    if isinstance(value, Mapping):
        return bool(value) and all(map(is_source, value.values()))
    if isinstance(value, list | tuple):
        return bool(value) and all(map(is_source, value))
    return is_source(value)


def read_picture(source: Any, **options: Any) -> Image:
    """Read one picture in any projection, or six as a stack of cube faces.

    Parameters
    ----------
    source : path-like, bytes, file object, sequence, or mapping
        One file, as in `read_image`; a sequence or a mapping of six; a folder with six pictures; or
        a name with ``{face}``, ``*`` or ``%``, which matches six files.
    **options
        Options of `read_image`.

    Returns
    -------
    Image
        Of six files, the pixels are (6 n, n, 3) in the order that ``hints.order`` names. It is
        empty if the names do not determine one, and then the order is that of the source.

    Raises
    ------
    EnvLightsError
        If a file cannot be read, or there are not six squares of one size.
    """
    files = six_files(source)
    if files is None:
        return read_image(source, any_projection=True, **options)
    order, positions = _order(files)
    most = count("max_pixels", options.get("max_pixels", MOST_PIXELS), least=1)
    options["max_pixels"] = max(most // 6, 1)
    images = [_face(files.files[place], options) for place in positions]
    if not any(_share(image).any() for image in images):
        images = [read_image(files.files[place], **options) for place in positions]
    names = [name_of(files.files[place]) for place in positions]
    check_square(dict(zip(names, (image.pixels.shape[:2] for image in images), strict=True)))
    return _stack_of(files.name.split(": ")[0], order, images)


def _face(source: Any, options: dict[str, Any]) -> Image:
    """Face in a file, which alpha may hide."""
    with open_image(source, **options) as file:
        return whole_image(file, is_face=True)


def faces_of_mapping(faces: Mapping[str, Any]) -> tuple[NDArray[Any], str]:
    """Six arrays by face name as one array, (6, n, n, ...), and the order of its faces.

    Parameters
    ----------
    faces : mapping
        Arrays by names like "px", "posx", "front" or "F", as py360convert gives them.

    Raises
    ------
    EnvLightsError
        If the names are of no convention, or the arrays are no squares of one size.
    """
    stems = [str(key) for key in faces]
    arrays = [_array(stem, face) for stem, face in zip(stems, faces.values(), strict=True)]
    named = order_of_names(stems) if len(stems) == 6 else None
    if named is None:
        raise EnvLightsError(_no_order("a mapping", stems))
    each = zip(stems, arrays, strict=True)
    check_square({stem: (*array.shape, 0, 0)[:2] for stem, array in each})
    kinds = list(dict.fromkeys((array.shape, str(array.dtype)) for array in arrays))
    if len(kinds) > 1:
        seen = " and ".join(f"{kind} {shape}" for shape, kind in kinds[:2])
        raise EnvLightsError(f"the faces must have one shape and one dtype; got {seen}")
    return np.stack([arrays[place] for place in named.positions]), named.order


def _array(name: str, values: Any) -> NDArray[Any]:
    try:
        return np.asarray(values)
    except ValueError as error:  # lists of several lengths
        raise EnvLightsError(f"face {name} must be an array of numbers; {error}") from None


def six_files(source: Any) -> _Files | None:
    """Six files of a source; None if the source is a single file."""
    if isinstance(source, Mapping):
        return _six_of("the mapping", [str(key) for key in source], list(source.values()))
    if isinstance(source, str | os.PathLike):
        return _files_of_path(os.fspath(source))
    if isinstance(source, bytes | bytearray | memoryview) or hasattr(source, "read"):
        return None
    if isinstance(source, Sequence):
        return _six_of("the list", [_stem(file) for file in source], list(source))
    return None


def _files_of_path(text: str | bytes) -> _Files | None:
    """Six files of a folder or pattern; None for the path of a single file."""
    text = os.fsdecode(text)
    if not text or "\0" in text:
        return None
    try:
        path = Path(text)
        if path.is_dir():
            each = sorted(file for file in path.iterdir() if file.suffix.lower() in _SUFFIXES)
        elif any(mark in path.name for mark in _WILDCARDS) and not path.exists():
            each = sorted(path.parent.glob(_pattern(path.name)))
        else:
            return None
    except (OSError, ValueError):  # a name that is too long, or a folder that is not readable
        return None
    if not each and not path.is_dir() and "{face}" not in text:
        return None  # a missing file whose name holds % or *
    name = f"{text}: it is a folder, which" if path.is_dir() else f"{text}: the pattern"
    return _six_of(name, [file.stem for file in each], list(each))


def _pattern(name: str) -> str:
    """Glob pattern for a file name with wildcards; `[` and `?` in the name are literal."""
    marked = name
    for mark in _WILDCARDS:
        marked = marked.replace(mark, "\0")
    return marked.replace("[", "[[]").replace("?", "[?]").replace("\0", "*")


def _six_of(name: str, stems: list[str], files: list[AnySource]) -> _Files:
    if len(files) != 6:
        some = f" ({', '.join(stems[:6])}{', ...' if len(stems) > 6 else ''})" if any(stems) else ""
        raise FileError(
            f"cannot read {name} holds {len(files)} pictures{some}, and a cube map has six faces;"
            " give one file, or six as a list, a mapping, a folder, or a name such as"
            " 'sky_{face}.hdr'"
        )
    return _Files(name, stems, files)


def _stem(file: Any) -> str:
    """File name without folder and suffix; empty for bytes."""
    return Path(os.fsdecode(file)).stem if isinstance(file, str | os.PathLike) else ""


def _order(files: _Files) -> tuple[str, tuple[int, ...]]:
    """Convention that the names imply, and the file index of each of its faces."""
    named = order_of_names(files.stems)
    if named:
        return named.order, named.positions
    return "", tuple(range(6))


def _no_order(name: str, stems: list[str]) -> str:
    return (
        f"{name} of the faces of a cube has names such as px nx py ny pz nz, or front right back"
        f" left up down; got {describe(', '.join(stems[:8]))}"
    )


def _stack_of(name: str, order: str, images: list[Image]) -> Image:
    """Six images as a stack, (6 n, n, 3)."""
    first = images[0]
    notes = dict.fromkeys(note for image in images for note in image.notes)
    coverage = None
    if any(image.coverage is not None for image in images):
        coverage = np.concatenate([_share(image) for image in images])
    return replace(
        first,
        pixels=np.concatenate([image.pixels for image in images]),
        border_sampled=False,
        notes=tuple(notes),
        clip_level=_clip_level(images),
        coverage=coverage,
        ev100=first.ev100 if len({image.ev100 for image in images}) == 1 else None,
        units=_units(images),
        hints=first.hints._replace(name=name, order=order, border_sampled=False, layout=""),
    )


def _units(images: list[Image]) -> str:
    """Common unit of all images; raises an error if they differ."""
    units = {image.units for image in images}
    if len(units) > 1:
        raise EnvLightsError(
            "the faces of a cube must have one scale; some files have luminance in cd/m2"
            " (whiteLuminance), others do not; give files of one origin"
        )
    return units.pop()


def _share(image: Image) -> NDArray[np.float32]:
    return np.ones(image.pixels.shape[:2], np.float32) if image.coverage is None else image.coverage


def _clip_level(images: list[Image]) -> float | None:
    """Lowest clip level of the faces; None if a face has no clip level."""
    known = [image.clip_level for image in images if image.clip_level is not None]
    return min(known) if len(known) == len(images) else None
