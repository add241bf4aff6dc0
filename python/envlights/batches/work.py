"""Work on one map: read, hash, fit and save. It is pickled, because it runs in worker processes."""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from envlights import _native
from envlights._common.check import count
from envlights._common.printable import printable
from envlights._native import EnvLightsError
from envlights.batches.rows import row_of
from envlights.detection.detect import detect
from envlights.environment.decoders.source import ADDRESS, is_source, named_source
from envlights.environment.envmap import EnvMap
from envlights.environment.files.image_output import MAP_SUFFIXES
from envlights.environment.picture_files import six_files
from envlights.environment.reading import Reading, as_envmap
from envlights.fitting.error_curve import error_curve
from envlights.fitting.fit import fit
from envlights.splitting.split import split

#: Methods by name.
METHODS: dict[str, Callable[..., Any]] = {
    "fit": fit,
    "detect": detect,
    "split": split,
    "error_curve": error_curve,
}
#: Number of bytes that are hashed at once.
_BLOCK = 2**20


class Task(NamedTuple):
    """Work on one map; the first fields are those of the whole batch."""

    what: str | Callable[..., Any]
    """Name of a method, or a user's function."""

    options: Mapping[str, Any]
    threads: int | None
    """Number of kernel threads; None leaves it unchanged."""

    folder: str | None = None
    """Folder for the saved file; None to save nothing."""

    suffix: str | None = None
    reading: Reading | None = None
    """Options for reading the map."""

    name: str = ""
    source: str = ""
    content: Any = None
    known: str | None = None
    """SHA-256 of the content that already has a row."""

    own: frozenset[str] = frozenset()
    """Files in the folder that this batch may overwrite."""


def work_on(task: Task) -> dict[str, Any] | None:
    """Row for a map, or for its failure; None if the row exists already."""
    start = perf_counter()
    row: dict[str, Any] = {"name": task.name, "source": task.source, "sha256": None}
    try:
        _set_threads(task.threads)
        content, row["sha256"] = _with_hash(task.content)
        if row["sha256"] == task.known:
            return None
        result = _apply(task, content)
        row |= row_of(result)
        row["file"] = _save(task, result)
    except Exception as error:  # any failure becomes a row, and does not stop the batch
        row["failure"] = f"{type(error).__name__}: {printable(str(error))}"
    row["seconds"] = round(perf_counter() - start, 6)
    return row


def row(
    env: Any, what: str | Callable[..., Any] = "fit", *, threads: int = 1, **options: Any
) -> dict[str, Any]:
    """Row for one map, for frameworks that distribute work themselves, such as Ray or Slurm arrays.

    It keeps no state and never fails because of a map: a failure is a part of the row.

    Parameters
    ----------
    env : EnvMap, path-like, bytes, file object or array_like, shape (height, 2 * height, 3)
        The map, or a file.
    what : {"fit", "detect", "split", "error_curve"} or callable
        Work on the map; a function gets an `EnvMap` and `options`, as in `envlights.batch`.
    threads : int
        Threads of the kernels in this process, also afterwards.
    **options
        Arguments of the work, such as ``lights=4``.

    Returns
    -------
    dict
        Numbers and texts: "sha256" of the content, "seconds", "notes", "error", "ambient" and so
        on, and "lights", a list of dicts; or "failure", class and sentence of the reason.

    Raises
    ------
    EnvLightsError
        If `what` is unknown or has no such options, or `threads` is not a count.

    Examples
    --------
    >>> import envlights as el
    >>> row = el.batches.row(el.synthetic.hall(32).radiance, lights=2)
    >>> len(row["lights"]), row["error"] < 0.05
    (2, True)
    >>> el.batches.row(b"no map")["failure"].split(":")[0]
    'FileError'
    """
    if isinstance(what, str) and what not in METHODS:
        raise EnvLightsError(f"what must be one of {', '.join(METHODS)}, or a function; got {what}")
    if isinstance(what, str) and options.keys() - inspect.signature(METHODS[what]).parameters:
        check_options(what, options)  # raises an error with a suggestion
    task = Task(what, options, count("threads", threads), content=env)
    found = work_on(task) or {}  # never None, because no row is known
    return {name: value for name, value in found.items() if name not in {"name", "source", "file"}}


def _set_threads(number: int | None) -> None:
    if number is not None and _native.threads(None) != number:
        _native.threads(number)


