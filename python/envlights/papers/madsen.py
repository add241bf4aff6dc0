"""Madsen, Sørensen and Vittrup (2003), section 3: the fit, and its equations on arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.arrays import freeze
from envlights._common.check import amount, colour, count, reals
from envlights._common.interruptible import interruptible
from envlights._common.result import Result
from envlights._common.tables import Table
from envlights._common.units import OWN_SCALE
from envlights._common.words import percent
from envlights._native import EnvLightsError
from envlights.environment.envmap import EnvMap
from envlights.environment.fill import Fill
from envlights.environment.reading import AnyMap, as_envmap
from envlights.fitting.wording import clipping
from envlights.kernels import probe, sampling
from envlights.kernels.angles import azimuths, elevations
from envlights.kernels.madsen import (
    face_radiance,
    pack_lights,
    probe_jacobian,
    probe_model,
    probe_residual,
    unpack_lights,
)
from envlights.rigs.lights import Lights, rgb_cell, rgb_heading
from envlights.rigs.report import FitReport, StopReason
from envlights.rigs.rig import Rig

__all__ = ["PaperFit", "face_radiance", "fit", "pack_lights", "probe_jacobian", "probe_model"]
__all__ += ["probe_residual", "unpack_lights"]

#: Faces of the probe and of the scene (section 3.1).
PROBE_FACES, SCENE_FACES = 320, 5120
#: Limit on the number of steps; the paper needs about 20.
MAX_STEPS = 50

#: Largest rotation of a light in a damped step, in radians, so that lights do not jump past each
#: other.
_LARGEST_TURN = 0.25
#: Largest rotation in radians, and relative change of radiance, in the final step.
_SMALL_STEP = 1e-4
#: Relative decrease of the error below which a damped fit stops.
_SMALL_FALL = 1e-9
#: Relative RMS error that is treated as zero.
_EXACT = 1e-12
#: Number of halvings of a damped step after which the fit has converged.
_HALVINGS = 30
#: Largest reflection coefficient, so that its square and those of radiances stay finite.
_STRONGEST = 1e100

_Reals = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class PaperFit(Result):
    """Result of the method in the paper; lights may be negative."""

    ambient: _Reals
    """Radiance `L_a` of the ambient light, shape (3,), scaled by `k_a`; 0 if `k_a` is 0."""

    direction: _Reals
    """Unit vectors to the lights, shape (m, 3), in the order of the start."""

    irradiance: _Reals
    """Irradiance of each light at normal incidence, the paper's `L_j` times its solid angle; shape
    (m, 3), may be negative."""

    errors: tuple[float, ...]
    """Relative RMS error at the 320 fitted normals, at the start and after each step."""

    stop_reason: StopReason
    """Reason why the fit stopped."""

    k_a: float
    """Coefficient of ambient reflection."""

    k_d: float
    """Coefficient of diffuse reflection."""

    notes: tuple[str, ...] = ()
    """Notes on changed samples of the map, and on assumptions."""

    units: str = OWN_SCALE
    """Unit of the map; see `EnvMap.units`."""

    def in_short(self) -> str:
        """Number of lights, error, steps and stop reason."""
        lights = f"{len(self.direction)} lights, error {percent(self.error)}"
        return f"{lights} after {self.steps} steps: {self.stop_reason.value}"

    def __str__(self) -> str:
        return f"{self.in_short()}\n{self._table()}"

    def _html_parts(self) -> tuple[str, ...]:
        return (self._table().html(),)

    def _table(self) -> Table:
        """Table of the ambient term and of each light."""
        rows = [["ambient", "", "", rgb_cell(self.ambient)]]
        for number, (towards, irradiance) in enumerate(
            zip(self.direction, self.irradiance, strict=True), start=1
        ):
            azimuth, elevation = np.rad2deg([azimuths(towards[None]), elevations(towards[None])])
            place = [f"{number}", f"{azimuth[0]:.1f}°", f"{elevation[0]:+.1f}°"]
            rows.append([*place, rgb_cell(irradiance)])
        return Table(["light", "azimuth", "elevation", rgb_heading(self.units)], rows)

    @property
    def error(self) -> float:
        """Relative RMS error at the 320 fitted normals; it is larger at other normals."""
        return self.errors[-1]

    @property
    def steps(self) -> int:
        """Number of steps."""
        return len(self.errors) - 1

    @property
    def parameters(self) -> _Reals:
        """Vector of unknowns in the order of `kernels.probe_residual`, for other solvers."""
        return pack_lights(self.ambient, self.direction, self.irradiance)

    def rig(self) -> Rig:
        """Convert to a physical rig.

        Returns
        -------
        Rig
            Radiance of a constant environment, ``k_a / (pi k_d)`` times `ambient`, and the lights.

        Raises
        ------
        EnvLightsError
            If ambient light or a light is negative in any channel; no renderer accepts that.
        """
        least = min(self.ambient.min(), self.irradiance.min(initial=0.0))
        if least < 0:
            raise EnvLightsError(
                f"a rig must not hold negative light; the smallest value is {least:.3g}."
                " Use `envlights.fit` for the best lights without negative ones"
            )
        measured_on = f"the {PROBE_FACES} fitted normals"
        report = FitReport(steps=self.steps, stop_reason=self.stop_reason, measured_on=measured_on)
        ambient = self.k_a / (np.pi * self.k_d) * self.ambient
        lights = Lights(self.direction, self.irradiance, units=self.units)
        return Rig(ambient, lights, self.error, report, self.notes)


def fit(
    env: AnyMap,
    lights: int = 4,
    *,
    k_a: float = np.pi,
    k_d: float = 1.0,
    C: Sequence[float] = (1.0, 1.0, 1.0),  # noqa: N803, the paper's name
    start: ArrayLike | None = None,
    damped: bool = True,
    max_steps: int = MAX_STEPS,
    fill: Fill = None,
) -> PaperFit:
    """Fit ambient and directional lights by the method of Madsen, Sørensen and Vittrup (2003).

    For comparison with the paper. Lights may become negative, and the result depends on the start;
    neither holds for the search of `envlights.fit`. A probe of 320 faces is lit by a
    scene of 5120 (equations 1 to 3). From lights on a spiral, all radiances 1.0, Gauss-Newton
    steps over all 3 + 5 `lights` unknowns then minimise equations 7 to 9, in which all faces of the
    probe have the same weight.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map. Its scale matters: radiances start at 1.0 in its units.
    lights : int
        How many directional lights.
    k_a : float
        Coefficient of ambient reflection, 0 or more. pi makes ambient light the radiance of an
        environment; 0 leaves it out.
    k_d : float
        Coefficient of diffuse reflection, above 0; the probe is rendered and explained with it.
    C : sequence of 3 floats
        Colour of the probe, each above 0. It only weights the errors of the three channels.
    start : array_like, shape (lights, 3), optional
        Unit vectors where the lights start. When left out, a spiral of equal areas from +y to -y
        whose first light is on the side of +z. (It is not the even start of `envlights.fit`; see
        the notes.)
    damped : bool
        True: a step is shortened if it would rotate a light by more than 0.25 radians or raise the
        error. False: full Gauss-Newton steps, as in the text of the paper.
    max_steps : int
        Largest number of steps.
    fill : {"black", "harmonic", "ground"}, float or array_like, shape (3,), optional
        Radiance where the map shows nothing; see `EnvMap.filled`.

    Returns
    -------
    PaperFit
        Lights, the error after each step, and the stop reason.

    Raises
    ------
    EnvLightsError
        If `env` is not a map, a number is out of its range, or `start` is not `lights` directions.

    See Also
    --------
    envlights.fit : fit with non-negative radiances and a search for the start.
    kernels.probe_residual : the equations, for another solver.

    Notes
    -----
    The start decides more than the paper says. On ``synthetic.hall(256)``, starting from a
    tetrahedron turned at random, whole steps placed three lights at the windows and the fourth at
    the wall from 5 of 60 turns (from 2 within 20 steps), damped ones from 34 (27). The default
    start is one from which damped steps get there, on the hall times 0.3 to 10000; from the even
    start of `envlights.fit` they do not on the hall times 0.3. But the spiral and the 0.25 radians
    were chosen on that hall: on halls turned about +y they get there for 17 of 25 azimuths, whole
    steps for 5.

    The paper says that ambient radiances for a `k_a` of 0.1 are ten times lower than for 1. By its
    equations 4 to 6, which count ``k_a L_a``, they are ten times higher; so they are here.

    Examples
    --------
    >>> import envlights as el
    >>> hall = el.synthetic.hall(256)
    >>> found = fit(hall.radiance, lights=4)
    >>> at_window = (hall.lights.direction @ found.direction.T).max(axis=1) > np.cos(np.deg2rad(3))
    >>> bool(at_window.all()), found.steps <= 20, found.stop_reason.name
    (True, True, 'CONVERGED')
    """
    lights, max_steps = _sizes(lights, max_steps)
    surface = _surface(k_a, k_d, C)
    first = _spiral(lights) if start is None else _start(start, lights)
    env = as_envmap(env).filled(fill)
    problem = _render(env, surface)
    ambient = np.full(3, 1.0 if surface.k_a > 0 else 0.0)
    x = pack_lights(ambient, first, np.ones((lights, 3)))
    x, errors, stop = _gauss_newton(problem, x, damped, max_steps)
    found, directions, irradiance = (freeze(part) for part in unpack_lights(x))
    history, (k_a, k_d, _) = tuple(errors), surface
    notes = (*env.notes, *clipping(env.clipped_flux_fraction if env.clip_level else 0.0))
    return PaperFit(found, directions, irradiance, history, stop, k_a, k_d, notes, env.units)


class _Surface(NamedTuple):
    """Coefficients and colour of the surface of the probe."""

    k_a: float
    k_d: float
    C: tuple[float, ...]


class _Problem(NamedTuple):
    """Measured probe, and the reflectance of its surface."""

    normals: _Reals
    probe: _Reals
    surface: _Surface

    def residual(self, x: _Reals) -> _Reals:
        return probe_residual(x, self.normals, self.probe, **self.surface._asdict())

    def jacobian(self, x: _Reals) -> _Reals:
        return probe_jacobian(x, self.normals, self.probe, **self.surface._asdict())

    def error(self, x: _Reals) -> float:
        """Relative RMS error, or absolute error for a black probe."""
        reference = float(np.linalg.norm(self.probe))
        return float(np.linalg.norm(self.residual(x))) / (reference or 1.0)


def _render(env: EnvMap, surface: _Surface) -> _Problem:
    """Radiance of the faces of the probe under all faces of the scene (equations 1 to 3)."""
    normals, _ = sampling.icosphere(PROBE_FACES)
    directions, solid_angles = sampling.icosphere(SCENE_FACES)
    scene = face_radiance(env.radiance, SCENE_FACES, border_sampled=env.is_border_sampled)
    values = probe.sum_over_sources(
        normals, directions, scene, solid_angles, k_d=surface.k_d, C=surface.C
    )
    return _Problem(normals, values, surface)


# Undamped steps may diverge until numbers overflow.
@np.errstate(over="ignore", invalid="ignore")
def _gauss_newton(
    problem: _Problem, x: _Reals, damped: bool, max_steps: int
) -> tuple[_Reals, list[float], StopReason]:
    """Take Gauss-Newton steps until convergence, at most `max_steps`."""
    errors = [problem.error(x)]
    for _ in range(max_steps):
        if errors[-1] < _EXACT:
            return x, errors, StopReason.EXACT
        step = _whole_step(problem, x)
        if not np.isfinite(x + step).all():
            return x, errors, StopReason.RAN_AWAY
        fraction = _step_fraction(problem, x, step, errors[-1]) if damped else 1.0
        if fraction == 0.0:
            return x, errors, StopReason.CONVERGED
        ahead = x + fraction * step
        if not np.isfinite(error := problem.error(ahead)):
            return x, errors, StopReason.RAN_AWAY
        x = ahead
        errors.append(error)
        if _is_small(step, x) or (damped and error > errors[-2] * (1 - _SMALL_FALL)):
            return x, errors, StopReason.CONVERGED
    return x, errors, StopReason.OUT_OF_STEPS


def _whole_step(problem: _Problem, x: _Reals) -> _Reals:
    """Shortest change of `x` that minimises the linearised residual.

    A light on a pole, two lights in one direction or a black light make the Jacobian
    rank-deficient; the shortest change leaves unknowns without effect as they are.
    """
    jacobian, target = problem.jacobian(x), -problem.residual(x)
    try:
        step = interruptible(
            lambda: np.linalg.lstsq(jacobian, target, rcond=None)[0], 10 * jacobian.size * len(x)
        )
    except np.linalg.LinAlgError:
        return np.full_like(x, np.nan)
    # Set steps of unknowns without effect to 0 (such as ambient light with a k_a of 0), because
    # rounding would move them.
    return np.where(jacobian.any(axis=0), step, 0.0)


def _turns(step: _Reals, x: _Reals) -> _Reals:
    """First-order rotation of each light by `step`, in radians."""
    by_theta, by_phi = step[3:].reshape(-1, 5)[:, 3:].T
    turns: _Reals = np.hypot(by_theta, by_phi * np.sin(x[3:].reshape(-1, 5)[:, 3]))
    return turns


def _step_fraction(problem: _Problem, x: _Reals, step: _Reals, error: float) -> float:
    """Fraction of `step` that limits rotations and does not raise the error, or 0."""
    farthest = float(_turns(step, x).max(initial=_LARGEST_TURN))
    fraction = _LARGEST_TURN / farthest
    for _ in range(_HALVINGS):
        if problem.error(x + fraction * step) <= error:
            return fraction
        fraction /= 2
    return 0.0


def _is_small(step: _Reals, x: _Reals) -> bool:
    """True if `step` changes directions and radiances only slightly."""
    is_radiance = np.ones(len(x), dtype=bool)
    is_radiance[3:].reshape(-1, 5)[:, 3:] = False
    change, largest = np.abs(step[is_radiance]).max(), np.abs(x[is_radiance]).max()
    turn = _turns(step, x).max(initial=0.0)
    return bool(turn <= _SMALL_STEP and change <= _SMALL_STEP * largest)


def _spiral(lights: int) -> _Reals:
    """Directions in `lights` bands of equal area, with azimuths a golden angle apart."""
    place = np.arange(lights)
    y = 1 - (2 * place + 1) / max(lights, 1)
    phi = np.pi + place * np.pi * (3 - np.sqrt(5))
    radius = np.sqrt(1 - y * y)
    return np.column_stack([np.sin(phi) * radius, y, -np.cos(phi) * radius])


def _sizes(lights: object, max_steps: object) -> tuple[int, int]:
    most = (3 * PROBE_FACES - 3) // 5
    wanted = count("lights", lights)
    if wanted > most:
        raise EnvLightsError(
            f"lights must be at most {most}, because {PROBE_FACES} faces give no more equations;"
            f" got {wanted}"
        )
    return wanted, count("max_steps", max_steps)


def _surface(k_a: object, k_d: object, C: ArrayLike) -> _Surface:  # noqa: N803, the paper's name
    numbers = [amount("k_d", k_d, most=_STRONGEST), *colour("C", C)]
    if min(numbers) == 0:
        raise EnvLightsError("k_d and C must be above 0; a black probe reflects no light")
    if max(numbers) > _STRONGEST:
        raise EnvLightsError(f"C must be at most {_STRONGEST:g}; got {max(numbers):g}")
    return _Surface(amount("k_a", k_a, most=_STRONGEST), numbers[0], tuple(numbers[1:]))


def _start(start: ArrayLike, lights: int) -> _Reals:
    directions = reals("start", start, 2)
    if directions.shape != (lights, 3):
        raise EnvLightsError(
            f"start must have the shape (lights, 3) = ({lights}, 3); got {directions.shape}"
        )
    return directions
