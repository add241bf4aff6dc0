"""Points of run time against error, and rows of tables, kept as JSON lines."""

import json
import os
import time
from importlib.util import find_spec
from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit
from stopwatch import all_seconds, processor_seconds

#: Of the intervals that are stated.
CONFIDENCE = 0.999
#: What a round takes at least, in seconds: a shorter piece of work is done several times in a row.
_SHORTEST = 3e-3
#: What this process has done before, by name, and on what.
_DONE = set()


class Point(NamedTuple):
    """One method with one setting on one case."""

    part: str
    case: str
    method: str
    setting: float | None
    """Setting of the method; `None` if it has no setting."""

    seconds: float
    """Median over the processes of the medians over their rounds."""

    spread: float | None
    """Half the interval of the mean over the processes, as a share; None of a single run."""

    errors: dict
    """Relative errors by their names; some are run times."""

    rounds: dict
    """Seconds by process and round: of the run time, "call", and of those errors by their names.

    In each round of a process all methods took turns.
    """


class Effort(NamedTuple):
    """Upper limits on the rounds of a case in one process."""

    rounds: int
    """At most; a piece of work that has had its share of the seconds has fewer, but one."""

    seconds: float

    is_quick: bool = False
    """True if a case may be made smaller."""

    is_judged: bool = True
    """True if errors are measured, which are the same in each process."""


def setting_text(setting):
    """A setting as text; nothing for a method that has none."""
    return "" if setting is None else f"{setting:,.10g}"


def those_installed(methods, needs):
    """The methods whose packages are here; `needs` names the package of some."""
    return {
        name: method
        for name, method in methods.items()
        if name not in needs or find_spec(needs[name]) is not None
    }


def run_times(work, effort):
    """Seconds of each piece of work in each round.

    On one thread they are seconds of the processor: what else the machine does counts less.
    """
    is_alone = os.environ["RAYON_NUM_THREADS"] == "1"
    clock = processor_seconds if is_alone else time.perf_counter
    return all_seconds(work, effort.rounds, effort.seconds, clock, fewest=1, shortest=_SHORTEST)


def warm_up(work, alike):
    """Do each piece of work, unless this process has done it on something `alike`; no errors."""
    for name, piece in work.items():
        if (name, alike) not in _DONE:
            _DONE.add((name, alike))
            piece()
    return {name: {} for name in work}


def point(part, case, method, setting, errors, **rounds):
    """A point of the seconds in `rounds`, by process; those but of the "call" are errors, too."""
    rounds = {name: _round_numbers(seconds) for name, seconds in rounds.items()}
    run_times = {name: typical(seconds) for name, seconds in rounds.items()}
    seconds = run_times.pop("call")
    _, half = interval(logarithms(rounds["call"]))
    spread = float(np.expm1(half)) if np.isfinite(half) else None
    return Point(part, case, method, setting, seconds, spread, errors | run_times, rounds)


def _round_numbers(processes):
    """Four digits of each number, which is more than their accuracy."""
    return [[float(f"{seconds:.4g}") for seconds in process] for process in processes]


def merge(passes):
    """The points of several processes, which are the same but for their times, as one."""
    found = []
    for points in zip(*passes, strict=True):
        first = points[0]
        assert all(each[:4] == first[:4] for each in points), first
        rounds = {name: [run for p in points for run in p.rounds[name]] for name in first.rounds}
        found.append(point(*first[:4], first.errors, **rounds))
    return found


def typical(processes):
    """Median over the processes of the medians over their rounds."""
    return float(np.median([np.median(seconds) for seconds in processes]))


def logarithms(processes, others=None):
    """Logarithm of the seconds, or of their ratio to `others`, of each process.

    It is the median over the rounds: what slows one round slows both, and leaves their ratio.
    """
    if others is None:
        others = [np.ones(len(seconds)) for seconds in processes]
    pairs = zip(processes, others, strict=True)
    return [np.median([np.log(a / b) for a, b in zip(*pair, strict=False)]) for pair in pairs]


def interval(values):
    """Mean, and half the interval in which the mean of many such lies (Student's t)."""
    if len(values) < 2:
        return float(np.mean(values)), float("inf")
    factor = stdtrit(len(values) - 1, 0.5 + CONFIDENCE / 2)
    return float(np.mean(values)), float(factor * np.std(values, ddof=1) / np.sqrt(len(values)))


def write(path, machine, rows):
    """A line of the machine, and a line for each point or row of a table."""
    lines = [machine, *(row._asdict() if isinstance(row, Point) else row for row in rows)]
    path.write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")


def read(path):
    """The machine, and the points or rows of a file that `write` made."""
    machine, *rows = map(json.loads, path.read_text(encoding="utf-8").splitlines())
    return machine, [Point(**row) if "seconds" in row and "setting" in row else row for row in rows]


def curves(points, error):
    """For each method its settings with typical seconds, errors and the spread of the median case.

    Typical over the cases is the geometric mean.
    """
    table = {}
    for point in points:
        table.setdefault(point.method, {}).setdefault(point.setting, []).append(point)
    return {
        method: [
            (
                setting,
                _typical([each.seconds for each in cases]),
                _typical([each.errors[error] for each in cases]),
                _middle([each.spread for each in cases if each.spread is not None]),
            )
            for setting, cases in settings.items()
        ]
        for method, settings in table.items()
    }


def _middle(values):
    return float(np.median(values)) if values else None


def _typical(values):
    """Geometric mean; an error below the last digits counts as those."""
    return float(np.exp(np.mean(np.log(np.maximum(values, 1e-12)))))
