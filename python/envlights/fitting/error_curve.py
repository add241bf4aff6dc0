"""Errors of fits with different numbers of lights."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import accumulate, pairwise
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import counts, named_arguments
from envlights._common.fields import fields_of
from envlights._common.result import TableResult
from envlights._common.tables import Table, csv_of, json_text, save_table
from envlights._common.words import percent
from envlights._native import EnvLightsError
from envlights.environment.fill import Fill
from envlights.environment.reading import AnyMap
from envlights.fitting.map_fit import fit_map_by_count
from envlights.fitting.request import FitArguments
from envlights.kernels import gloss
from envlights.rigs.rig import Rig, error_of

#: Columns of a table of errors.
_COLUMNS = ("lights", "used", "objective", "probe", "shadows", "gloss")


@dataclass(frozen=True, eq=False, repr=False)
class ErrorCurve(TableResult):
    """Errors of the rigs of a map for different limits on the number of lights.

    Errors are fractions: 0.01 is 1 %. Printed tables hold them in percent, with `probe` as the
    column "shading". `to_frame` and `to_csv` have the columns ``lights``, ``used``, ``objective``,
    ``probe``, ``shadows`` and ``gloss``.
    """

    lights: tuple[int, ...]
    """Limit on the number of lights for each rig."""

    used: tuple[int, ...]
    """Number of lights in each rig; lower than the limit if more lights do not reduce the error."""

    objective: tuple[float, ...]
    """Relative RMS error that the fits minimise; see `FitReport.objective_error`.

    It never rises from one number of lights to a larger one."""

    probe: tuple[float, ...]
    """Relative RMS error of shading; see `Rig.error`."""

    shadows: tuple[float, ...]
    """Relative RMS error with shadows; see `FitReport.shadow_error`."""

    gloss: tuple[float, ...]
    """Relative RMS error on metal of this `roughness`; see `FitReport.gloss_error`."""

    roughness: float
    """Roughness of the metal."""

    seconds: float = field(compare=False)
    """Wall time of reading the map and of all fits, which share most of the work."""

    rigs: tuple[Rig, ...] = ()
    """Rig of each row."""

    def to_dict(self) -> dict[str, Any]:
        """All fields except the rigs and the time as plain numbers and lists."""
        return fields_of(self, "rigs")

    def columns(self) -> dict[str, NDArray[Any]]:
        """Columns with a row per number of lights; errors are fractions."""
        return {name: np.array(getattr(self, name)) for name in _COLUMNS}

    def to_csv(self) -> str:
        """Lossless CSV table with a row per number of lights; errors are fractions."""
        return csv_of(self.columns())

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the table as ``.csv`` or ``.json``; a failure leaves no file."""
        save_table(path, {".csv": self.to_csv, ".json": lambda: json_text(self.to_dict())})

    def in_short(self) -> str:
        """Range of the numbers of lights, and the errors for the largest."""
        if not self.lights:
            return "no fit"
        each = ", ".join(
            f"{name} {percent(values[-1])}"
            for name, values in (
                ("shading", self.probe),
                ("shadows", self.shadows),
                ("gloss", self.gloss),
            )
        )
        return f"{self.lights[0]} to {self.lights[-1]} lights; at the end {each}"

    def _lines(self) -> list[str]:
        """Lines below the table: the metal, rising errors with shadows, and notes."""
        each = (
            f"{percent(before)} with {fewer} to {percent(after)} with {more}"
            for fewer, before, more, after in self._rises()
        )
        rises = "; ".join(each)
        notes = [f"note: more lights raise the error with shadows: {rises}"] if rises else []
        notes += [f"note: {note}" for rig in self.rigs[-1:] for note in rig.notes]
        return [f"gloss: metal of roughness {self.roughness:g}", *notes]

    def _rises(self) -> list[tuple[int, float, int, float]]:
        """Successive numbers of lights between which the displayed error with shadows increases."""
        rows = sorted(set(zip(self.lights, self.shadows, strict=True)))
        return [
            (*row, *following)
            for row, following in pairwise(rows)
            if following[1] > row[1] and percent(following[1]) != percent(row[1])
        ]

    def table(self) -> Table:
        """Table with a row per number of lights; errors are in percent."""
        names = ["lights", "used", "objective", "shading", "shadows", "gloss"]
        errors = (self.objective, self.probe, self.shadows, self.gloss)
        columns = zip(self.lights, self.used, *errors, strict=True)
        rows = [
            [str(lights), str(used), *map(percent, errors)] for lights, used, *errors in columns
        ]
        return Table(names, rows)


