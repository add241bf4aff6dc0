"""Registry of the targets that lights and rigs can be written for; `envlights.export` fills it."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterable
from importlib import import_module
from typing import Any, NamedTuple

from numpy.typing import ArrayLike

from envlights._common.check import check_choice, describe
from envlights._common.files import PICTURES, as_path
from envlights._native import EnvLightsError
from envlights.environment.envmap import EnvMap
from envlights.rigs.capabilities import Capabilities, common

#: End of the name of a map that a program reads as a panorama in our axes.
PANORAMA = ".ambient.exr"


class Crops(NamedTuple):
    """Textures of the cards of a target: files beside the scene."""

    end: str
    """End of their names. Each target has its own, because not all show the map through a card."""

    has_discs: bool = False
    """True if discs have textures too; False if they have one colour."""

    def names(self, prefix: str, shapes: Iterable[str]) -> list[str]:
        """Names for cards of these shapes: ``scene.card_0.usd.exr`` beside ``scene.usda``.

        A card without a texture has an empty name.
        """
        return [
            f"{prefix}card_{j}{self.end}" if self.has_discs or shape != "disc" else ""
            for j, shape in enumerate(shapes)
        ]


class Target(NamedTuple):
    """Program or format that rigs can be exported to."""

    name: str
    """Name of its module and of its public function."""

    title: str
    """Full name."""

    suffixes: tuple[str, ...]
    """Suffixes in lower case, the usual one first."""

    save: Callable[..., None]
    """Writer: takes a rig or lights, a path, and an `environment` map if it shows one."""

    shows: Capabilities
    """Parts of a rig that it can show."""

    texture: str = ""
    """End of the name of the map beside a file; empty if there is no such map.

    For `PANORAMA` the writer accepts the keyword `texture`, the name of an existing map."""

    crop: Crops | None = None
    """Textures of cards beside a file; None if there are none."""


#: Error in a file up to which `save` does not warn, and largest ratio to the error of the rig: a
#: tenth is the accuracy at which stated errors are compared with files.
_SMALL_ERROR, _SAME_ERROR = 1e-3, 1.1

_TARGETS: list[Target] = []

#: Suffixes that no target has, and advice for each.
_INSTEAD = {
    ".blend": "give .py, a script that Blender runs",
    ".glb": "give .gltf",
    ".usdz": "give .usda",
    **dict.fromkeys(PICTURES, "`plot.save` writes pictures"),
    **dict.fromkeys((".exr", ".hdr"), "`to_map` makes a map, whose `save` writes it"),
}


def register(added: Iterable[Target]) -> None:
    """Add targets to those that `save` knows."""
    _TARGETS.extend(added)


def targets() -> tuple[Target, ...]:
    """All registered targets."""
    import_module("envlights.export")
    return tuple(_TARGETS)


def target_of(path: str | os.PathLike[str]) -> Target:
    """Target of a file name; the longest matching suffix decides."""
    name = as_path(path).name.lower()[1:]
    fits = [
        (len(suffix), target)
        for target in targets()
        for suffix in target.suffixes
        if name.endswith(suffix)
    ]
    if not fits:
        wanted = ", ".join(suffix for target in targets() for suffix in target.suffixes)
        hint = _INSTEAD.get(as_path(path).suffix.lower())
        raise EnvLightsError(
            f"cannot write {path}: {f'{hint}; ' if hint else ''}the suffix must be one of {wanted}"
        )
    return max(fits, key=lambda fit: fit[0])[1]


def target_named(name: str) -> Target:
    """Target of a name, such as "three"."""
    named = {target.name: target for target in targets()}
    check_choice("target", name, tuple(named))
    return named[name]


def target_names(target: str | Iterable[str] | None) -> tuple[str, ...]:
    """Checked names of one target or of several."""
    names = (target,) if isinstance(target, str) else () if target is None else target
    if not isinstance(names, Iterable):
        raise EnvLightsError(f"target must be a name, such as 'three'; got {describe(target)}")
    return tuple(target_named(name).name for name in names)


def shown_by(names: Iterable[str]) -> Capabilities:
    """Parts of a rig that all of the named targets can show."""
    return common(target_named(name).shows for name in names)


def error_in(rig: Any, target: str) -> float:
    """Relative RMS error of a rig as a target shows it; of lights alone, the change by it."""
    return target_named(target).shows.error(rig)


def save(
    rig: Any,
    path: str | os.PathLike[str],
    environment: EnvMap | ArrayLike | None = None,
) -> None:
    """Write a rig, or lights alone, in the format that the suffix of `path` names.

    Parameters
    ----------
    rig : Rig or Lights
    path : path-like
        Textures are written beside it, ``scene.ambient.exr`` beside ``scene.usda``.
    environment : EnvMap or array_like, optional
        Map that replaces the ambient term, such as the remainder of a split map.

    Raises
    ------
    EnvLightsError
        If the suffix is unknown, the target accepts no map but `environment` is one, or the file
        cannot be written.

    Warns
    -----
    UserWarning
        If the target shows the rig with a larger error, such as lights with a size as points.
    """
    target = target_of(path)
    if environment is not None and not target.shows.environment:
        raise EnvLightsError(f"cannot write {path}: {target.title} accepts no environment map")
    save_for(target, rig, path, environment)


def save_for(
    target: Target,
    rig: Any,
    path: str | os.PathLike[str],
    environment: EnvMap | ArrayLike | None = None,
    **options: Any,
) -> None:
    """Write a file for a target, with a warning if it shows the rig with a larger error."""
    shown = getattr(rig, "distant", rig) if target.shows.cards else rig
    if environment is None:
        _warn_of_losses(shown, target)
        target.save(rig, path, **options)
    else:
        # The map replaces the ambient term, so only the lights can change.
        _warn_of_losses(getattr(shown, "lights", shown), target)
        target.save(rig, path, environment, **options)


def _warn_of_losses(rig: Any, target: Target) -> None:
    """Warn if the error in the file is larger than that of the rig, with both figures."""
    if not hasattr(getattr(rig, "lights", rig), "discs"):
        return  # The writer refuses it.
    losses, stated = target.shows.losses(rig), getattr(rig, "error", 0.0)
    if not losses:
        return
    error = target.shows.error(rig)
    if error > max(_SAME_ERROR * stated, _SMALL_ERROR):
        lost = f"{target.title} shows {' and '.join(losses)}"
        warnings.warn(f"{lost}: {_figures(rig, target, error)}", stacklevel=5)


def _figures(rig: Any, target: Target, error: float) -> str:
    """Error in the file, that of the rig, and that of a fit for the target."""
    if not hasattr(rig, "error"):
        return f"the irradiance changes by {_percent(error)}"
    fitted = rig.report.fitted_points_error
    both = f"the error in the file is {_percent(error)}, not {_percent(rig.error)}"
    refit = "" if fitted is None else f" has at most {_percent(fitted)} with as many lights"
    return f"{both}; `fit(env, target={target.name!r})`{refit or ' is made for it'}"


def _percent(fraction: float) -> str:
    return f"{100 * fraction:.3g} %"
