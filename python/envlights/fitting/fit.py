"""Fit of a rig to a map, or to measured irradiance."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from envlights import _native
from envlights._common.check import check_choice, named_arguments, reals
from envlights._common.notes import black_note
from envlights._common.times import Clock
from envlights._native import EnvLightsError
from envlights.environment.fill import Fill
from envlights.environment.reading import AnyMap
from envlights.fitting import wording
from envlights.fitting.map_fit import fit_map
from envlights.fitting.request import (
    AMBIENTS,
    STARTS_WITHOUT_MAP,
    FitArguments,
    FitOptions,
    request_of,
)
from envlights.fitting.result import rig_of
from envlights.fitting.sun_light import fit_with_sun
from envlights.rigs.lights import Lights
from envlights.rigs.rig import Rig
from envlights.sun.choice import AnySun
from envlights.sun.sun_split import with_sun


@named_arguments()
def fit(
    env: AnyMap,
    lights: int | None = None,
    *,
    error: float | None = None,
    shadow_error: float | None = None,
    gloss_error: float | None = None,
    roughness: float = 0.33,
    sizes: bool = True,
    max_radius: float | None = None,
    objective: str = "mixed",
    ambient: str | None = None,
    start: str | Rig | Lights = "greedy",
    fixed: ArrayLike | Lights | None = None,
    sun: AnySun | None = None,
    floor: bool = False,
    fill: Fill = None,
    target: str | Iterable[str] | None = None,
) -> Rig:
    """Fit an ambient term and a few lights that light a scene as `env` does.

    The fit minimises the squared difference between the irradiance under the map and under the
    lights, integrated over all normals in closed form. The search uses variable projection with
    non-negative radiances: forward selection adds lights one at a time where they lower the error
    most, more starts come from evenly spread directions, and the best sets exchange lights. Each
    descent takes Gauss-Newton steps, then Newton steps. Lights are added until the error is below
    1e-4, the accuracy of the reduced map. The final error is a closed form as well.

    A last descent turns every light into a disc of uniform radiance, with a direction, a radius and
    a radiance. It minimises the error with shadows: the error of the irradiance at every normal
    with everything behind a plane hidden, integrated over all planes.

    Use ``floor=True`` for objects on a floor, which hides light from below the horizon. Leave it
    out for objects in the air.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map; `EnvMap` describes arrays.
    lights : int, optional
        Largest number of lights, 0 or more. There are fewer if more would not lower the error.
        Default: 4, or the number in `fixed` or `start`, or 32 if an error is set.
    error : float, optional
        Largest accepted relative RMS error. The result has the fewest lights that reach it, which
        may be none. `error_curve` has the errors of several numbers of lights.
    shadow_error : float, optional
        Largest accepted error with shadows.
    gloss_error : float, optional
        Largest accepted error of images of shiny metal; see `FitReport.gloss_error`. All errors
        that are set must be reached.
    roughness : float
        Roughness of that metal, from 0.3 to 1.
    sizes : bool
        True: lights are discs with an angular radius of at most `max_radius` or 75 degrees, and
        over a `floor` of at most their elevation; a radius of 0 is a point. False: all lights are
        points.
    max_radius : float, optional
        Largest angular radius of a light, in radians, above 0 and at most pi / 2. The fit minimises
        its error within that bound, so light that is spread wider goes into the ambient term or
        several lights. `report.at_max_radius` names the lights at the bound.
    objective : {"mixed", "shadows", "probe"}
        Error that the discs minimise: with shadows, without ("probe"), or a mean of both, which is
        nearly as good as either.
    ambient : {"constant", "none", "sh2", "auto"}, optional
        "constant", the default without a `target`: one radiance from everywhere. "none": lights
        only. "sh2": nine spherical harmonics, as real-time engines use them, with irradiance that
        is nowhere negative. "auto":
        the one of these three that reaches `error` with the fewest lights, or has the least error
        without a requested one; if several are equal, the simplest. `report.ambients` holds the
        results of each. "auto" is the default for a `target` that shows harmonics as they are.
    start : {"greedy", "detect", "even"}, Rig or Lights
        "greedy": the full search. All others descend from start directions and add lights where
        the residual is largest. "detect": the lights of `detect`, so that each light stays with its
        lamp. "even": points spread over the sphere (Madsen et al. 2003, section 3.2), which often
        end in a local minimum. A rig or lights: their directions, as for the next frame of a video.
        Set `lights` and `ambient` for every frame. Match lights of two frames by direction, because
        their order is that of brightness.
    fixed : array_like, shape (k, 3), or Lights, optional
        Unit vectors towards lights that do not move; only radiance and size are fitted. They count
        among `lights`, and are returned even if black. `report.fixed` holds their rows.
    sun : "auto", array_like of shape (3,), SunAt or Sun, optional
        Sun of a clipped map, as one of the `lights`, which is not fitted: direction, size (0.265
        degrees in radius) and irradiance are those of `with_sun`. The other lights and the ambient
        term are fitted to the map with sky in place of the clipped part around the sun. Errors are
        against that sky and the sun, so they say nothing on a sun that is a wrong guess. If the
        answer is "perhaps" or "no", the map is fitted as it is, with a note.
    floor : bool
        True: a floor hides everything below the horizon. Lights are above the horizon, the
        `ambient` radiance gives a normal n an irradiance of ``pi / 2 (1 + n_y)`` times itself, and
        both the error and `Rig.probe` include the floor. A renderer hides the lower half by itself
        if the floor is in its scene.

    fill : {"black", "harmonic", "ground"}, float or array_like, shape (3,), optional
        Radiance where the map shows nothing; see `EnvMap.filled`. Needed if less than 85 % of the
        sphere is seen, or over a `floor` of its upper half. `report.unseen_spread` holds how much
        the choice may change the probe.
    target : str or iterable of str, optional
        Names of targets from `el.export.TARGETS`, such as "three". The rig is what they can show:
        points where they ignore sizes, and at most as many lights as they have. So the error of the
        rig is that of its file.

    Returns
    -------
    Rig
        Ambient radiance and lights, none negative, with the error and a report.

    Raises
    ------
    EnvLightsError
        If `env` is not a map, `lights` is not a count or less than `fixed`, an error is not from 0
        to 1, `roughness` is not from 0.3 to 1, `max_radius` is out of range or set without `sizes`,
        a `fixed` direction is not a unit vector, or `objective`, `ambient`, `start` or `sun` is
        unknown; with a `floor`, for "sh2" and for `fixed` or `start` lights below the horizon.

    See Also
    --------
    fit_probe : fit to irradiance that was measured or rendered elsewhere.

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
    arguments = FitArguments(
        lights,
        error,
        shadow_error,
        gloss_error,
        roughness,
        sizes,
        max_radius,
        objective,
        ambient,
        start,
        fixed,
        floor,
        fill,
        target,
    )
    if sun is None:
        return fit_map(env, arguments)
    return fit_with_sun(with_sun(env, sun), arguments)