@named_arguments()
def error_curve(
    env: AnyMap,
    lights: Iterable[int] = range(9),
    *,
    roughness: float = 0.33,
    sizes: bool = True,
    max_radius: float | None = None,
    objective: str = "mixed",
    ambient: str | None = None,
    floor: bool = False,
    fill: Fill = None,
) -> ErrorCurve:
    """Fit a map with several numbers of lights, and compare the errors.

    Each fit is a full search, equal to ``fit(env, n)`` bit by bit. The fits share what depends on
    the map alone, and the forward selection on the way to the largest number: a curve of 0 to 8
    lights takes about 3 times as long as the fit with 8.

    A row holds the rig with the least error that the fits minimise, among those of all rows with at
    most as many lights: so one more light never raises that error, which `objective` holds. If
    `used` is less than `lights`, the row repeats a rig of fewer lights because it was better than
    the fit. The other errors may rise a little, because no fit minimises them alone. To get the
    fewest lights for an error, call `fit` with that error instead. `FitReport.search_errors` is no
    such curve: it holds points that a search tried on its way.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map; it is read once.
    lights : iterable of int
        Largest numbers of lights.
    roughness : float
        Roughness of the metal, from 0.3 to 1.
    sizes, max_radius, objective, ambient, floor, fill
        As for `fit`.

    Returns
    -------
    ErrorCurve
        A row for each of `lights`, in their order.

    Raises
    ------
    EnvLightsError
        If `lights` are not whole numbers from 0 on, `roughness` is not from 0.3 to 1, or `fit`
        refuses an argument.

    See Also
    --------
    fit : one rig.

    Examples
    --------
    >>> import envlights as el
    >>> curve = el.error_curve(el.synthetic.hall(64).radiance, lights=[1, 4])
    >>> curve.used
    (1, 4)
    >>> curve.gloss[1] < curve.gloss[0]
    True
    """
    start = perf_counter()
    roughness, numbers = gloss.checked_roughness(roughness), counts("lights", lights)
    if not numbers:
        raise EnvLightsError("lights must hold at least one number; got none")
    shape, world = (sizes, max_radius, objective, ambient), (floor, fill, None)
    options = FitArguments(None, None, None, None, roughness, *shape, "greedy", None, *world)
    increasing = sorted(set(numbers))
    fits = fit_map_by_count(env, options, increasing)
    best = dict(zip(increasing, accumulate(fits, _better), strict=True))
    rigs = [best[number] for number in numbers]
    return ErrorCurve(
        tuple(numbers),
        tuple(len(rig.lights) for rig in rigs),
        tuple(_objective_error(rig) for rig in rigs),
        tuple(map(error_of, rigs)),
        tuple(rig.report.shadow_error or 0.0 for rig in rigs),
        tuple(rig.report.gloss_error(roughness) or 0.0 for rig in rigs),
        roughness,
        perf_counter() - start,
        tuple(rigs),
    )


def _better(rig: Rig, more: Rig) -> Rig:
    """Rig with the smaller objective error; `rig` if both are equal."""
    return more if _objective_error(more) < _objective_error(rig) else rig


def _objective_error(rig: Rig) -> float:
    return rig.report.objective_error or 0.0