def _apply(task: Task, content: Any) -> Any:
    if task.reading is not None:
        content = as_envmap(content, {"fill": task.options.get("fill"), **task.reading})
    if isinstance(task.what, str):
        return METHODS[task.what](content, **task.options)
    return task.what(as_envmap(content), **task.options)


def _with_hash(content: Any) -> tuple[Any, str]:
    """Content in a form that can be read twice, and its SHA-256."""
    digest = hashlib.sha256()
    content = _readable(content)
    for part in _parts(content):
        digest.update(part)
    return content, digest.hexdigest()


def _readable(content: Any) -> Any:
    """`content`, with addresses and file objects replaced by their bytes."""
    is_remote = isinstance(content, str) and ADDRESS.match(content)
    if is_remote or hasattr(content, "read"):
        return named_source(content).content()
    return content


def _parts(content: Any) -> Iterator[Any]:
    """Blocks of bytes that determine a map, for hashing."""
    if isinstance(content, EnvMap):
        shape, kind = content.radiance.shape, content.registration
        yield f"{shape} {kind} {content.clip_level} {content.units}".encode()
        yield np.ascontiguousarray(content.radiance)
        if content.coverage is not None:
            yield np.ascontiguousarray(content.coverage)
    elif isinstance(content, Mapping):
        for name, each in content.items():
            yield str(name).encode()
            yield from _parts(each)
    elif isinstance(content, list | tuple) and all(map(is_source, content)):
        for each in content:
            yield from _parts(each)
    elif is_source(content):
        faces = six_files(content)
        for each in [content] if faces is None else faces.files:
            with named_source(each).open() as file:
                while block := file.read(_BLOCK):
                    yield block
    else:
        array = np.ascontiguousarray(content)
        yield f"{array.shape} {array.dtype}".encode()
        yield array.view(np.uint8) if array.dtype != object and array.size else b""


def files_of(name: str, what: str | Callable[..., Any], suffix: str | None) -> list[str]:
    """Files in the folder that may be written for a map; the last one is the result."""
    has_map = suffix not in MAP_SUFFIXES and (what == "split" or callable(what))
    suffixes = [*([MAP_SUFFIXES[0]] if has_map else []), suffix]
    return [f"{name}{each}" for each in suffixes if each is not None] if suffix else []


def _save(task: Task, result: Any) -> str | None:
    """Save the result in the folder; return the file name, or None if nothing is saved."""
    if task.folder is None or task.suffix is None or not hasattr(result, "save"):
        return None
    has_map = isinstance(getattr(result, "remainder", None), EnvMap)
    files = files_of(task.name, task.what, task.suffix)[0 if has_map else -1 :]
    paths = [Path(task.folder, file) for file in files]
    paths[0].parent.mkdir(parents=True, exist_ok=True)
    _check_source_stays(task.source, paths)
    for file in files:
        if file not in task.own:
            raise EnvLightsError(
                f"{Path(task.folder, file)} exists, and no batch in this folder wrote it; give"
                " another folder, or move it away"
            )
    result.save(*paths)
    return files[-1]


def _check_source_stays(source: str, paths: Iterable[Path]) -> None:
    """Raise an error if the result would overwrite its own map."""
    if any(path.exists() and Path(source).exists() and path.samefile(source) for path in paths):
        raise EnvLightsError(
            f"the result would be saved over its map, {source}; give another folder"
        )


def check_options(
    what: str, options: Mapping[str, Any], work: Callable[..., Any] | None = None
) -> None:
    """Raise an error for options that are always invalid, by fitting a small grey map."""
    try:
        (work or METHODS[what])(np.ones((8, 16, 3), np.float32), **options)
    except TypeError as error:
        raise EnvLightsError(f"{what} refuses an option of the batch: {error}") from None


#: Digits of the hash of a function's source: two sources collide with probability 2^-48.
_DIGITS = 12


def name_of(function: Callable[..., Any]) -> str:
    """Module and name of a function, with a hash of its source and of arguments bound by `partial`.

    A function whose text is not in a file, such as one of C, has its name alone.
    """
    inner = function.func if isinstance(function, partial) else function
    bound = repr(function.args) if isinstance(function, partial) and function.args else ""
    named: Any = inner if hasattr(inner, "__qualname__") else type(inner)
    name = f"{named.__module__}.{named.__qualname__}"
    text = _text_of(named) + bound
    return f"{name}@{hashlib.sha256(text.encode()).hexdigest()[:_DIGITS]}" if text else name


def _text_of(function: Any) -> str:
    try:
        return inspect.getsource(function)
    except (OSError, TypeError):
        return ""
