"""Peak memory of a piece of work, in a process of its own. Linux only."""

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path


def alone(function, *arguments):
    """Run a function in a new process; its errors are raised here."""
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        return pool.submit(function, *arguments).result()


def peak(work):
    """Largest number of bytes by which `work` grows this process."""
    before = _bytes("VmRSS")
    # From now on the peak is counted anew.
    Path("/proc/self/clear_refs").write_text("5")
    work()
    return _bytes("VmHWM") - before


def _bytes(name):
    lines = dict(line.split(":") for line in Path("/proc/self/status").read_text().splitlines())
    return 1024 * int(lines[name].split()[0])
