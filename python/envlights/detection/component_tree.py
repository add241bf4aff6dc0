"""Detection by the component tree."""

from __future__ import annotations

import inspect
import math
import time
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._check import LARGEST_COUNT, amount, count
from envlights._map_pixels import checked_white
from envlights.detection.casts import cast_notes
from envlights.detection.lights import DetectedLights, DetectionReport
from envlights.detection.members import Members
from envlights.envmap import AnyMap, EnvMap, apply_to_map
from envlights.light import place_of

#: The narrowest working image.
_LEAST_COLUMNS = 16

#: Behind white, the working image has fewer columns by this factor.
_FEWER_COLUMNS = 2


def detect_tree(
    env: AnyMap,
    *,
    max_lights: int | None = None,
    min_flux_share: float = 0.0,
    min_worth: float = 0.0005,
    rise: float = 2.5,
    prominence: float = 4.0,
    gap_deg: float = 0.8,
    extent: float = 0.1,
    working_width: int = 1024,
    white: float | None = None,
) -> DetectedLights:
    r"""Bright places of a map: the branches of its component tree.

    The threshold comes from the map's own histogram. From the brightest pixel down, pixels join the
    components beside them, across the seam and the poles. Where two components meet, the dimmer one
    stays a light of its own if its peak is `prominence` times the level at which they meet. Each
    light is then measured in the map's own pixels. The method goes back to Loghin (2021), whose
    straight line between two samples approximates the path that the tree follows.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map.
    max_lights : int, optional
        Lights, at most. Neighbours are merged until there are that many, the pair with the least
        cost first (Ward 1963); no flux is dropped. `detect_article` leaves lights out instead.
    min_flux_share : float
        Lights with a smaller share of the map's flux are left out.
    min_worth : float
        Least worth of a light that is listed: its share of the map's flux times its contrast, the
        peak over the local background. 0 lists all. Maps that end at a white have a rule of their
        own; see Notes.
    rise : float
        Ratio of a light's peak to the threshold, at least; 1 takes whatever is above it. A light
        extends down to the threshold.
    prominence : float
        Ratio of a light's peak to its saddle, at least; 1 keeps every local maximum apart.
    gap_deg : float
        Dark gaps of up to this many degrees do not divide a light. Wider bars do not divide an
        opening, see Notes; 0 keeps all panes apart.
    extent : float
        A light ends where its luminance has fallen to this share of its peak.
    working_width : int
        Lights are searched for in a reduction of the map to at most this many columns; to half of
        them where it has a white, for a plateau has no fine detail, and to fewer still where more
        than 12 % of the sphere is bright.
    white : float, optional
        The value at which the map was cut off, in place of `EnvMap.white`. What is left of a map
        that was cut off ends where that did.

    Returns
    -------
    DetectedLights
        Brightest first; `report` holds the threshold with its reason, and what was skipped.

    Raises
    ------
    EnvLightsError
        If `env` is not a map or an option is out of its range.

    Notes
    -----
    Two lights are panes of one opening if they touch nowhere, the bar between them is at most half
    as wide as they are deep and at most 2.5 degrees, lies along a quarter of their sides and is
    darker, at most 0.8 of them, and their mean luminances are within a factor of 4. The joined
    light holds the flux of its panes. The rule is ours.

    One threshold for the whole map misses a window that is three times as bright as the wall around
    it where the sky is brighter. Large places of low contrast are found by their rims: their mean
    luminance is at least 2.3 times that of what is just outside, they give at least 1 % of the
    flux, cover at most 0.5 steradians, and along nine tenths of the outline the luminance falls
    by the root of that contrast within five pixels, unlike that of a gradient or a cloud. They hold
    no light above the threshold; `report.notes` names them. The rule is ours.

    Maps that end at a white, as those of integers do, are treated differently, for their threshold
    would often lie above white. Luminance :math:`y`, in units of white, is expanded to
    :math:`y / (1.02 - y)` first: white becomes 50. Pixels of 0.985 and more form a plateau, and a
    pixel's depth is its angle to the rim. A light is divided where its plateau has a neck of less
    than half its depth, and points to the centroid of its plateau, weighted by the square of the
    depth. Lights are ordered by `DetectedLights.weight`, expanded flux over the 3/4 power of the
    solid angle times :math:`e^{1.5 \sin}` of the elevation, because white has made their flux
    alike. Those with less than 1 % of all weight and white floors are left out. Their
    `direction_uncertainty` is calibrated on pictures of HDR maps. Irradiance is what is in the map:
    a lower bound. The rule is ours; the expansion is that of Schlick (1994), backwards.

    A picture that ends in a small peak between 0.7 of white and white was tone-mapped to end there,
    and that peak takes the place of white. One that ends lower, or in an even top, has lost nothing
    to white and is treated as any other map.

    Examples
    --------
    Two lamps, the second across the seam:

    >>> import envlights as el
    >>> lamps = [el.synthetic.Disc((1, 1, 0), 4.0, (9, 9, 9)),
    ...          el.synthetic.Disc((0, 0, -1), 2.0, (9, 6, 3))]
    >>> lights = detect_tree(el.synthetic.scene(256, background=[0.1] * 3, shapes=lamps).radiance)
    >>> lights.direction.round(2) + 0.0
    array([[ 0.71,  0.71,  0.  ],
           [ 0.  ,  0.  , -1.  ]])
    """
    lights, _ = _searched(
        env,
        max_lights=max_lights,
        min_flux_share=min_flux_share,
        min_worth=min_worth,
        rise=rise,
        prominence=prominence,
        gap_deg=gap_deg,
        extent=extent,
        working_width=working_width,
        white=white,
    )
    return lights


