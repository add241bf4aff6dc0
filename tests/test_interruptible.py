"""Single operations in a thread of their own; `test_interrupt.py` has the signals."""

import threading

import numpy as np
import pytest

from envlights._common.interruptible import interruptible

LONG, SHORT = 1e12, 1e3


@pytest.mark.parametrize("multiplications", [LONG, SHORT])
def test_what_the_work_returns_or_raises_comes_back(multiplications):
    assert interruptible(lambda: 3, multiplications) == 3
    with pytest.raises(ZeroDivisionError):
        interruptible(lambda: 1 / 0, multiplications)


def test_only_long_work_has_a_thread():
    this = threading.current_thread()
    assert interruptible(threading.current_thread, SHORT) is this
    assert interruptible(threading.current_thread, LONG) is not this


def test_the_thread_outlives_no_daemon():
    """Python would end a daemon in the midst of its work, and at times the process with it."""
    assert not interruptible(lambda: threading.current_thread().daemon, LONG)


def test_other_threads_do_all_themselves():
    """Signals reach the main thread only."""
    found = []
    other = threading.Thread(
        target=lambda: found.append(interruptible(threading.current_thread, LONG))
    )
    other.start()
    other.join()
    assert found == [other]


def test_without_a_thread_the_work_is_done_here(monkeypatch):
    def refuse(self):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", refuse)
    assert interruptible(threading.current_thread, LONG) is threading.main_thread()


def test_what_numpy_should_not_warn_of_holds_in_the_thread():
    with np.errstate(divide="ignore"):
        assert interruptible(lambda: np.ones(1) / np.zeros(1), LONG) == np.inf
