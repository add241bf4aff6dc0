"""Fit to a map: check the arguments, reduce the map, call the kernel, report."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._common.check import check_choice, flag
from envlights._common.notes import LOG, black_note, log
from envlights._common.times import Clock
from envlights._native import FitAnswer
from envlights.environment.envmap import EnvMap
from envlights.environment.fill import checked_unseen
from envlights.environment.open import doubts_of_array
from envlights.environment.reading import AnyMap, apply_to_map
from envlights.export.targets import shown_by, target_names
from envlights.fitting import wording
from envlights.fitting.reduction import Reduction, is_file, reduction_of, reduction_of_file
from envlights.fitting.request import (
    AMBIENTS,
    AUTO,
    FitArguments,
    FitOptions,
    Request,
    ambient_for,
    ambient_names,
    check_over_floor,
    check_radius,
    request_for,
)
from envlights.fitting.result import rig_of
from envlights.rigs.lights import Lights, brightest_first
from envlights.rigs.report import FitReport
from envlights.rigs.rig import Rig

#: Objectives for fits of lights with sizes.
OBJECTIVES = ("mixed", "shadows", "probe")

#: Relative RMS error of the irradiance of a reduced map: 3e-5 to 1.4e-4 on 14 real maps. Lights
#: that reduce the error further would only fit errors of the reduction.
RENDERING_ERROR = 1e-4

#: Result of the kernel for each ambient term.
Answers = dict[str, FitAnswer]


class _Plan(NamedTuple):
    """Checked arguments of a fit to a map."""

    request: Request
    ambients: tuple[str, ...]
    """Ambient terms to compare."""
    is_auto: bool
    """True for ``ambient="auto"``, also if there is one choice."""
    of_discs: str | None
    """Error that discs minimise; None for points."""
    target: tuple[str, ...]
    arguments: FitArguments

    @property
    def has_sized_error(self) -> bool:
        """True if the error of points and that of discs differ: with a goal, all have sizes."""
        return self.of_discs is not None and not self.request.has_goal


class MapSamples(NamedTuple):
    """Irradiance under a map, at the normals where a fit measures its error."""

    normals: NDArray[np.float64]
    """Unit normals, (n, 3)."""

    weights: NDArray[np.float64]
    """Solid angle of each normal, (n,)."""

    irradiance: NDArray[np.float64]
    """Irradiance there, (n, 3)."""


def reduce_for_fits(env: AnyMap, arguments: FitArguments) -> Reduction:
    """Reduction of a map, for fits with the same `floor` and `fill`."""
    plan = _plan(arguments)._replace(ambients=())  # fits nothing
    return _answers(env, plan, Clock())[0]


def fit_reduction(reduction: Reduction, arguments: FitArguments) -> tuple[Rig, MapSamples]:
    """Rig for a reduced map, and the irradiance under the map, which the fit computes anyway.

    The start is "greedy" or lights; others need the whole map.
    """
    plan, clock = _plan(arguments), Clock()
    start = plan.request.first_directions_under(None, arguments.floor)
    (answers,) = _under(reduction, plan, start, [plan.request.lights])
    rig = _clocked_rig(plan, reduction, answers, clock)
    # All answers are for the same map, and fits to a map have samples.
    samples = next(iter(answers.values())).map_samples
    return rig, MapSamples(*samples)  # type: ignore[misc]


def check_arguments(arguments: FitArguments) -> None:
    """Refuse arguments that no map could be fitted with, before a map is read."""
    _plan(arguments)


def fit_map(env: AnyMap, arguments: FitArguments) -> Rig:
    """Rig for a map; see `fit`."""
    plan, clock = _plan(arguments), Clock()
    reduction, (answers,) = _answers(env, plan, clock)
    rig = _clocked_rig(plan, reduction, answers, clock)
    LOG.info("fit: %s in %.3g seconds", rig.in_short(), sum(rig.report.seconds.values()))
    log(rig.notes)
    return rig


def fit_map_by_count(env: AnyMap, arguments: FitArguments, counts: list[int]) -> list[Rig]:
    """Rigs for a map for several limits on the number of lights, equal to results of `fit_map`.

    The arguments have the start "greedy", and no error or fixed lights. The rigs share all work on
    the map and the forward selection.
    """
    plans = [_plan(replace(arguments, lights=count)) for count in counts]
    largest, clock = max(plans, key=lambda plan: plan.request.lights), Clock()
    reduction = reduce_for_fits(env, largest.arguments)
    clock.lap("reduce")
    first = largest.request.first_directions_under(None, arguments.floor)
    fits = _under(reduction, largest, first, counts)
    return [
        _clocked_rig(plan, reduction, answers, Clock(clock.laps))
        for plan, answers in zip(plans, fits, strict=True)
    ]


def _clocked_rig(plan: _Plan, reduction: Reduction, answers: Answers, clock: Clock) -> Rig:
    """Rig of the best result, with the total times of all steps."""
    for answer in answers.values():
        clock.add(answer.seconds)
    rig = _rig(plan, reduction, answers, clock.laps)
    clock.lap("report")
    return rig


def _plan(arguments: FitArguments) -> _Plan:
    check_choice("objective", arguments.objective, OBJECTIVES)
    target = target_names(arguments.target)
    shows = shown_by(target)
    request = request_for(arguments, most_lights=shows.lights)
    has_sizes = flag("sizes", arguments.sizes)
    check_radius(arguments.max_radius, has_sizes)
    checked_unseen(arguments.fill)
    ambient = ambient_for(arguments.ambient, bool(target), shows)
    if flag("floor", arguments.floor):
        check_over_floor(ambient, request, shows)
    names = ambient_names(arguments.floor, shows) if ambient == AUTO else (ambient,)
    of_discs = arguments.objective if has_sizes and shows.sizes == "spread" else None
    return _Plan(request, names, ambient == AUTO, of_discs, target, arguments)


def _answers(env: AnyMap, plan: _Plan, clock: Clock) -> tuple[Reduction, list[Answers]]:
    """Reduced map, and for each limit the results with each ambient term."""
    request, floor, counts = plan.request, plan.arguments.floor, [plan.request.lights]

    def under_map(world: EnvMap) -> tuple[Reduction, list[Answers]]:
        first = request.first_directions_under(world, floor)
        clock.lap("start")
        reduction = reduction_of(world, floor, plan.arguments.fill)
        if world is not env:
            doubts = doubts_of_array(world._pixels, reduction.cells.overview)
            reduction = reduction._replace(notes=(*reduction.notes, *doubts))
        clock.lap("reduce")
        return reduction, _under(reduction, plan, first, counts)

    if is_file(env) and not request.needs_map:
        reduction = reduction_of_file(env, floor)
        clock.lap("read")
        if reduction is not None:
            first = request.first_directions_under(None, floor)
            return reduction, _under(reduction, plan, first, counts)
    return apply_to_map(env, under_map)[1]


def _under(
    reduction: Reduction, plan: _Plan, first: NDArray[np.float64], counts: list[int]
) -> list[Answers]:
    """Best results with each kind of ambient term, for each limit on the number of lights."""
    options = {name: _options(reduction, plan, first, name) for name in plan.ambients}
    fits = [_native.fit_reduced(reduction.cells, one, counts) for one in options.values()]
    return [dict(zip(options, row, strict=True)) for row in zip(*fits, strict=True)]


def _options(
    reduction: Reduction, plan: _Plan, first: NDArray[np.float64], ambient: str
) -> FitOptions:
    request = plan.request
    return FitOptions(
        AMBIENTS[ambient],
        np.concatenate([request.fixed, first]),
        len(request.fixed),
        request.lights,
        request.error,
        request.shadow_error,
        request.gloss_error,
        request.gloss_factors,
        sizes=plan.of_discs,
        max_radius=plan.arguments.max_radius,
        floor=reduction.cells.floor,
        error_floor=RENDERING_ERROR,
    )


def _rig(plan: _Plan, reduction: Reduction, answers: Answers, seconds: dict[str, float]) -> Rig:
    request, floor = plan.request, plan.arguments.floor
    chosen = request.best_of(answers, RENDERING_ERROR) if plan.is_auto else plan.ambients[0]
    answer = answers[chosen]
    compared = {name: (one.lights, one.error) for name, one in answers.items()}
    return rig_of(
        answer,
        request,
        notes=_notes(reduction, np.array(answer.channels), floor),
        units=reduction.units,
        floor=floor,
        sized_error=answer.error if plan.has_sized_error and answer.lights else None,
        # The report holds this dictionary by reference; an entry may be added later.
        seconds=seconds,
        measured_on=wording.measured_on("all", floor),
        shadow_error=answer.shadow_error,
        target=plan.target,
        has_max_radius=plan.arguments.max_radius is not None,
        ambient=chosen,
        ambients=compared if plan.is_auto else {},
        fewer_lights=wording.fewer_lights(answer, request, RENDERING_ERROR),
        coverage_fraction=reduction.coverage_fraction,
        unseen_spread=reduction.unseen_spread,
        skipped=(
            *wording.working_map(reduction.width, answer.points, RENDERING_ERROR),
            *wording.channels(answer),
        ),
    )


def _notes(reduction: Reduction, light: NDArray[Any], floor: bool) -> tuple[str, ...]:
    """Notes of a rig; `light` is 0 under a black map."""
    black = black_note(light, "map above the horizon" if floor else "map")
    return (*black, *reduction.notes, *wording.clipping(reduction.clipped_flux_fraction))


def continue_rig(
    reduction: Reduction, arguments: FitArguments, lights: Lights, ambient: str
) -> tuple[Rig, MapSamples]:
    """Rig refined from `lights` with sizes to the nearest minimum, and the irradiance of the map.

    No other lights are searched for, and those that are black there are left out. The report holds
    the errors alone.
    """
    options = FitOptions(
        AMBIENTS[ambient],
        lights.direction,
        0,
        len(lights),
        sizes=arguments.objective,
        max_radius=arguments.max_radius,
    )
    answer = _native.continue_reduced(reduction.cells, options, lights.angular_radius)
    sky, direction, irradiance, radii, error, objective_error, samples = answer
    order = brightest_first(irradiance)
    rows = direction[order], irradiance[order], np.array(radii)[order]
    rig = Rig(
        sky if len(sky) > 1 else sky.sum(axis=0),
        Lights.unchecked(*rows, reduction.units),
        error,
        FitReport(
            objective_error=objective_error,
            measured_on=wording.measured_on(len(samples[1]), arguments.floor),
            ambient=ambient,
        ),
        _notes(reduction, samples[2], arguments.floor),
        arguments.floor,
    )
    return rig, MapSamples(*samples)
