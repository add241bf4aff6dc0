"""The same command a second time, as `--against` compares it with the first.

A ratio is a run time of ours over a peer's on the same case. Both runs agree on it if it changes by
no more than the four spreads together, and a tenth for what differs between two processes. An error
agrees if it changes by no more than a millionth; those of methods that draw anew are left out.
"""

from itertools import product
from typing import NamedTuple

import numpy as np
from curves.results import Point, told

TITLE = "A second run"
#: What two processes differ by, beyond the spread within each: where their memory lies.
_PROCESSES = 0.1
_SAME_ERROR = 1e-6


class Change(NamedTuple):
    """A number of two runs: how far apart they are, and may be, as logarithms."""

    size: float
    allowed: float
    name: str

    @property
    def agrees(self):
        """Whether both runs say the same."""
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
    """What the page says of a part."""
    middle, most, largest = np.expm1(np.quantile([each.size for each in ratios], [0.5, 0.95, 1]))
    return {
        "part": name,
        "ratios": len(ratios),
        "agree": sum(each.agrees for each in ratios),
        "median change": _percent(middle),
        "95 % change by at most": _percent(most),
        "largest change": _percent(largest),
        "errors": len(errors),
        "agree on": sum(each.agrees for each in errors),
    }


def said(changes):
    """A line for each that does not agree, the worst first."""
    wrong = sorted((each for each in changes if not each.agrees), reverse=True)
    return [
        f"{each.name}: {_percent(np.expm1(each.size))}, allowed {_percent(np.expm1(each.allowed))}"
        for each in wrong
    ]


def _key(point):
    return point.case, point.method, point.setting


def _of_ratios(part, one, other, our, their):
    """The change of the ratio of run times, and of those errors that are run times."""
    name = f"{_named(our)} over {_named(their)} on {our[0]}"
    for time in (None, *getattr(part, "TIMED", ())):
        of = [_time(run[key], time) for run in (one, other) for key in (our, their)]
        first, second = of[0][0] / of[1][0], of[2][0] / of[3][0]
        allowed = sum(spread for _, spread in of) + _PROCESSES
        yield Change(abs(float(np.log(second / first))), allowed, name)


def _time(point, error):
    """Seconds and their spread: the run time, or an error that is one."""
    if error is None:
        return point.seconds, point.spread
    return point.errors[error], point.spreads[error]


def _of_errors(part, point, again):
    if point.method in getattr(part, "DRAWN", ()):
        return
    for error in point.errors.keys() - set(getattr(part, "TIMED", ())):
        seen, anew = (max(each.errors[error], 1e-12) for each in (point, again))
        name = f"{error} of {_named(_key(point))} on {point.case}"
        yield Change(float(abs(np.log(anew / seen))), _SAME_ERROR, name)


def _named(key):
    return f"{key[1]} ({told(key[2])})" if key[2] is not None else key[1]


def _percent(share):
    return f"{100 * share:.2g} %"
