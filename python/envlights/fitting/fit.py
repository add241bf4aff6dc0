"""From a map, or from a measured probe, to a rig."""

from __future__ import annotations

from collections.abc import Mapping
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native
from envlights._check import check_choice, flag, reals
from envlights._native import EnvLightsError, FitAnswer
from envlights.envmap import AnyMap, EnvMap, seen_through
from envlights.fitting import notes
from envlights.fitting.answer import rig_of
from envlights.fitting.asked import STARTS_WITHOUT_MAP, Asked, asked
from envlights.fitting.options import FitOptions
from envlights.kernels.probe import WORKING_COLUMNS
from envlights.lights import Lights
from envlights.rig import Rig

#: Environments beside the lights, the simplest first, and the number of their coefficients in each
#: channel.
AMBIENTS = {"none": 0, "constant": 1, "sh2": 9}
#: The one of them that the map asks for.
AUTO = "auto"
#: What lights with sizes are fitted to.
OBJECTIVES = ("mixed", "shadows", "probe")

#: Error of the working map: on 14 real maps the relative RMS difference of its irradiance from the
#: exact one was 3e-5 to 1.4e-4. Below it, lights would follow the error of the rendering.
RENDERING_ERROR = 1e-4
#: Share of the flux of a channel from which a cell of the working map stays a point source.
POINT_SHARE = 5e-3
#: An environment that lowers the error by less than this share of it does not pay for itself.
SAME_ERROR = 1e-3


