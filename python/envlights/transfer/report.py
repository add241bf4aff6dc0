"""Size, times and errors of a transfer model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from envlights._common import html
from envlights._common.check import amount, count
from envlights._common.result import Result
from envlights._common.tables import Table
from envlights._common.times import time_lines, times_of


@dataclass(frozen=True, eq=False, repr=False)
class TransferReport(Result):
    """Size, times and errors of a transfer model.

    Errors are relative: the norm of the difference over the norm of the image, over all texels and
    channels, without clipping. Black images have none.
    """

    pairs: int
    """Number of pairs."""

    rank: int
    """Directions of the basis."""

    energy: float
    """Fraction of the energy of the images that the basis holds."""

    ridge: float
    """Ridge for direct images of norm 1."""

    unseen_errors: tuple[float, ...]
    """Leave-one-out error of each pair, which new lights of the same kind will have; with
    ``nonnegative=True`` its error without its fold. With a prior, also the part of new light that
    the basis leaves out."""

    training_errors: tuple[float, ...]
    """Error of each pair in the model that was trained on it; says little about new lights."""

    prior_errors: tuple[float, ...] = ()
    """Error of each pair in the prior alone, which is not learnt from pairs; empty without one."""

    notes: tuple[str, ...] = ()
    """Remarks on dropped channels, omitted images, unreached bounds, and black texels."""

    seconds: Mapping[str, float] = field(default_factory=dict, compare=False)
    """Wall time of each stage."""

    @property
    def error(self) -> float:
        """Median of `unseen_errors`; infinite if there are none."""
        return float(np.median(self.unseen_errors)) if self.unseen_errors else np.inf

    def to_dict(self) -> dict[str, Any]:
        """All fields except the times as plain numbers, lists and strings."""
        return {name: value for name, value in asdict(self).items() if name != "seconds"}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> TransferReport:
        """Report that `to_dict` wrote."""
        return cls(
            pairs=count("pairs", data["pairs"]),
            rank=count("rank", data["rank"]),
            energy=amount("energy", data["energy"]),
            ridge=amount("ridge", data["ridge"]),
            unseen_errors=tuple(amount("unseen_errors", e) for e in data["unseen_errors"]),
            training_errors=tuple(amount("training_errors", e) for e in data["training_errors"]),
            prior_errors=tuple(amount("prior_errors", e) for e in data.get("prior_errors", ())),
            notes=tuple(str(note) for note in data["notes"]),
            seconds=times_of(data),
        )

    def in_short(self) -> str:
        """Size, energy and ridge."""
        size = f"rank {self.rank} from {self.pairs} pairs"
        return f"{size}, {100 * self.energy:.4g} % of the energy, ridge {self.ridge:.3g}"

    def verbose(self) -> str:
        """Text with the wall times."""
        return "\n".join([str(self), *time_lines(self.seconds)])

    def _html_parts(self) -> tuple[str, ...]:
        kinds = {
            "new lights (leave-one-out)": self.unseen_errors,
            "training images": self.training_errors,
            "prior alone": self.prior_errors,
        }
        rows = [[name, *_percentiles(errors)] for name, errors in kinds.items() if errors]
        table = Table(["relative error", "median", "90th percentile", "worst"], rows)
        return table.html(), html.lines("\n".join(f"note: {note}" for note in self.notes))

    def __str__(self) -> str:
        lines = [
            self.in_short(),
            f"error for new lights (leave-one-out): {_spread(self.unseen_errors)}",
            f"error for the training images:        {_spread(self.training_errors)}",
        ]
        if self.prior_errors:
            lines.append(f"error of the prior alone:            {_spread(self.prior_errors)}")
        lines += [f"note: {note}" for note in self.notes]
        return "\n".join(lines)


def _spread(errors: tuple[float, ...]) -> str:
    if not errors:
        return "all images are black"
    median, high, worst = _percentiles(errors)
    return f"median {median}, 90th percentile {high}, worst {worst}"


def _percentiles(errors: tuple[float, ...]) -> list[str]:
    """Median, 90th percentile and largest, in percent."""
    return [
        f"{100 * fraction:.3g} %" for fraction in (*np.percentile(errors, [50, 90]), max(errors))
    ]
