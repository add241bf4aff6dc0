"""Separation of a map into the sun as a light, and the sky without it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from envlights._common.check import amount, named_arguments
from envlights._common.former import former_attributes
from envlights._native import EnvLightsError
from envlights.environment.envmap import EnvMap
from envlights.environment.fill import Fill
from envlights.environment.reading import AnyMap, as_envmap
from envlights.environment.repair import check_not_black
from envlights.export.links import LinkedParts
from envlights.kernels.image import LUMINANCE
from envlights.kernels.sphere import direction_to_uv
from envlights.rigs.lights import Lights
from envlights.splitting.split import split
from envlights.sun.choice import AUTO, AnySun, is_of_map, sun_of
from envlights.sun.disc_pixels import add_disc
from envlights.sun.result import Sun

#: Cosine of the largest angle, 3 degrees, between the sun of a map and its brightest light.
_SAME = math.cos(math.radians(3))


class _SunSplitFields(NamedTuple):
    """Fields of a `SunSplit`."""

    lights: Lights
    """Sun as a disc; empty if there is none. `notes` state the sources of its values."""

    remainder: EnvMap
    """Map with sky in place of the clipped region around the sun."""


@former_attributes(rest="remainder")
class SunSplit(_SunSplitFields, LinkedParts):
    """Sun as a light, and the map without it."""

    __slots__ = ()

    def __str__(self) -> str:
        return f"{self.lights}\n\nthe map around it: {self.remainder}"

    def to_map(self) -> EnvMap:
        """Sky and sun in one map: the disc fills the pixels that it covers.

        Returns
        -------
        EnvMap
            The remainder if there is no sun.

        Raises
        ------
        EnvLightsError
            If the sun is in a part that the map does not show, which stays black.

        Examples
        --------
        >>> import envlights as el
        >>> env = el.EnvMap(np.full((64, 128, 3), 0.5))
        >>> sun = el.sun.Sun("sun", direction=[0.6, 0.8, 0], irradiance=[4, 3.8, 3.4])
        >>> sunny = el.with_sun(env, sun).to_map()
        >>> (sunny.probe([0.6, 0.8, 0]) - env.probe([0.6, 0.8, 0])).round(3)
        array([4. , 3.8, 3.4])
        """
        if not len(self.lights):
            return self.remainder
        _check_seen(self.remainder, self.lights)
        (note,) = self.lights.notes
        notes = (*self.remainder.notes[:-1], f"added as a disc: {note}")
        return self.remainder.with_radiance(add_disc(self.remainder, self.lights), notes)


def _check_seen(env: EnvMap, lights: Lights) -> None:
    """Raise an error if the sun lies in the uncovered part, which stays black."""
    if env.coverage is None:
        return
    ((u, v),) = direction_to_uv(lights.direction)
    row = min(int(v * env.height), env.height - 1)
    if not np.asarray(env.coverage)[row, int(u * env.width) % env.width]:
        raise EnvLightsError(
            "sun must be in the part that the map shows, because the other part stays black;"
            " `with_sun` makes it a light"
        )


@named_arguments()
def with_sun(
    env: AnyMap,
    sun: AnySun = AUTO,
    *,
    irradiance: float | None = None,
    ratio: float | None = None,
    fill: Fill = None,
) -> SunSplit:
    r"""Sun of a clipped map as a light with a radius of 0.265 degrees, and the sky without it.

    An 8-bit picture shows a sun as a white glow that is degrees wide and much too dark. Here the
    sun is a light with the size of the sun, for sharp shadows, and the glow becomes sky. Nothing
    is drawn into the map; `SunSplit.to_map` does that. If the map is not clipped and holds its
    sun, `split` removes it.

    Parameters
    ----------
    env : EnvMap, path or array_like, shape (height, 2 * height, 3)
        The map.
    sun : "auto", array_like of shape (3,), SunAt or Sun
        "auto": the sun of `find_sun`. A direction, of any length. A `SunAt` with `north` gives the
        direction; one without it the elevation, and the picture the azimuth. A `Sun`, such as one
        of `find_sun` that was changed by `dataclasses.replace`.
    irradiance : float, optional
        Measured luminance of the irradiance on an upward surface, sun and sky together, on the
        scale of the map: lux, if its `units` are "cd/m2". It replaces the estimate.
    ratio : float, optional
        The same irradiance divided by that of the sky alone: two readings of a lux meter on the
        ground, in the open and with the sun shaded. It replaces the estimate, too.
    fill : {"black", "harmonic", "ground"}, float or array_like, shape (3,), optional
        Radiance where the map shows nothing, for these readings; see `EnvMap.filled`.

    Returns
    -------
    lights : Lights
        The sun; no light if the answer is "perhaps" or "no". Notes say what is a guess.
    remainder : EnvMap
        The map with sky in place of the clipped part around the sun, without a `clip_level`. It is
        the map itself, with a note, if there is no sun.

    Raises
    ------
    EnvLightsError
        If `env` is not a map, `sun` is none of these or below the horizon, both readings are given,
        or one is less than that of the sky alone.

    See Also
    --------
    find_sun : the answer, the direction and the estimate of the irradiance.
    split : lights that the map shows with their true radiance.

    Notes
    -----
    With the irradiance S of the sky on an upward surface and the elevation h of the sun, a reading
    E gives the sun an irradiance of :math:`(E - S) / \sin h` at normal incidence, and a ratio q
    gives :math:`(q - 1) S / \sin h`, in the colour of the estimate.

    Examples
    --------
    >>> import envlights as el
    >>> env = el.EnvMap(np.full((64, 128, 3), 0.5))
    >>> sun = el.sun.Sun("sun", direction=[0.6, 0.8, 0], irradiance=[4, 3.8, 3.4])
    >>> lights, rest = el.with_sun(env, sun)
    >>> round(float(np.degrees(lights.angular_radius[0])), 3)
    0.265
    >>> el.with_sun(env, sun, ratio=5).lights.irradiance.round(1)
    array([[8.2, 7.8, 7. ]])
    """
    env = as_envmap(env)
    return parts_of(env, sun_of(env, sun), irradiance, ratio, fill)


def parts_of(
    env: EnvMap, sun: Sun, irradiance: float | None, ratio: float | None, fill: Fill
) -> SunSplit:
    """Light and remaining map for a sun; see `with_sun`."""
    if irradiance is not None and ratio is not None:
        raise EnvLightsError("give irradiance or ratio, not both")
    for name, reading in (("irradiance", irradiance), ("ratio", ratio)):
        if reading is not None:
            amount(name, reading)
    parts = _split_from_map(env, sun) if is_of_map(sun) else None
    if parts is not None:
        sun, remainder = parts
    elif is_of_map(sun) or not len(sun.lights):
        note = _without_sun(sun)
        notes = (*env.notes, note)
        none = replace(sun.lights[:0], notes=(note,))
        return SunSplit(none, env.with_radiance(env.radiance, notes))
    else:
        remainder = env.with_radiance(sun.sky(env.radiance), env.notes, keeps_clip_level=False)
    lights, measured = sun.lights, ""
    if irradiance is not None or ratio is not None:
        lights, measured = _of_reading(sun, remainder, irradiance, ratio, fill)
    note = sun.light_note(measured)
    notes = (*remainder.notes, f"as a light of its own: {note}")
    return SunSplit(
        replace(lights, notes=(note,)), remainder.with_radiance(remainder.radiance, notes)
    )


def _split_from_map(env: EnvMap, sun: Sun) -> tuple[Sun, EnvMap] | None:
    """Sun of a map that shows its true radiance, and the map without it.

    None if the sun is not its brightest light, which `split` removes.
    """
    removed, remainder = split(env, 1)
    if sun.direction is None or not len(removed) or removed.direction[0] @ sun.direction < _SAME:
        return None
    return replace(sun, irradiance=removed.irradiance[0]), remainder


def _of_reading(
    sun: Sun, remainder: EnvMap, irradiance: float | None, ratio: float | None, fill: Fill
) -> tuple[Lights, str]:
    """Sun with the irradiance of a meter reading, and a text on the reading."""
    sky = float(remainder.probe(np.array([0.0, 1.0, 0.0]), fill=fill) @ LUMINANCE)
    name, reading, least = "irradiance", irradiance or 0.0, sky
    if ratio is not None:
        check_not_black("the sun", sky)
        name, reading, least = "ratio", ratio, 1.0
    if reading < least:
        raise EnvLightsError(
            f"{name} must be at least that of the sky without the sun, {least:.4g}; got {reading:g}"
        )
    (towards,), (guess,) = sun.lights.direction, sun.lights.irradiance
    missing = (reading - least) * (1.0 if ratio is None else sky)
    luminance = float(guess @ LUMINANCE)
    colour = guess / luminance if luminance > 0 else np.ones(3)
    lights = replace(sun.lights, irradiance=missing / float(towards[1]) * colour[None])
    return lights, f"its irradiance is that of the {name} of {reading:.4g}"


def _without_sun(sun: Sun) -> str:
    """Note on why no sun was added to the map."""
    if sun.answer == "sun":
        return "no sun was added, because it is not the brightest light of the map; use `split`"
    why = f": {sun.notes[0]}" if sun.notes else ""
    hint = "; give its direction to add it" if sun.answer == "perhaps" else ""
    return f"no sun was added, because the answer is {sun.answer!r} ({sun.in_short()}){why}{hint}"
