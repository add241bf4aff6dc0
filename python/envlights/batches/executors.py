"""Executors of a batch: our own pools, any executor of `concurrent.futures`, a client of Dask."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    wait,
)
from multiprocessing import get_context
from typing import Any, TypeVar

from envlights import _native
from envlights._common.check import check_choice
from envlights._native import EnvLightsError

_Task = TypeVar("_Task")

#: Executors by name.
NAMES = ("thread", "process")


@contextlib.contextmanager
def executor_of(executor: Any, jobs: int) -> Iterator[Executor]:
    """Executor of the argument of `batch`; our own ends with the batch."""
    if executor is None and jobs == 1:
        yield _Inline()
    elif executor is None or isinstance(executor, str):
        with _own(executor or "thread", jobs) as pool:
            yield pool
    elif hasattr(executor, "get_executor"):  # a client of Dask
        # Not pure: a map that failed is tried again.
        yield executor.get_executor(pure=False)
    elif callable(getattr(executor, "submit", None)):
        yield executor
    else:
        raise EnvLightsError(
            'executor must be "thread", "process", an executor of concurrent.futures or a client of'
            f" Dask; got an object of the type {type(executor).__name__}"
        )


@contextlib.contextmanager
def _own(name: str, jobs: int) -> Iterator[Executor]:
    check_choice("executor", name, NAMES)
    if name == "thread":
        pool: Executor = ThreadPoolExecutor(jobs, "envlights-batch")
    else:
        pool = ProcessPoolExecutor(jobs, get_context("spawn"))
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


class _Inline(Executor):
    """Executor that works in the calling thread."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Finished future of the call."""
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


def jobs_of(executor: Any, jobs: int | None) -> int:
    """Maps at once: `jobs`, the workers of the executor, or the cores of this machine."""
    if jobs is not None:
        return jobs
    workers = getattr(executor, "_max_workers", None) or getattr(executor, "num_workers", None)
    if isinstance(workers, int) and workers > 0:
        return workers
    if hasattr(executor, "ncores"):  # a client of Dask
        return max(1, int(sum(executor.ncores().values())))
    return _native.threads(None)


def threads_of(executor: Any, jobs: int) -> int | None:
    """Threads of the kernels of each worker, so that the workers of this machine share its cores.

    None leaves them: workers of an executor that we do not know may be on other machines.
    """
    if hasattr(executor, "get_executor"):  # Dask counts the cores of its workers itself
        return 1
    if executor is None or isinstance(executor, str | ThreadPoolExecutor | ProcessPoolExecutor):
        return max(1, _native.threads(None) // jobs)
    return None


@contextlib.contextmanager
def threads_restored() -> Iterator[None]:
    """Number of threads of this process after the batch as before."""
    before = _native.threads(None)
    try:
        yield
    finally:
        if _native.threads(None) != before:
            _native.threads(before)


def in_window(
    executor: Executor, work: Callable[[_Task], Any], tasks: Iterable[_Task], width: int
) -> Iterator[tuple[_Task, Future[Any]]]:
    """Finished futures of all tasks with their tasks; at most `width` tasks wait or run."""
    pending: dict[Future[Any], _Task] = {}
    try:
        for task in tasks:
            pending[executor.submit(work, task)] = task
            if len(pending) >= width:
                yield from _next_futures(pending)
        while pending:
            yield from _next_futures(pending)
    finally:
        for future in pending:
            future.cancel()


def _next_futures(pending: dict[Future[Any], _Task]) -> Iterator[tuple[_Task, Future[Any]]]:
    for future in wait(pending, return_when=FIRST_COMPLETED).done:
        yield pending.pop(future), future
