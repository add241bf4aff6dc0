"""Errors of placed lights where maps were taken."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.result import TableResult
from envlights._common.tables import MOST_ROWS, Table
from envlights._common.words import percent


@dataclass(frozen=True, eq=False, repr=False)
class PointErrors(TableResult):
    """Relative RMS errors of irradiance at some points of a room."""

    point: NDArray[np.float64]
    """Metres from the camera, (n, 3)."""

    error: NDArray[np.float64]
    """Error of the placed lights, (n,)."""

    error_at_infinity: NDArray[np.float64]
    """Error of the same light without positions, (n,)."""

    def in_short(self) -> str:
        """Mean errors."""
        means = percent(self.error.mean()), percent(self.error_at_infinity.mean())
        return f"error {means[0]} in the mean of {len(self.error)} points, {means[1]} at infinity"

    def table(self) -> Table:
        """Table of the first dozen points."""
        rows = [
            [
                *(f"{value:.2f}" for value in self.point[row]),
                percent(self.error[row]),
                percent(self.error_at_infinity[row]),
            ]
            for row in range(min(len(self.error), MOST_ROWS))
        ]
        return Table(["x", "y", "z", "error", "at infinity"], rows)

    def columns(self) -> dict[str, NDArray[Any]]:
        """Columns with a row for each point."""
        places = dict(zip("xyz", self.point.T, strict=True))
        return {**places, "error": self.error, "error_at_infinity": self.error_at_infinity}
