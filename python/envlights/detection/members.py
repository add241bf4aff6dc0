"""Pixels that belong to detected lights."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.arrays import seal
from envlights._common.result import Result
from envlights._native import EnvLightsError
from envlights.environment.files.images import MOST_PIXELS


@dataclass(frozen=True, eq=False, repr=False)
class Members(Result):
    """Pixels or samples of the lights, in the reduced map on which they were detected."""

    pixel: NDArray[np.int64]
    """Row and column in the reduced map, shape (k, 2)."""

    light: NDArray[np.int64]
    """Index of the light of each pixel, shape (k,)."""

    others: NDArray[np.int64] = field(default_factory=lambda: np.zeros((0, 2), int), compare=False)
    """Pixels of lights that a slice omitted, shape (j, 2); not stored in files."""

    def in_short(self) -> str:
        """Number of pixels or samples."""
        return f"{len(self.pixel)} pixels or samples"

    def of(self, kept: NDArray[np.intp], lights: int) -> Members:
        """Members of the `kept` lights, renumbered; `lights` is the original number."""
        place = np.full(lights, -1)
        place[kept] = np.arange(len(kept))
        light = place[self.light]
        others = np.concatenate([self.others, self.pixel[light < 0]])
        return Members(self.pixel[light >= 0], light[light >= 0], others)

    def renumbered(self, rank: NDArray[np.intp]) -> Members:
        """Members of the same lights in another order; light j becomes light ``rank[j]``."""
        return replace(self, light=seal(rank[self.light]))

    def to_runs(self) -> list[list[int]]:
        """Rows (light, row, first column, length) for each run of pixels, in order.

        See Also
        --------
        from_runs : the inverse.
        """
        row, column = self.pixel.T
        # Continue a run while light and row stay the same and the column is the next one.
        steps = np.diff(self.light), np.diff(row), np.diff(column) - 1
        starts = np.flatnonzero(np.append(True, np.any(steps, axis=0))) if len(row) else row
        lengths = np.diff(np.append(starts, len(row)))
        parts = self.light[starts], row[starts], column[starts], lengths
        runs: list[list[int]] = np.stack(parts, axis=1).tolist()
        return runs

    @classmethod
    def from_runs(cls, runs: list[list[int]], lights: int, size: tuple[int, int]) -> Members:
        """Members of `lights` lights, from runs in an image of this height and width."""
        light, row, column, length = np.reshape(np.asarray(runs, np.int64), (-1, 4)).T
        if length.sum() > MOST_PIXELS:
            raise EnvLightsError(
                f"members must be {MOST_PIXELS} pixels at most; got {length.sum()}"
            )
        inside = (light >= 0) & (light < lights) & (row >= 0) & (row < size[0])
        inside &= (column >= 0) & (length > 0) & (column + length <= size[1])
        if not inside.all():
            bad = np.asarray(runs)[~inside][0].tolist()
            raise EnvLightsError(
                f"members must lie in the {size[1]}x{size[0]} pixels and belong to one of"
                f" {lights} lights; got light, row, column, length {bad}"
            )
        along = np.arange(length.sum()) - np.repeat(np.cumsum(length) - length, length)
        pixel = np.stack([row.repeat(length), column.repeat(length) + along], axis=1)
        return cls(pixel, light.repeat(length))


class LeftOut(Members):
    """Placeholder for omitted members; access to its arrays raises an error."""

    def __init__(self) -> None:
        pass

    def __getattr__(self, name: str) -> Any:
        if name not in {each.name for each in fields(Members)}:
            raise AttributeError(f"{type(self).__name__} has no attribute '{name}'")
        raise EnvLightsError(
            "the pixels of these lights were left out, as of all lights from a pickle or another"
            " process; detect the lights again, or save them as .json, which keeps the pixels"
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return LeftOut, ()

    def in_short(self) -> str:
        """Text that says that the pixels were left out."""
        return "left out"

    def of(self, kept: NDArray[np.intp], lights: int) -> Members:
        """The placeholder itself."""
        return self

    def renumbered(self, rank: NDArray[np.intp]) -> Members:
        """The placeholder itself."""
        return self
