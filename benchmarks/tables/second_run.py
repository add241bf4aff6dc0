"""A second run of the command, compared with the first by `--against`.

A ratio is our run time over a peer's on one case, in the same rounds. Its interval covers 99.9 % of
the mean over the processes, by Student's t. Two runs agree on a ratio if their intervals overlap.
With six or nine processes, chance alone separates one of 400 000 ratios, which is one in 100
comparisons of all parts. Agreement depends on the width of the intervals: if half of one is 50 %, a
doubled ratio may still agree. Half an interval is the mean of both runs, as a percentage or as a
factor. An error agrees if it changes by at most 1e-6 of itself; random methods are left out. The
peak of memory agrees if it changes by at most 2 % of itself and of 50 MB, because pages are counted
in batches and stacks grow.
"""

from itertools import product
from typing import NamedTuple

import numpy as np
from curves.results import Point, interval, logarithms, setting_text

from envlights._common.words import percent

TITLE = "A second run"
_SAME_ERROR = 1e-6
#: The second, a megabyte, covers memory beyond the calls: Linux counts pages in batches of 128 kB,
#: the allocator reserves some in advance, and the stacks of threads grow.
_SAME_MEMORY, _FEW_MEGABYTES = 0.02, 50.0


class Change(NamedTuple):
    """A number of two runs: how far apart they are, and may be, as logarithms."""

    size: float
    allowed: float
    name: str

    @property
    def agrees(self):
        """True if both runs agree."""
        return self.size <= self.allowed


def changes(part, first, second):
    """Changes of all ratios and of all errors between two runs of a part."""
    one, other = (
        {_key(p): p for p in points if isinstance(p, Point)} for points in (first, second)
    )
    keys = [key for key in one if key in other]
    pairs = [
        (our, their)
        for our, their in product(keys, keys)
        if our[0] == their[0]
        and our[1] in part.OURS
        and their[1] not in part.OURS
        and part.are_comparable(one[our], one[their])
    ]
    ratios = [ratio for pair in pairs for ratio in _of_ratios(part, one, other, *pair)]
    return ratios, [error for key in keys for error in _of_errors(part, one[key], other[key])]


def row(name, ratios, errors):
    """Row of the page for one part."""
    middle, most, largest = np.expm1(np.quantile([each.size for each in ratios], [0.5, 0.95, 1]))
    usual, wide = np.expm1(np.quantile([each.allowed / 2 for each in ratios], [0.5, 0.95]))
    return {
        "part": name,
        "ratios": len(ratios),
        "agree": sum(each.agrees for each in ratios),
        "half an interval, median": _share(usual),
        "of 95 % at most": _share(wide),
        "median change": percent(middle, 2),
        "95 % change by at most": percent(most, 2),
        "largest change": percent(largest, 2),
        "errors": len(errors),
        "agree on": sum(each.agrees for each in errors),
    }


def sentences(changes):
    """A line for each that does not agree, the worst first."""
    wrong = sorted((each for each in changes if not each.agrees), reverse=True)
    return [
        f"{each.name}: {percent(np.expm1(each.size), 2)},"
        f" allowed {percent(np.expm1(each.allowed), 2)}"
        for each in wrong
    ]


def _key(point):
    return point.case, point.method, point.setting


def _of_ratios(part, one, other, our, their):
    """Changes of the ratios of run times, and of those errors that are run times."""
    name = f"{_label(our)} over {_label(their)} on {our[0]}"
    for time in ("call", *getattr(part, "TIMED", ())):
        (first, half), (second, other_half) = (
            interval(logarithms(run[our].rounds[time], run[their].rounds[time]))
            for run in (one, other)
        )
        yield Change(abs(second - first), half + other_half, name)


def _of_errors(part, point, again):
    if point.method in getattr(part, "DRAWN", ()):
        return
    for error in point.errors.keys() - set(getattr(part, "TIMED", ())):
        is_memory = error in getattr(part, "MEMORY", ())
        least, allowed = (_FEW_MEGABYTES, _SAME_MEMORY) if is_memory else (1e-12, _SAME_ERROR)
        seen, anew = (each.errors[error] + least for each in (point, again))
        name = f"{error} of {_label(_key(point))} on {point.case}"
        yield Change(float(abs(np.log(anew / seen))), allowed, name)


def _label(key):
    return f"{key[1]} ({setting_text(key[2])})" if key[2] is not None else key[1]


def _share(share):
    return f"x {1 + share:.2g}" if share > 1 else percent(share, 2)
