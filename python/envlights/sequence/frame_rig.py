"""Rig of a frame in a sequence."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from envlights._common.check import amount, count, counts, flag
from envlights._native import EnvLightsError
from envlights.rigs.lights import Lights
from envlights.rigs.rig import Rig


@dataclass(frozen=True, eq=False, repr=False)
class FrameRig(Rig):
    """Rig of a frame, whose lights keep their identities over the sequence.

    Examples
    --------
    >>> sun = Lights([[0, 1, 0]], [[2, 2, 2]])
    >>> FrameRig([0.1, 0.1, 0.1], sun, 0.0, frame=7, ids=(3,))
    <FrameRig: frame 7, ambient + 1 light, error 0 %>
    """

    frame: int = 0
    """Index of the frame, from 0."""

    ids: tuple[int, ...] = ()
    """Identity of each light, in the order of `lights`."""

    fit_error: float = 0.0
    """Relative RMS error of the fit to this frame, before averaging over the window."""

    is_search: bool = False
    """True if the lights come from a full search."""

    is_step: bool = False
    """True if the scene's light changed abruptly at this frame."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, check in (
            ("frame", count),
            ("fit_error", amount),
            ("is_search", flag),
            ("is_step", flag),
        ):
            object.__setattr__(self, name, check(name, getattr(self, name)))
        object.__setattr__(self, "ids", tuple(counts("ids", self.ids)))
        if len(self.ids) != len(self.lights) or len(set(self.ids)) != len(self.ids):
            raise EnvLightsError(
                f"ids must be {len(self.lights)} different numbers, one of each light; got"
                f" {list(self.ids)}"
            )

    def light(self, identity: int) -> Lights:
        """Light with this identity, as `Lights` of length 1, or 0 if absent."""
        rows = [row for row, each in enumerate(self.ids) if each == identity]
        return self.lights[rows]

    def flux(self, identity: int) -> float:
        """Luminance of the irradiance of a light; 0 if the frame has no such light."""
        return float(np.sum(self.light(identity).luminance))

    def to_dict(self) -> dict[str, Any]:
        """All fields as plain numbers, lists and strings."""
        return {
            "frame_number": self.frame,
            "ids": list(self.ids),
            "fit_error": self.fit_error,
            "is_search": self.is_search,
            "is_step": self.is_step,
            **super().to_dict(),
        }

    def in_short(self) -> str:
        """Number of the frame, ambient term, number of lights and error."""
        return f"frame {self.frame}, {super().in_short()}"
