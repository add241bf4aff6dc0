"""Long single operations of NumPy, which Ctrl-C need not wait for.

Python looks for signals between two operations, and a factorisation of a large matrix is one that
takes seconds. In a thread of its own it runs to its end whatever happens, and its result is
dropped. The thread is no daemon: Python ends daemons in the midst of their work, and with them at
times the whole process. So a process that ends right after Ctrl-C waits for it.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from concurrent.futures import Future, TimeoutError
from contextvars import copy_context
from threading import Thread, current_thread, main_thread
from typing import TypeVar

_T = TypeVar("_T")

#: Multiplications that take some hundredths of a second; below, a thread is not worth its start.
_MANY = 3e8
#: Seconds between two looks for signals; on Windows a wait without end sees none.
_BETWEEN = 0.05


def interruptible(work: Callable[[], _T], multiplications: float) -> _T:
    """What `work` returns or raises; KeyboardInterrupt ends the wait for it.

    Parameters
    ----------
    work : callable
        Operations of NumPy on arrays that nobody changes.
    multiplications : float
        How long it takes, roughly.
    """
    # Python tells its main thread of signals, and no other.
    if multiplications < _MANY or current_thread() is not main_thread():
        return work()
    future: Future[_T] = Future()
    try:
        Thread(target=copy_context().run, args=(_settle, future, work)).start()
    except RuntimeError:  # The system starts no more threads.
        return work()
    while not future.done():
        with contextlib.suppress(TimeoutError):
            future.exception(_BETWEEN)
    return future.result()


def _settle(future: Future[_T], work: Callable[[], _T]) -> None:
    """Put the result of `work`, or what it raises, into the `future`."""
    try:
        future.set_result(work())
    except BaseException as error:
        future.set_exception(error)
