"""Executors for batches: own pools, or objects whose `submit` returns something with `result`."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    wait,
)
from multiprocessing import get_context, parent_process
from threading import Thread
from typing import Any, TypeVar

from envlights import _native
from envlights._common.check import check_choice, describe
from envlights._common.printable import printable
from envlights._native import EnvLightsError

_Task = TypeVar("_Task")

#: Error message after a worker process died.
KILLED = (
    "a worker process was killed, perhaps because the memory was full; start the batch again with"
    " fewer jobs, and it goes on"
)
#: Executors by name.
NAMES = ("thread", "process")


@contextlib.contextmanager
def executor_of(executor: Any, jobs: int) -> Iterator[Any]:
    """Executor for `batch`: the given one, or an own pool for the duration of the batch."""
    if executor is None and jobs == 1:
        yield _Inline()
    elif executor is None or isinstance(executor, str):
        with _own(executor or "thread", jobs) as pool:
            yield pool
    elif callable(getattr(executor, "submit", None)):
        yield executor
    else:
        raise EnvLightsError(
            'executor must be "thread", "process", or an object with the method submit(f, x), whose'
            " result has the method result(), such as an executor of concurrent.futures or a client"
            f" of Dask; got {describe(executor)}"
        )


@contextlib.contextmanager
def _own(name: str, jobs: int) -> Iterator[Executor]:
    check_choice("executor", name, NAMES)
    if name == "thread":
        pool: Executor = ThreadPoolExecutor(jobs, "envlights-batch")
    else:
        pool = ProcessPoolExecutor(jobs, get_context("spawn"), _end_with_parent)
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


def _end_with_parent() -> None:
    """End this worker when its parent is killed, because the queue would block forever."""

    def wait_for_parent() -> None:
        if (parent := parent_process()) is not None:
            parent.join()
            os._exit(1)

    Thread(target=wait_for_parent, daemon=True).start()


class _Inline(Executor):
    """Executor that works in the calling thread."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Completed future for the call."""
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


def jobs_of(executor: Any, jobs: int | None) -> int:
    """Number of concurrent maps: `jobs`, the workers of the executor, or the local cores."""
    workers = getattr(executor, "_max_workers", None) or getattr(executor, "num_workers", None)
    known = jobs or workers or _cores(executor)
    return known if isinstance(known, int) and known > 0 else _native.threads(None)


def threads_of(executor: Any, jobs: int) -> int | None:
    """Kernel threads per worker, so that local workers share the cores.

    None leaves them: workers of an executor that we do not know may be on other machines. One that
    counts the cores of its workers, as Dask does, gives each map one core.
    """
    if executor is None or isinstance(executor, str | ThreadPoolExecutor | ProcessPoolExecutor):
        return max(1, _native.threads(None) // jobs)
    return 1 if _cores(executor) else None


def _cores(executor: Any) -> int:
    """Total cores of all workers of a Dask client; 0 for other executors."""
    try:
        return sum(executor.ncores().values())
    except (AttributeError, TypeError):  # not a Dask client
        return 0


@contextlib.contextmanager
def threads_restored() -> Iterator[None]:
    """Context that restores the number of kernel threads after the batch."""
    before = _native.threads(None)
    try:
        yield
    finally:
        if _native.threads(None) != before:
            _native.threads(before)


def in_window(
    executor: Any, work: Callable[[_Task], Any], tasks: Iterable[_Task], width: int
) -> Iterator[tuple[_Task, Future[Any]]]:
    """Tasks with their completed futures; at most `width` tasks are pending or running."""
    pending: dict[Future[Any], tuple[_Task, Any]] = {}
    # Start a waiting thread per job, because jobs of other libraries can only be awaited
    # individually.
    waiters = ThreadPoolExecutor(width, "envlights-wait")
    try:
        for task in tasks:
            job = _submit(executor, work, task)
            if not callable(getattr(job, "result", None)):
                raise EnvLightsError(
                    "submit of the executor must return an object with the method result(); got"
                    f" {describe(job)}"
                )
            future = job if isinstance(job, Future) else waiters.submit(job.result)
            pending[future] = task, job
            if len(pending) >= width:
                yield from _next_futures(pending)
        while pending:
            yield from _next_futures(pending)
    finally:
        for _, job in pending.values():
            with contextlib.suppress(Exception):  # other libraries may not support it
                job.cancel()
        waiters.shutdown(wait=False, cancel_futures=True)


def _submit(executor: Any, work: Callable[[_Task], Any], task: _Task) -> Any:
    """Submitted task; raises an error if the executor rejects it."""
    try:
        return executor.submit(work, task)
    except BrokenExecutor:
        raise EnvLightsError(KILLED) from None
    except Exception as error:
        raise EnvLightsError(
            "submit(f, x) of the executor must accept a function and its argument; it raised"
            f" {type(error).__name__}: {printable(str(error))}"
        ) from error


def _next_futures(
    pending: dict[Future[Any], tuple[_Task, Any]],
) -> Iterator[tuple[_Task, Future[Any]]]:
    for future in wait(pending, return_when=FIRST_COMPLETED).done:
        yield pending.pop(future)[0], future