def searched(env: AnyMap, **options: Any) -> tuple[DetectedLights, NDArray[np.float32]]:
    """Lights as `detect_tree` finds them, and the luminance of the image that was searched."""
    given = inspect.signature(detect_tree).bind(env, **options)
    given.apply_defaults()
    return _searched(**given.arguments)


def _searched(
    env: AnyMap,
    *,
    max_lights: int | None,
    min_flux_share: float,
    min_worth: float,
    rise: float,
    prominence: float,
    gap_deg: float,
    extent: float,
    working_width: int,
    white: float | None,
) -> tuple[DetectedLights, NDArray[np.float32]]:
    start = time.perf_counter()
    most = LARGEST_COUNT if max_lights is None else count("max_lights", max_lights, 1)
    options: dict[str, Any] = {
        "working_columns": count("working_width", working_width, least=_LEAST_COLUMNS),
        "rise": amount("rise", rise, least=1.0),
        "prominence": amount("prominence", prominence, least=1.0),
        "extent": amount("extent", extent, most=1.0),
        "gap": math.radians(amount("gap_deg", gap_deg, most=90.0)),
        "min_flux_share": amount("min_flux_share", min_flux_share, most=1.0),
        "min_worth": amount("min_worth", min_worth),
        "max_lights": most,
    }

    given = None if white is None else checked_white(white)

    def found_in(world: EnvMap) -> _Found:
        white = world.white if given is None else given
        columns = max(options["working_columns"] // _FEWER_COLUMNS, _LEAST_COLUMNS)
        where = world.radiance, world.registration == "border-sampled"
        if white is None:
            return _Found(_native.detect_tree(*where, original=None, **options), None)
        reduced = options | {"working_columns": columns, "original": None}
        behind_white = _native.detect_white(*where, white=white, **reduced)
        return _Found(behind_white.tree, behind_white)

    world, found = apply_to_map(env, found_in)
    tree = found.tree
    casts = cast_notes(world, tree.peak_direction, tree.peak_luminance)
    notes = (*world.notes, *casts, *_faint(tree))
    return _wrapped(found, notes, time.perf_counter() - start), tree.luminance


class _Found(NamedTuple):
    """What the kernel found in a map; the second is None where the map has no white."""

    tree: _native.TreeDetection
    behind_white: _native.WhiteDetection | None


def _wrapped(both: _Found, notes: tuple[str, ...], seconds: float) -> DetectedLights:
    found, behind_white = both
    report = DetectionReport(
        method="tree",
        threshold=found.threshold,
        reason=_reason(found) if behind_white is None else _reason_at_white(behind_white),
        working_size=found.working_size,
        **({} if behind_white is None else _cut_off(behind_white)),
        skipped=tuple(_skipped(found)),
        notes=notes,
        seconds={"detect": seconds},
    )
    return DetectedLights(
        found.direction,
        found.irradiance,
        peak_direction=found.peak_direction,
        solid_angle=found.solid_angle,
        elongation=found.elongation,
        orientation=found.orientation,
        peak_luminance=found.peak_luminance,
        flux_share=found.flux / (found.map_flux or 1.0),
        is_clipped=found.is_clipped,
        members=Members(found.pixel, found.light_of_pixel),
        report=report,
        weight=None if behind_white is None else behind_white.weight,
        direction_uncertainty=None if behind_white is None else behind_white.direction_uncertainty,
    )


def _cut_off(found: _native.WhiteDetection) -> dict[str, Any]:
    """Where the map was cut off, and what a light needs to weigh there."""
    ending, end = found.ending
    return {} if ending == "whole" else {"end": end, "least_weight": found.least_weight}


def _reason_at_white(found: _native.WhiteDetection) -> str:
    """Where the map ends, and the rule that this led to."""
    ending, end = found.ending
    if found.tree.threshold_rule is None:
        return _reason(found.tree)
    if ending == "whole":
        return (
            f"{_reason(found.tree)}; the map ends at {end:.3g}, below white, and has lost nothing"
        )
    at = f"in a peak of {end:.3g} below white"
    if ending == "white":
        at = f"at white, which {100 * found.clipped_share:.2g} % of the sphere reaches"
    return (
        f"{_reason(found.tree)}, of expanded luminance: the map ends {at}, so lights are told"
        " apart by the depth of their plateau"
    )


def _reason(found: _native.TreeDetection) -> str:
    """The rule that set the threshold, with its numbers."""
    if found.threshold_rule is None:
        return "that of the map before lights were taken out of it"
    factor, share, light_share = found.threshold_rule
    if light_share is None:
        return (
            f"{factor:g} times the luminance that {100 * share:.3g} % of the sphere does not exceed"
        )
    return (
        f"{factor:g} times the {100 * share:.3g} % quantile of what lies below the flux-weighted"
        f" Otsu cut, for the brightest {100 * light_share:.3g} % of the sphere is itself light"
    )


def _skipped(found: _native.TreeDetection) -> list[str]:
    """The tiles that were not opened and the lights that were not kept, in words."""
    dark = found.tiles - found.opened_tiles
    notes = [f"{dark} of {found.tiles} tiles ({100 * dark / found.tiles:.3g} %) that are dark"]
    if not len(found.flux) and not found.dropped:
        notes.append("everything: nothing rises far enough above the threshold")
    if found.dropped:
        lights = "light" if found.dropped == 1 else "lights"
        notes.append(f"{found.dropped} {lights} below min_flux_share or min_worth")
    notes += _joined(found)
    if found.merged:
        notes.append(f"the difference between {found.merged} lights and their neighbours")
    return notes


def _faint(found: _native.TreeDetection) -> list[str]:
    """The lights of low contrast, and how they were found."""
    places = [
        place_of(direction)
        for is_faint, direction in zip(found.is_faint, found.direction, strict=True)
        if is_faint
    ]
    lights = "light" if len(places) == 1 else "lights"
    found_by = "large, of low contrast and found by a sharp rim"
    return [f"{len(places)} {lights} {found_by}, at {'; '.join(places)}"] if places else []


def _joined(found: _native.TreeDetection) -> list[str]:
    """The openings that were joined from panes, and why."""
    share, widest = found.widest_bar
    return [
        f"the bars between {panes} panes of one opening at {place_of(direction)}: at most {share:g}"
        f" of a pane and {math.degrees(widest):g}° wide, darker than both sides, which are alike"
        for panes, direction in zip(found.panes, found.direction, strict=True)
        if panes
    ]