def fit(
    env: AnyMap,
    lights: int | None = None,
    *,
    error: float | None = None,
    shadow_error: float | None = None,
    sizes: bool = True,
    objective: str = "mixed",
    ambient: str = "constant",
    start: str | Rig | Lights = "greedy",
    fixed: ArrayLike | Lights | None = None,
    floor: bool = False,
) -> Rig:
    """Ambient and a few lights that light a scene as `env` does.

    The squared difference of two white Lambertian probes, under the map and under the lights, is
    integrated over all normals in closed form. The lights are found by variable projection with
    non-negative radiances: lights are added one at a time where they lower that integral most
    (forward selection), other sets start from evenly spread directions, and the best sets exchange
    lights while that pays. Each descent takes Gauss-Newton steps, then exact Newton steps. No light
    is added below an error of 1e-4, which is that of the reduced map. The error is measured on
    probes at 5120 normals.

    A last descent gives every light a size: it becomes a disc of uniform radiance, whose direction,
    radius and radiance are found together. It minimises an error that sees shadows: the irradiance
    at every normal, with everything hidden that is behind a plane, over all planes. That error has
    a closed form too, and `report` tells it beside the error of the probe.

    For objects that stand on a floor, give ``floor=True``: the floor hides the light from below,
    from the objects and from itself. For objects in the air, or with nothing below them in the
    scene, leave it out.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map; an array is taken as `EnvMap` takes it.
    lights : int, optional
        How many lights at most, 0 or more. Fewer come back where more would not lower the error.
        Left out: 4, or as many as `fixed` or `start` have, or up to 32 where an `error` or a
        `shadow_error` is asked for.
    error : float, optional
        Relative RMS error that is good enough: the fewest lights that reach it come back, which
        may be none. `report` holds the error for each number that was tried, and says whether
        `lights` were enough.
    shadow_error : float, optional
        The same for the error that sees shadows. With both, the fewest lights that reach both.
    sizes : bool
        Whether lights become discs. Their angular radii are at most 75 degrees; over a `floor`, at
        most their elevation. A radius of 0 is a point. Without sizes all lights are points.
    objective : {"mixed", "shadows", "probe"}
        What the discs are fitted to: the error with shadows, that of the probe with nothing in the
        way, or a mean of both, which is nearly as good as either alone.
    ambient : {"constant", "none", "sh2", "auto"}
        "constant": beside the lights, an environment of one radiance. "none": lights alone. "sh2":
        an environment of nine spherical harmonics, the form that real-time engines take; its
        irradiance is nowhere negative. "auto": of these three, where an `error` is asked for, the
        one that reaches it with the fewest lights, else the one of least error; the simplest where
        several do as well. `report.ambient` and `report.ambients` tell the choice and the figures
        of each.
    start : {"greedy", "detect", "even"}, Rig or Lights
        "greedy": the whole search. All others descend from given directions, without the search,
        and add further lights where the residual is largest. "detect": from the bright places that
        `detect` finds, so that each light stays with its lamp. "even": from points spread over the
        sphere (Madsen et al. 2003, section 3.2); this often ends in a local minimum. A rig, or
        lights: from theirs, as for the next frame of a video. Only directions are taken from it, so
        give `lights` and `ambient` for every frame. Lights are matched by their directions: their
        order is that of the brightness in this frame.
    fixed : array_like, shape (k, 3), or Lights, optional
        Unit vectors towards lights that stay where they are; only their radiances and sizes are
        fitted. They count among `lights`, and are returned even if black. `report.fixed` holds
        their rows among the lights of the rig.
    floor : bool
        Whether there is a floor in the scene, which hides what is below the horizon. Then light
        from there neither counts nor is used: all lights stand above the horizon, and the `ambient`
        radiance lights a normal n by ``pi / 2 (1 + n_y)`` times itself. The error is that over a
        floor, and `Rig.probe` gives the irradiance over one. A renderer hides the lower half itself
        once the floor is in its scene.

    Returns
    -------
    Rig
        Ambient radiance and lights, none negative, with the error and a report.

    Raises
    ------
    EnvLightsError
        If `env` is not a map, `lights` not a count or fewer than `fixed`, `error` or `shadow_error`
        not a share, a `fixed` direction not a unit vector, or `objective`, `ambient` or `start` not
        known; with a `floor`, for "sh2", and for `fixed` or `start` lights below the horizon.

    See Also
    --------
    fit_probe : the same fit on probe values from elsewhere.

    References
    ----------
    C. B. Madsen, M. K. D. Sørensen, M. Vittrup: "Estimating Positions and Radiances of a Small
    Number of Light Sources for Real-Time Image-Based Lighting", Eurographics 2003; section 3.
    Variable projection: G. H. Golub, V. Pereyra: "The Differentiation of Pseudo-Inverses and
    Nonlinear Least Squares Problems Whose Variables Separate", SIAM Journal on Numerical Analysis,
    1973. The integral over all normals is the arc-cosine kernel of order 1: Y. Cho, L. K. Saul:
    "Kernel Methods for Deep Learning", NIPS 2009.

    Examples
    --------
    A sun at the zenith over a grey world:

    >>> import envlights as el
    >>> world = el.synthetic.scene(
    ...     64,
    ...     background=(0.5, 0.5, 0.5),
    ...     shapes=[el.synthetic.Disc((0, 1, 0), 2.0, (500, 500, 500))],
    ... )
    >>> rig = el.fit(world.radiance, lights=1)
    >>> rig.lights.direction.round(3) + 0.0
    array([[0., 1., 0.]])
    >>> rig.error < 0.01
    True
    """
    check_choice("ambient", ambient, (*AMBIENTS, AUTO))
    check_choice("objective", objective, OBJECTIVES)
    wanted = asked(lights, error, start, fixed, shadow_error=shadow_error)
    of_discs = objective if flag("sizes", sizes) else None
    if flag("floor", floor):
        _check_over_floor(ambient, wanted)
    names = tuple(AMBIENTS)[: 2 if floor else 3] if ambient == AUTO else (ambient,)
    clock = _Clock()

    def answers_under(world: EnvMap) -> dict[str, FitAnswer]:
        first = wanted.first_directions_under(world, floor)
        clock.lap("start")
        return {name: _answer(world, wanted, first, name, of_discs, floor) for name in names}

    world, answers = seen_through(env, answers_under)
    clock.lap("fit")
    chosen = _chosen(answers, wanted) if ambient == AUTO else ambient
    answer = answers[chosen]
    rig = rig_of(
        answer,
        wanted,
        notes=(*world.notes, *notes.clipping(world)),
        floor=floor,
        # Where an error was asked for, all numbers of lights had sizes.
        sized_error=answer.error if of_discs and answer.lights and not wanted.has_goal else None,
        # This stage is noted once it has ended.
        seconds=clock.laps,
        measured_on=notes.measured_on(answer.judging, floor),
        shadow_error=answer.shadow_error,
        ambient=chosen,
        ambients={name: (one.lights, one.error) for name, one in answers.items()}
        if ambient == AUTO
        else {},
        skipped=(
            *notes.working_map(world, answer.points, RENDERING_ERROR),
            *notes.channels(answer),
            *notes.fewer_lights(answer, wanted, RENDERING_ERROR),
        ),
    )
    clock.lap("report")
    return rig


