"""Writer for a rig in the format of a suffix, with a warning about losses."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.words import percent
from envlights._native import EnvLightsError
from envlights.environment.reading import AnyMap, as_envmap
from envlights.export.capabilities import Capabilities
from envlights.export.files import AnyPath
from envlights.export.targets import TARGETS, Target, target_of
from envlights.kernels.probe import relative_rms
from envlights.kernels.sampling import icosphere

#: Error in a file below which `save` does not warn, and largest ratio to the error of the rig
#: without a warning: stated errors are compared with files to a tenth.
_SMALL_ERROR, _SAME_ERROR = 1e-3, 1.1


def save(rig: Any, path: AnyPath, environment: AnyMap | None = None, **options: Any) -> None:
    """Write a rig, or lights alone, in the format that the suffix of `path` names.

    Parameters
    ----------
    rig : Rig or Lights
    path : path-like
        Textures are written beside it, ``scene.ambient.exr`` beside ``scene.usda``.
    environment : EnvMap or array_like, optional
        Map that replaces the ambient term, such as the remainder of a split map.
    **options
        Further arguments of the target's writer: ``up="z"`` of `save_usd`, ``scale=`` of
        `save_mujoco`.

    Raises
    ------
    EnvLightsError
        If the suffix is unknown, the target accepts no map or no such option, or the file cannot
        be written.

    Warns
    -----
    UserWarning
        If the target shows the rig with a larger error, such as lights with a size as points.
    """
    save_for(target_for(path, environment, options), rig, path, environment, **options)


def target_for(path: AnyPath, environment: AnyMap | None, options: Iterable[str]) -> Target:
    """Target of a file; raises an error if it accepts no map, or no such option."""
    target = target_of(path)
    if environment is not None and not target.shows.environment:
        raise EnvLightsError(f"cannot write {path}: {target.title} accepts no environment map")
    check_options((target,), options)
    return target


def check_options(targets: Iterable[Target], options: Iterable[str]) -> None:
    """Raise an error for an option that no writer of the targets accepts."""
    each = list(targets)
    for name in options:
        if not any(name in target.options for target in each):
            titles = " and ".join(sorted({target.title for target in each})) or "this file"
            owners = ", ".join(known.title for known in TARGETS if name in known.options)
            hint = f"it is an option of {owners}" if owners else "no program has this option"
            raise EnvLightsError(f"{name}= changes nothing for {titles}; {hint}")


def save_for(
    target: Target, rig: Any, path: AnyPath, environment: AnyMap | None = None, **options: Any
) -> None:
    """Write a file for a target; warns if the target shows the rig with a larger error."""
    shown = getattr(rig, "distant", rig) if target.shows.cards else rig
    if shown is not rig:
        _warn_of_uniform_cards(rig, target, environment)
    if environment is None:
        _warn_of_losses(shown, target)
        target.save(rig, path, **options)
    else:
        # The map replaces the ambient term.
        _warn_of_losses(getattr(shown, "lights", shown), target, environment)
        target.save(rig, path, environment, **options)


def _warn_of_losses(rig: Any, target: Target, environment: AnyMap | None = None) -> None:
    """Warn if the error in the file exceeds that of the rig, stating both."""
    if not hasattr(getattr(rig, "lights", rig), "discs"):
        return  # the writer raises an error
    losses, stated = target.shows.losses(rig), getattr(rig, "error", None) or 0.0
    if not losses:
        return
    error = target.shows.error(rig) if environment is None else _change(rig, target, environment)
    if error > max(_SAME_ERROR * stated, _SMALL_ERROR):
        lost = f"{target.title} shows {' and '.join(losses)}"
        warnings.warn(f"{lost}: {_figures(rig, target, error)}", stacklevel=5)


def _around(environment: AnyMap | None) -> tuple[NDArray[np.float64], ...]:
    """Normals, their solid angles, and the irradiance of a map at each."""
    normals, weights = icosphere(320)
    none = np.zeros((len(normals), 3))
    return normals, weights, none if environment is None else as_envmap(environment).probe(normals)


def _change(lights: Any, target: Target, environment: AnyMap) -> float:
    """Relative RMS difference that a target makes to the irradiance of lights before a map."""
    normals, weights, around = _around(environment)
    shown, whole = (each.irradiance(lights, normals) for each in (target.shows, Capabilities()))
    return relative_rms(around + shown, around + whole, weights)


def _warn_of_uniform_cards(cards: Any, target: Target, environment: AnyMap | None) -> None:
    """Warn if the irradiance of a scene changes because cards lose their textures."""
    if not set(target.shows.uniform_cards) & set(cards.shape):
        return
    normals, weights, around = _around(environment)
    lit = around + cards.probe(normals)
    shown = around + cards.probe(normals, uniform=target.shows.uniform_cards)
    change = relative_rms(shown, lit, weights) if lit.any() else 0.0
    if change > _SMALL_ERROR:
        lost = (
            f"{target.title} shows {' and '.join(target.shows.uniform_cards)} cards in one colour"
        )
        warnings.warn(f"{lost}: the irradiance changes by {percent(change)}", stacklevel=5)


def _figures(rig: Any, target: Target, error: float) -> str:
    """Text with the error in the file, that of the rig, and that of a fit for the target."""
    if getattr(rig, "error", None) is None:
        return f"the irradiance changes by {percent(error)}"
    fitted = rig.report.fitted_points_error
    both = f"the error in the file is {percent(error)}, not {percent(rig.error)}"
    refit = "" if fitted is None else f" has at most {percent(fitted)} with as many lights"
    return f"{both}; `fit(env, target={target.name!r})`{refit or ' is made for it'}"
