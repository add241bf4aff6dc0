"""`batch`: the same work on many maps, with a row and a file for each."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import BrokenExecutor, Future
from importlib.metadata import version
from pathlib import Path
from time import perf_counter
from typing import Any

from envlights._common.check import check_choice, check_progress, count, describe
from envlights._common.files import as_path
from envlights._common.printable import printable
from envlights._common.progress import progress_bar
from envlights._native import EnvLightsError
from envlights.batches.executors import (
    KILLED,
    executor_of,
    in_window,
    jobs_of,
    threads_of,
    threads_restored,
)
from envlights.batches.journal import Journal
from envlights.batches.result import Batch
from envlights.batches.rows import plain
from envlights.batches.sources import items_of, with_unique_names
from envlights.batches.work import METHODS, Task, check_options, files_of, name_of, work_on
from envlights.environment.files.image_output import MAP_SUFFIXES
from envlights.environment.reading import Reading, check_reading
from envlights.export.targets import target_of

#: Queued tasks per worker, so that workers stay busy while a row is written.
_AHEAD = 2


def batch(
    maps: Any,
    out: str | os.PathLike[str] | None = None,
    *,
    what: str | Callable[..., Any] = "fit",
    suffix: str | None = ".json",
    executor: Any = None,
    jobs: int | None = None,
    progress: bool | None = None,
    reading: Reading | None = None,
    **options: Any,
) -> Batch:
    """Fit, detect or split many maps, with a row of numbers and a file for each.

    A map that fails has a row with the reason. With a folder `out`, a batch that was
    killed goes on where it stopped when it is started again: maps of the same content and options
    are not done again, and those that failed are. A file of the folder that no batch wrote is never
    replaced: its map fails.

    Parameters
    ----------
    maps : path-like, array_like or iterable
        Files, folders (with those below them), patterns such as ``maps/**/*.hdr``, lists of paths
        (``.txt``: one path on each line; ``.jsonl``: also objects with `path` and `name`),
        addresses of fsspec, `EnvMap` or arrays; or an iterable of them, and of pairs of a name and
        a map. An iterator is read as the work goes on, a few maps ahead.
    out : path-like, optional
        Folder of the files and of the rows, ``batch.jsonl``; it is made if it is missing. Maps in
        it that `maps` finds by a folder or pattern are left out. Without `out`, the rows are kept
        in memory and nothing is saved.
    what : {"fit", "detect", "split", "error_curve"} or callable
        Work on each map. A function gets an `EnvMap` and the options, and returns a dict of numbers
        and texts, a rig, lights or another result. When its own text changes, all maps are done
        again, but not when a function that it calls changes.
    suffix : str, optional
        Format of the file of each map, as in `Rig.save`; a split also writes its remainder as
        ``.exr``. None: no files.
    executor : {"thread", "process"} or object with `submit`, optional
        "thread", the default: threads of this process. "process": processes of its own, started by
        spawn. Or any object with ``submit(f, x)``, whose results have ``result()``, and whose
        workers see the same files: an executor of `concurrent.futures`, `MPIPoolExecutor` of
        mpi4py, a `Client` of Dask, or your own.
    jobs : int, optional
        Maps at once. When left out, the number of workers of the executor or of cores. Kernels get
        an equal share of the threads of `el.threads`; with ``jobs=1``, all of them. Workers of
        Dask use one thread each, those of MPI and other executors what they are set to.
    progress : bool, optional
        True: show a bar. When left out, one appears in a terminal or notebook after a second.
    reading : mapping, optional
        Options on how the maps are read: arguments of `EnvMap.open`, `EnvMap.levelled`,
        `EnvMap.calibrated` and `EnvMap.rotated`, such as ``{"colour": "linear", "lux": 900}``. An
        `EnvMap` stays as it is.
    **options
        Options of the method or of the function.

    Returns
    -------
    Batch
        Rows of the maps of this call, sorted by name, and the failures. The text names other runs
        in the folder; `Batch.load` has all their rows.

    Raises
    ------
    EnvLightsError
        If a folder or pattern has no map, an option is unknown or out of its range, another batch
        writes to `out`, its ``batch.jsonl`` is of another program, the disk is full, or a worker
        process was killed; what is finished stays.

    See Also
    --------
    label_arrays : arrays of one size for training.

    Examples
    --------
    >>> import envlights as el
    >>> halls = ((f"hall-{seed}", el.synthetic.plain(seed, 128).radiance) for seed in range(3))
    >>> result = el.batch(halls, lights=2, jobs=1)
    >>> result
    <Batch: 3 maps, 0 failed>
    >>> [len(row["lights"]) for row in result.rows()]
    [2, 2, 2]
    """
    check_progress(progress)
    check_reading(reading)
    method = _method(what, suffix, options, reading)
    jobs = jobs_of(executor, None if jobs is None else count("jobs", jobs, least=1, most=1024))
    folder = None if out is None else _folder(out)
    start, calls = perf_counter(), set[str]()
    with threads_restored(), executor_of(executor, jobs) as pool:
        threads = threads_of(executor, jobs)
        journal = Journal(folder)
        try:
            head = {
                "what": method[0],
                "options": method[1],
                "suffix": suffix,
                "version": _version(),
            }
            out = None if folder is None else str(folder)
            common = Task(what, options, threads, out, suffix, reading)
            tasks = _tasks(maps, journal, common, method, calls)
            done = in_window(pool, work_on, tasks, _AHEAD * jobs)
            counts = [
                _keep(task, future, journal, head)
                for task, future in progress_bar(done, "batch", "map", progress)
            ]
            text = journal.finish()
        finally:
            journal.close()
    seconds = perf_counter() - start
    place = "" if folder is None else str(folder)
    return Batch(place, text, counts.count(False), seconds, frozenset(calls))


def _version() -> str:
    return version("envlights")


def _method(
    what: Any, suffix: object, options: Mapping[str, Any], reading: Reading | None
) -> tuple[str, str, str | None]:
    """Name of the work, its options as text, and the file suffix, which identify a row."""
    if suffix is not None and not (isinstance(suffix, str) and suffix.startswith(".")):
        raise EnvLightsError(f"suffix must be text that begins with a dot; got {describe(suffix)}")
    if isinstance(what, str) or not callable(what):
        check_choice("what", what, tuple(METHODS))
        if suffix is not None and suffix not in MAP_SUFFIXES:
            target_of(f"map{suffix}")  # raises an error for unknown suffixes
        check_options(what, options)
        name = what
    else:
        name = name_of(what)
        options = {**getattr(what, "keywords", {}), **options}
    if reading is not None:
        options = {**options, "reading": {each: repr(reading[each]) for each in reading}}
    return name, json.dumps(plain(options), sort_keys=True), suffix


def _folder(out: str | os.PathLike[str]) -> Path:
    folder = as_path(out).absolute()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise EnvLightsError(f"cannot make the folder {out}: {error.strerror}") from None
    return folder


def _tasks(
    maps: Any,
    journal: Journal,
    common: Task,
    method: tuple[str, str, str | None],
    calls: set[str],
) -> Iterator[Task]:
    """Tasks, one per map, created when a worker is free; their sources are added to `calls`."""
    names = {source: entry.name for source, entry in journal.entries.items()}
    folder = None if common.folder is None else Path(common.folder)
    for name, source, content in with_unique_names(items_of(maps, folder), names, calls):
        files = files_of(name, common.what, common.suffix)
        # A function may write no map.
        written = files if common.what == "split" else files[-1:]
        known = journal.finished_hash(source, name, method, written)
        own = journal.claim(name, files)
        yield common._replace(name=name, source=source, content=content, known=known, own=own)


def _keep(task: Task, future: Future[Any], journal: Journal, head: dict[str, Any]) -> bool:
    """Write the row of a map; False if the row existed already."""
    try:
        row = future.result()
    except BrokenExecutor:
        raise EnvLightsError(KILLED) from None
    except Exception as error:  # the executor could not run the task
        row = {"name": task.name, "source": task.source, "sha256": None}
        row["failure"] = f"{type(error).__name__}: {printable(str(error))}"
    if row is not None:
        # The strings of the task are in memory anyway; those of a worker are copies.
        journal.append({**row, **head, "name": task.name, "source": task.source})
    return row is not None
