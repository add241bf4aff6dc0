"""Fits of consecutive frames: each continues the last, with a full search when it pays."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights.environment.reading import AnyMap
from envlights.fitting.map_fit import MapSamples, continue_rig, fit_reduction, reduce_for_fits
from envlights.fitting.reduction import Reduction
from envlights.fitting.request import FitArguments
from envlights.rigs.lights import Lights
from envlights.rigs.rig import Rig, error_of
from envlights.sequence.steps import Steps
from envlights.sequence.window import error_under, thin

#: Growth of the error above its reference level at which a full search runs.
_GROWTH = 1.1
#: Frames after which a full search runs in any case (1 / 24 of the time of full fits), so that
#: slowly changing scenes do not stay in a local minimum.
_PERIOD = 24
#: Fraction by which a search must reduce the error; otherwise the lights of the last frame are
#: kept.
_WORTH = 0.05
#: Fraction of a requested error that a search must reach, as a margin for the next frame.
_MARGIN = 0.9
#: Fraction of a requested error below which a search for fewer lights runs.
_SURPLUS = 0.5
#: Error below which no search runs: the accuracy of a reduced map.
_ACCURACY = 1e-4


class Fit(NamedTuple):
    """Fit to a single frame."""

    rig: Rig
    samples: MapSamples
    is_search: bool
    """True if the lights come from a full search."""
    is_step: bool = False
    """True if the scene's light changed abruptly."""


@dataclass
class Continuation:
    """Fits of consecutive frames with the same arguments."""

    arguments: FitArguments
    """Arguments of `fit`, with the largest number of lights."""
    _level: float = field(default=np.inf, init=False)
    """Smallest error since the last search, as the reference level."""
    _frames: int = field(default=0, init=False)
    """Number of frames since the last search."""
    _steps: Steps = field(default_factory=Steps, init=False)

    def fit(self, env: AnyMap, start: Lights | None) -> Fit:
        """Fit to the next frame, starting from the expected lights `start`.

        None for the first frame.
        """
        reduction = reduce_for_fits(env, self.arguments)
        if start is None:
            rig = self._search(reduction)
            first = _of_search(rig, self._continue(reduction, rig.lights))
            self._steps.is_step(first.samples)
            return self._restart(first)
        self._frames += 1
        near = self._continue(reduction, start)
        near = near._replace(is_step=self._steps.is_step(near.samples))
        if not (near.is_step or self._is_search_due(near.rig)):
            self._level = min(self._level, _error(near.rig))
            return near
        far = self._search(reduction)
        if self._is_worth(far, near.rig):
            near = _of_search(far, near)
        return self._restart(near)

    def _search(self, reduction: Reduction) -> Rig:
        """Rig of a full search, with a margin to the requested error."""
        goal = self.arguments.error
        arguments = replace(self.arguments, error=None if goal is None else _MARGIN * goal)
        return fit_reduction(reduction, arguments)[0]

    def _continue(self, reduction: Reduction, start: Lights) -> Fit:
        """Fit by descent from the expected lights, keeping their number."""
        if self.arguments.floor:
            start = replace(start, direction=_above_horizon(start.direction))
        if not self.arguments.sizes:
            rig, samples = self._refill(reduction, start)
            return Fit(rig, thin(samples), False)
        ambient = str(self.arguments.ambient)
        rig, samples = continue_rig(reduction, self.arguments, start, ambient)
        if len(rig.lights) < len(start):
            rig, _ = self._refill(reduction, start)
        return Fit(rig, samples, False)

    def _refill(self, reduction: Reduction, start: Lights) -> tuple[Rig, MapSamples]:
        """Fit by descent from the expected directions, with black lights replaced."""
        arguments = replace(self.arguments, lights=len(start), start=start, error=None)
        return fit_reduction(reduction, arguments)

    def _restart(self, fit: Fit) -> Fit:
        """Use the error of a fit as the reference level for later fits."""
        self._level, self._frames = _error(fit.rig), 0
        return fit

    def _is_search_due(self, near: Rig) -> bool:
        """True if the error has grown, the period is over, or a requested error is missed."""
        goal = self.arguments.error
        if goal is not None:
            return error_of(near) > goal or (
                self._frames >= _PERIOD and error_of(near) < _SURPLUS * goal
            )
        has_grown = _error(near) > max(_GROWTH * self._level, _ACCURACY)
        return has_grown or self._frames >= _PERIOD

    def _is_worth(self, far: Rig, near: Rig) -> bool:
        """True if the result of a search is enough better to replace the continued lights."""
        goal = self.arguments.error
        if goal is not None and error_of(near) <= goal:
            return len(far.lights) < len(near.lights) and error_of(far) <= goal
        return _error(far) < (1 - _WORTH) * _error(near)


def _of_search(rig: Rig, continued: Fit) -> Fit:
    measured_on = continued.rig.report.measured_on
    found = replace(
        rig,
        error=error_under(rig, continued.samples),
        report=replace(rig.report, measured_on=measured_on),
    )
    return continued._replace(rig=found, is_search=True)


def _error(rig: Rig) -> float:
    error = rig.report.objective_error
    return error_of(rig) if error is None else error


def _above_horizon(directions: NDArray[np.float64]) -> NDArray[np.float64]:
    raised = directions.copy()
    raised[:, 1] = np.maximum(raised[:, 1], 0)
    return np.asarray(raised / np.linalg.norm(raised, axis=1, keepdims=True))