def fit_probe(
    normals: ArrayLike,
    irradiance: ArrayLike,
    lights: int | None = None,
    *,
    weights: ArrayLike | None = None,
    ambient: str = "constant",
    start: str | Rig | Lights = "greedy",
    fixed: ArrayLike | Lights | None = None,
) -> Rig:
    """Ambient and at most `lights` directional lights from probe values measured elsewhere.

    The same fit as `fit`, on irradiance that was measured or rendered by another program: the
    squared error is summed over `normals`. The horizon of each normal puts a kink into that sum, so
    the search ends with descents from perturbed lights. Without a map the rig cannot be judged at
    other normals: its error is the one at `normals`, which is too low where they are few. The
    values are taken as measured, with noise that the channels may share: `report` holds standard
    errors and a condition number.

    Parameters
    ----------
    normals : array_like, shape (n, 3)
        Unit normals, in the frame of `EnvMap`.
    irradiance : array_like, shape (n, 3)
        RGB irradiance at each. For the radiance of a white Lambertian probe, give pi times it.
    lights : int, optional
        How many directional lights, 0 or more. Left out: 4, or as many as `fixed` or `start` have.
    weights : array_like, shape (n,), optional
        Weight of each normal, such as the solid angle it stands for. All alike when left out.
    ambient : {"constant", "none", "sh2"}
        As for `fit`.
    start : {"greedy", "even"}, Rig or Lights
        As for `fit`.
    fixed : array_like, shape (k, 3), or Lights, optional
        As for `fit`.

    Returns
    -------
    Rig
        Ambient radiance and lights, none negative, with the error and a report.

    Raises
    ------
    EnvLightsError
        If shapes do not fit, a value is not finite, a normal is not a unit vector, a weight is
        negative or all are 0, or there are fewer equations than unknowns: 5 for each light, and 3
        for "constant" or 27 for "sh2".

    See Also
    --------
    fit : the fit to a map, at every normal.

    References
    ----------
    Madsen, Sørensen and Vittrup (2003), section 3; Golub and Pereyra (1973); see `fit`.

    Examples
    --------
    >>> from envlights import kernels
    >>> normals, solid_angles = kernels.icosphere(320)
    >>> probe = kernels.rig_irradiance(normals, [0.1, 0.1, 0.1], [[0, 0.6, 0.8]], [[3, 2, 1]])
    >>> rig = fit_probe(normals, probe, lights=1)
    >>> rig.lights.direction.round(6) + 0.0, rig.lights.irradiance.round(6)
    (array([[0. , 0.6, 0.8]]), array([[3., 2., 1.]]))
    """
    check_choice("ambient", ambient, tuple(AMBIENTS))
    wanted = asked(lights, None, start, fixed, STARTS_WITHOUT_MAP)
    normals, irradiance = reals("normals", normals, 2), reals("irradiance", irradiance, 2)
    weights = np.ones(len(normals)) if weights is None else reals("weights", weights, 1)
    if len(weights) and not weights.any():
        raise EnvLightsError("weights must not all be 0")
    # The kernel sums fourth powers of irradiance, which would overflow in candela per square metre
    # of the sun; so irradiance is brought to about 1.
    brightest = float(np.abs(irradiance).max(initial=0.0))
    scale = brightest if 0 < brightest < np.inf else 1.0
    clock = _Clock()
    first = wanted.first_directions(len(normals))
    directions = np.concatenate([wanted.fixed, first])
    options = FitOptions(AMBIENTS[ambient], directions, len(wanted.fixed), wanted.lights)
    answer = _native.fit_samples(normals, weights, irradiance / scale, options)
    clock.lap("fit")
    rig = rig_of(
        answer,
        wanted,
        scale=scale,
        # This stage is noted once it has ended.
        seconds=clock.laps,
        measured_on=f"the {len(normals)} fitted normals",
        ambient=ambient,
        skipped=(*notes.channels(answer), *notes.fewer_lights(answer, wanted, 0.0)),
    )
    clock.lap("report")
    return rig


class _Clock:
    """Wall time of each stage."""

    def __init__(self) -> None:
        self.laps: dict[str, float] = {}
        self._last = perf_counter()

    def lap(self, stage: str) -> None:
        """Note the time since the last lap under `stage`."""
        now = perf_counter()
        self.laps[stage] = now - self._last
        self._last = now


def _check_over_floor(ambient: str, wanted: Asked) -> None:
    """Refuse what makes no sense, or is not fitted, where a floor hides the lower half."""
    if ambient == "sh2":
        raise EnvLightsError(
            "ambient must be 'none' or 'constant' or 'auto' where there is a floor: harmonics that"
            " it half hides are not fitted; got 'sh2'"
        )
    wanted.check_above_horizon()


def _answer(
    env: EnvMap,
    wanted: Asked,
    first: NDArray[np.float64],
    ambient: str,
    objective: str | None,
    floor: bool,
) -> FitAnswer:
    """The best rig under `env` with one kind of `ambient` term; points without an `objective`."""
    options = FitOptions(
        AMBIENTS[ambient],
        np.concatenate([wanted.fixed, first]),
        len(wanted.fixed),
        wanted.lights,
        wanted.error,
        wanted.shadow_error,
        sizes=objective,
        floor=floor,
        error_floor=RENDERING_ERROR,
    )
    is_border_sampled = env.registration == "border-sampled"
    return _native.fit_map(env.radiance, is_border_sampled, WORKING_COLUMNS, POINT_SHARE, options)


def _chosen(answers: Mapping[str, FitAnswer], wanted: Asked) -> str:
    """The ambient term that is good enough with the fewest lights; else that of least error.

    `answers` hold the simplest first, which is chosen where several do as well.
    """
    reached = {
        name: answer.lights
        for name, answer in answers.items()
        if wanted.is_reached(answer.error, answer.shadow_error)
    }
    if reached:
        return min(reached, key=lambda name: reached[name])
    least = min(answer.error for answer in answers.values())
    enough = max(least * (1 + SAME_ERROR), RENDERING_ERROR)
    return next(name for name, answer in answers.items() if answer.error <= enough)
