"""Points of run time against error, and rows of tables, kept as JSON lines."""

import json
import os
import time
from importlib.util import find_spec
from typing import NamedTuple

import numpy as np
from stopwatch import all_seconds, processor_seconds


class Point(NamedTuple):
    """One method with one setting on one case."""

    part: str
    case: str
    method: str
    setting: float | None
    """None for a method that has none."""

    seconds: float
    """Median over the rounds, in which all methods took turns."""

    spread: float
    """Half the distance of the quartiles over the median."""

    errors: dict
    """Relative errors by their names; some are run times."""

    spreads: dict | None = None
    """Of those errors that are run times."""


class Effort(NamedTuple):
    """What a case may cost: rounds, of which each piece has three in any case, and seconds."""

    rounds: int
    seconds: float

    @property
    def is_quick(self):
        """Whether a case may be made smaller."""
        return self.rounds < 5


def told(setting):
    """A setting as text; nothing for a method that has none."""
    return "" if setting is None else f"{setting:,.10g}"


def those_installed(methods, needs):
    """The methods whose packages are here; `needs` names the package of some."""
    return {
        name: method
        for name, method in methods.items()
        if name not in needs or find_spec(needs[name]) is not None
    }


def timed(work, effort):
    """Median seconds and spread of each piece of work.

    On one thread they are seconds of the processor: what else the machine does counts less.
    """
    is_alone = os.environ["RAYON_NUM_THREADS"] == "1"
    clock = processor_seconds if is_alone else time.perf_counter
    found = {}
    for name, seconds in all_seconds(work, effort.rounds, effort.seconds, clock).items():
        low, median, high = np.percentile(seconds, [25, 50, 75])
        found[name] = float(median), float((high - low) / 2 / median)
    return found


def write(path, machine, rows):
    """A line of the machine, and a line for each point or row of a table."""
    lines = [machine, *(row._asdict() if isinstance(row, Point) else row for row in rows)]
    path.write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")


def read(path):
    """The machine, and the points or rows of a file that `write` made."""
    machine, *rows = map(json.loads, path.read_text(encoding="utf-8").splitlines())
    return machine, [Point(**row) if "seconds" in row and "setting" in row else row for row in rows]


def curves(points, error):
    """For each method its settings with typical seconds, errors and the worst spread.

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
                max(each.spread for each in cases),
            )
            for setting, cases in settings.items()
        ]
        for method, settings in table.items()
    }


def _typical(values):
    """Geometric mean; an error below the last digits counts as those."""
    return float(np.exp(np.mean(np.log(np.maximum(values, 1e-12)))))
