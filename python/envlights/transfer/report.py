"""Size, times and errors of a transfer model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from envlights._common.fields import fields_of, read_fields
from envlights._common.result import Result
from envlights._common.tables import Table
from envlights._common.times import time_lines
from envlights._common.words import percent


@dataclass(frozen=True, eq=False, repr=False)
class TransferReport(Result):
    """Size, times and errors of a transfer model.

    Errors are relative: the norm of the difference over the norm of the image, over all texels and
    channels, without clipping. Black images have none.
    """

    _is_headed = True

    pairs: int
    """Number of pairs."""

    rank: int
    """Number of directions in the basis."""

    energy: float
    """Fraction of the energy of the images that the basis represents."""

    ridge: float
    """Ridge parameter for direct images of norm 1."""

    unseen_errors: tuple[float, ...]
    """Leave-one-out error of each pair: the error to expect for new lights of the same kind. With
    ``nonnegative=True``, errors of 8-fold cross-validation. With a prior, also includes the error
    of the basis for new light."""

    training_errors: tuple[float, ...]
    """Error of each training pair in the trained model; a poor estimate for new lights."""

    prior_errors: tuple[float, ...] = ()
    """Error of the prior for each pair, without training; empty without a prior."""

    notes: tuple[str, ...] = ()
    """Notes on dropped channels, omitted images, unreached error bounds, and black texels."""

    seconds: Mapping[str, float] = field(default_factory=dict, compare=False)
    """Wall time of each stage."""

    @property
    def error(self) -> float:
        """Median of `unseen_errors`; infinite if there are none."""
        return float(np.median(self.unseen_errors)) if self.unseen_errors else np.inf

    def to_dict(self) -> dict[str, Any]:
        """All fields except the times as plain numbers, lists and strings."""
        return fields_of(self)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> TransferReport:
        """Report from the dictionary that `to_dict` returned."""
        return read_fields(cls, data)

    def in_short(self) -> str:
        """Size, energy and ridge."""
        size = f"rank {self.rank} from {self.pairs} pairs"
        return f"{size}, {percent(self.energy, 4)} of the energy, ridge {self.ridge:.3g}"

    def _table(self) -> Table:
        kinds = {
            "new lights (leave-one-out)": self.unseen_errors,
            "training images": self.training_errors,
            "prior alone": self.prior_errors,
        }
        rows = [[name, *_percentiles(errors)] for name, errors in kinds.items() if errors]
        columns = ["relative error", "median", "90th percentile", "worst"]
        return Table(columns, rows, "" if rows else "no errors, because all images are black")

    def _lines(self) -> list[str]:
        return [f"note: {note}" for note in self.notes]

    def _details(self) -> list[str]:
        return time_lines(self.seconds)


def _percentiles(errors: tuple[float, ...]) -> list[str]:
    """Median, 90th percentile and largest error, in percent."""
    return [percent(each) for each in (*np.percentile(errors, [50, 90]), max(errors))]
