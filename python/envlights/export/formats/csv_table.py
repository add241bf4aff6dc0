"""Reader of the CSV files of lights that `envlights.export` writes."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from envlights._common.errors import DamagedFileError
from envlights._common.files import read_text
from envlights._common.units import OWN_SCALE, PHOTOMETRIC
from envlights._native import EnvLightsError
from envlights.export.files import AnyPath

_T = TypeVar("_T")

FORMAT = "# envlights CSV, version 1"

#: End of the second line, before the unit; files without it have the map's own scale.
SCALE = "; scale: "
HEADER = "kind,x,y,z,red,green,blue,angular_radius"
_RIG = re.compile(r"# relative RMS error (\S+)(, over a floor)?")
#: First cells of the rows of an ambient term: constant, or nine harmonics.
AMBIENTS = (["ambient"], [f"ambient sh{j}" for j in range(9)])


class Table(NamedTuple):
    """Content of a CSV file; `ambient` and `error` are None if it holds lights alone."""

    direction: NDArray[np.float64]
    """Unit vectors towards the lights, (n, 3)."""

    irradiance: NDArray[np.float64]
    """Linear RGB at normal incidence, (n, 3)."""

    angular_radius: NDArray[np.float64]
    """Angular radius in radians, (n,)."""

    ambient: NDArray[np.float64] | None
    """Radiance, (3,), or its harmonics, (9, 3)."""

    error: float | None
    """Relative RMS error of the rig; None also if it was not measured."""

    units: str
    """Unit of the radiance; see `EnvMap.units`."""

    floor: bool
    """True if a floor hides the ambient light from below."""


def read_csv(path: AnyPath) -> Table:
    """Read what `save_csv` wrote.

    Raises
    ------
    EnvLightsError
        If the file cannot be read, or is not a complete table of lights.
    """
    lines = read_text(path).splitlines()
    if lines[:1] != [FORMAT]:
        raise DamagedFileError(f"{path} is not a table of lights: its first line is not '{FORMAT}'")
    header = re.fullmatch(_RIG, lines[2]) if len(lines) > 2 else None
    try:
        rms = float(header[1]) if header and header[1] != "None" else None
        rows = _rows([line for line in lines if line and not line.startswith("#")])
        ambient = _ambient([row for row in rows if row[0] != "light"])
        lights = np.array([row[1:] for row in rows if row[0] == "light"], float).reshape(-1, 7)
    except ValueError as reason:
        raise DamagedFileError(f"{path} is not a complete table of lights: {reason}") from None
    if (ambient is None) != (header is None):
        raise DamagedFileError(f"{path} is not a complete rig: ambient and error go together")
    floor = bool(header and header[2])
    units = PHOTOMETRIC if lines[1].endswith(f"{SCALE}{PHOTOMETRIC}") else OWN_SCALE
    return Table(lights[:, :3], lights[:, 3:6], lights[:, 6], ambient, rms, units, floor)


def load_csv(path: AnyPath, build: Callable[[Table], _T]) -> _T:
    """Result of `build` for the table in a file, or a refusal that names the file."""
    table = read_csv(path)
    try:
        return build(table)
    except EnvLightsError as error:
        raise DamagedFileError(f"{path} holds impossible lights: {error}") from None


def _rows(lines: list[str]) -> list[list[str]]:
    if lines[:1] != [HEADER]:
        raise ValueError(f"the header must be '{HEADER}'")
    rows = [line.split(",") for line in lines[1:]]
    for number, row in enumerate(rows, 1):
        if len(row) != HEADER.count(",") + 1:
            raise ValueError(f"row {number} has {len(row)} cells")
    return rows


def _ambient(rows: list[list[str]]) -> NDArray[np.float64] | None:
    """Ambient term, (3,) or (9, 3), or None."""
    if not rows:
        return None
    if [row[0] for row in rows] not in AMBIENTS:
        raise ValueError("its rows must be lights, then one row of ambient or nine")
    values = np.array([row[4:7] for row in rows], float)
    return values if len(rows) > 1 else values[0]
