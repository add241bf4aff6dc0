"""Maps of a batch as an iterator: from files, folders, patterns, lists of paths, arrays."""

from __future__ import annotations

import json
import os
import re
import zlib
from collections.abc import Iterable, Iterator, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from envlights._common.check import describe
from envlights._common.errors import FileError, MissingFileError
from envlights._common.files import MAPS, matches, read_text
from envlights._common.printable import printable
from envlights._native import EnvLightsError
from envlights.environment.decoders.source import ADDRESS
from envlights.environment.envmap import EnvMap

#: Suffixes of path lists.
_LISTS = (".txt", ".jsonl")
#: Wildcard characters.
_PATTERN = re.compile(r"[*?\[]")


class Item(NamedTuple):
    """Map of a batch, not read yet."""

    name: str
    """Name of the row and the output file, without suffix."""

    source: str
    """Path or address, or the name of an array."""

    content: Any
    """Path, address, six files of a cube, `EnvMap` or array."""


def items_of(maps: Any, out: Path | None = None) -> Iterator[Item]:
    """Maps from the first argument of `batch`, each created when needed.

    Folders and patterns leave out the files of the folder `out`, where a split saves maps.
    """
    is_one = isinstance(maps, str | os.PathLike | EnvMap | np.ndarray | Mapping)
    if not is_one and not isinstance(maps, Iterable):
        raise EnvLightsError(
            f"maps must be paths, folders, patterns, arrays or an iterator; got {describe(maps)}"
        )
    for number, entry in enumerate([maps] if is_one else maps):
        yield from _items_of_entry(number, entry, out)


def _items_of_entry(number: int, entry: Any, out: Path | None) -> Iterator[Item]:
    name = f"map-{number:06}"
    if isinstance(entry, tuple) and len(entry) == 2 and isinstance(entry[0], str):
        name, entry = printable(entry[0]), entry[1]
        source = os.fsdecode(entry) if isinstance(entry, str | os.PathLike) else name
        yield Item(_file_name(name), source, entry)
    elif isinstance(entry, str | os.PathLike):
        yield from _items_of_text(os.fsdecode(entry), out)
    else:
        yield Item(name, name, entry)


def _file_name(name: str) -> str:
    """Checked `name`; raises an error if it would leave the output folder."""
    parts = re.split(r"[/\\]", name)
    if any(part in ("", ".", "..") for part in parts):
        raise EnvLightsError(f"the name of a map must name a file in the folder; got '{name}'")
    return name


def _items_of_text(text: str, out: Path | None) -> Iterator[Item]:
    """Maps from a path, folder, pattern, list of paths or address."""
    if ADDRESS.match(text):
        for address in _addresses(text):
            yield Item(_stem(address), address, address)
    elif Path(text).is_dir():
        yield from _items_of_folder(Path(text), out)
    elif Path(text).suffix.lower() in _LISTS and Path(text).is_file():
        yield from _items_of_list(Path(text))
    elif _PATTERN.search(text) and not Path(text).exists():
        for path in _matches(text, out):
            yield from _items_of_text(path, out)
    else:
        yield Item(_stem(text), text, text)


def _stem(path: str) -> str:
    name = path.replace("\\", "/").rstrip("/").rpartition("/")[2]
    return printable(Path(name).stem) or "map"


def _items_of_folder(folder: Path, out: Path | None) -> Iterator[Item]:
    found = (path for path in folder.rglob("*") if path.suffix.lower() in MAPS)
    paths = sorted(path for path in found if not _is_below(path, out))
    if not paths:
        raise EnvLightsError(
            f"the folder '{folder}' holds no map{_outside(out)}; a map has one of the suffixes"
            f" {', '.join(MAPS)}"
        )
    for path in paths:
        below = path.relative_to(folder).with_suffix("").as_posix()
        yield Item(printable(below), str(path), str(path))


def _is_below(path: str | Path, folder: Path | None) -> bool:
    """True if `path` is `folder` or lies in it."""
    # `Path.resolve` fails for circular links.
    real = os.path.realpath
    return folder is not None and Path(real(path)).is_relative_to(real(folder))


def _outside(out: Path | None) -> str:
    """End of the error message if the output folder was ignored."""
    return "" if out is None else f" outside of the folder of the results, '{out}'"


def _matches(pattern: str, out: Path | None) -> list[str]:
    paths = [path for path in matches(pattern) if not _is_below(path, out)]
    if not paths:
        raise MissingFileError(f"no file matches the pattern '{pattern}'{_outside(out)}")
    return paths


def _addresses(text: str) -> list[str]:
    """Addresses that match an fsspec pattern; without wildcards, the address itself."""
    if not _PATTERN.search(text):
        return [text]
    try:
        fsspec = import_module("fsspec")
    except ImportError:
        raise EnvLightsError(
            f"cannot list {printable(text)}: addresses are listed by fsspec, which is not"
            " installed; install it, or give paths"
        ) from None
    try:
        files, path = fsspec.core.url_to_fs(text)
        paths = sorted(files.glob(path))
    except Exception as error:  # each file system of fsspec has its own errors
        raise FileError(f"cannot list {printable(text)}: {printable(str(error))}") from None
    if not paths:
        raise MissingFileError(f"no file matches the pattern '{printable(text)}'")
    return [files.unstrip_protocol(each) for each in paths]


def _items_of_list(path: Path) -> Iterator[Item]:
    """Maps from a list with a path per line, or a JSON object with `path` and optional `name`."""
    for number, line in enumerate(read_text(path).splitlines(), 1):
        text = line.strip()
        if text and not text.startswith("#"):
            yield from _items_of_line(path, number, text)


def _items_of_line(path: Path, number: int, text: str) -> Iterator[Item]:
    data: Any = text
    if path.suffix.lower() == ".jsonl":
        try:
            data = json.loads(text)
        except ValueError:
            data = None
    entry = {"path": data} if isinstance(data, str) else data
    if not isinstance(entry, dict) or not isinstance(entry.get("path"), str):
        raise EnvLightsError(
            f"line {number} of {path} must be a path, or an object with the key 'path';"
            f" got {printable(text[:80])}"
        )
    place = entry["path"]
    source = place if ADDRESS.match(place) else str(path.parent / place)
    yield Item(_file_name(printable(str(entry.get("name") or _stem(source)))), source, source)


def with_unique_names(
    items: Iterable[Item], known: Mapping[str, str], used: set[str]
) -> Iterator[Item]:
    """Items with unique names: known names for known sources, otherwise with a hash of the source.

    A path that comes again is left out; the sources are added to `used`.
    """
    sources, names = {name: source for source, name in known.items()}, set[str]()
    for item in items:
        if item.source in used:
            if isinstance(item.content, str):
                continue
            raise EnvLightsError(f"two maps of the batch have the name '{item.name}'")
        used.add(item.source)
        name = known.get(item.source, item.name)
        while name in names or sources.get(name, item.source) != item.source:
            name = f"{name}-{zlib.crc32(item.source.encode('utf-8', 'surrogateescape')):08x}"
        names.add(name)
        yield item._replace(name=name)