@named_arguments()
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
    """Fit an ambient term and a few lights to irradiance measured or rendered elsewhere.

    The fit is that of `fit`, with the squared error summed over `normals`. Lights are points. The
    horizon of each normal puts a kink into that sum, so the search ends with descents from
    perturbed lights. The error is measured at `normals` too, so it is too low if they are few.
    `report` holds standard errors and a condition number, for noise that channels may share.

    Parameters
    ----------
    normals : array_like, shape (n, 3)
        Unit normals, in the frame of `EnvMap`.
    irradiance : array_like, shape (n, 3)
        RGB irradiance at each normal: pi times the radiance of a white Lambertian probe.
    lights : int, optional
        Largest number of lights, 0 or more. Default: 4, or the number in `fixed` or `start`.
    weights : array_like, shape (n,), optional
        Weight of each normal, such as its solid angle. Default: equal weights.
    ambient : {"constant", "none", "sh2"}
        Ambient term; see `fit`.
    start : {"greedy", "even"}, Rig or Lights
        Start directions; see `fit`.
    fixed : array_like, shape (k, 3), or Lights, optional
        Unit vectors towards lights that do not move; see `fit`.

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
    fit : fit to a map, at every normal.

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
    request = request_of(lights, None, start, fixed, STARTS_WITHOUT_MAP)
    normals, irradiance = reals("normals", normals, 2), reals("irradiance", irradiance, 2)
    weights = np.ones(len(normals)) if weights is None else reals("weights", weights, 1)
    if len(weights) and not weights.any():
        raise EnvLightsError("weights must not all be 0")
    # Scale irradiance to about 1, because the kernel sums fourth powers, which could overflow.
    brightest = float(np.abs(irradiance).max(initial=0.0))
    scale = brightest if 0 < brightest < np.inf else 1.0
    clock = Clock()
    first = request.first_directions(len(normals))
    directions = np.concatenate([request.fixed, first])
    options = FitOptions(AMBIENTS[ambient], directions, len(request.fixed), request.lights)
    answer = _native.fit_samples(normals, weights, irradiance / scale, options)
    clock.lap("fit")
    rig = rig_of(
        answer,
        request,
        scale=scale,
        notes=black_note(irradiance, "measured irradiance"),
        # The report holds this dictionary by reference; its last entry is added below.
        seconds=clock.laps,
        measured_on=f"the {len(normals)} fitted normals",
        ambient=ambient,
        fewer_lights=wording.fewer_lights(answer, request, 0.0),
        skipped=wording.channels(answer),
    )
    clock.lap("report")
    return rig
