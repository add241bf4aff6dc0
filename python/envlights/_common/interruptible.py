"""NumPy operations in a worker thread, so that Ctrl-C works immediately.

Python handles signals between operations, and factorising a large matrix takes seconds. After
Ctrl-C the thread finishes, and its result is dropped. It is no daemon, because Python may crash
when it ends a daemon thread during its work. A process that ends after Ctrl-C waits for it.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from concurrent.futures import Future, TimeoutError
from contextvars import copy_context
from threading import Thread, current_thread, main_thread
from typing import TypeVar

_T = TypeVar("_T")

#: Number of multiplications that take a few hundredths of a second; shorter work needs no thread.
_MANY = 3e8
#: Interval in seconds between checks for signals, because an endless wait on Windows receives none.
_BETWEEN = 0.05


def interruptible(work: Callable[[], _T], multiplications: float) -> _T:
    """Return or raise the result of `work`; KeyboardInterrupt ends the wait.

    Parameters
    ----------
    work : callable
        NumPy operations on arrays that do not change.
    multiplications : float
        Rough cost.
    """
    # Only the main thread of Python receives signals.
    if multiplications < _MANY or current_thread() is not main_thread():
        return work()
    future: Future[_T] = Future()
    try:
        Thread(target=copy_context().run, args=(_settle, future, work)).start()
    except RuntimeError:  # The system allows no more threads.
        return work()
    while not future.done():
        with contextlib.suppress(TimeoutError):
            future.exception(_BETWEEN)
    return future.result()


def _settle(future: Future[_T], work: Callable[[], _T]) -> None:
    """Store the result or the exception of `work` in the `future`."""
    try:
        future.set_result(work())
    except BaseException as error:
        future.set_exception(error)
