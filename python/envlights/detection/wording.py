"""Sentences for detection reports."""

from __future__ import annotations

import math

from envlights import _native
from envlights._common.words import percent
from envlights.kernels.angles import place_of


def reason_of_tree(detection: _native.TreeDetection) -> str:
    """Rule that determined the threshold, with its numbers."""
    if detection.threshold_rule is None:
        return "set by the caller"
    factor, fraction, light_share = detection.threshold_rule
    quantile = f"{factor:g} x the {percent(fraction)} quantile"
    if light_share is None:
        return quantile
    return f"{quantile} of all but the brightest parts"


def dropped_by_tree(detection: _native.TreeDetection) -> tuple[str, ...]:
    """Sentences on lights that the result does not list."""
    lines = []
    if not len(detection.flux_fraction) and not detection.dropped:
        lines.append("no lights: nothing is much brighter than the threshold")
    if detection.dropped:
        lights = "light is" if detection.dropped == 1 else "lights are"
        lines.append(
            f"{detection.dropped} {lights} too weak to list (options min_flux_fraction, min_worth)"
        )
    if detection.merged:
        lights = "light was" if detection.merged == 1 else "lights were"
        lines.append(f"{detection.merged} {lights} merged into neighbours (option max_lights)")
    return tuple(lines)


def left_out(number: int) -> str:
    """Sentence on weaker lights that exceed the requested number."""
    lights = "light is" if number == 1 else "lights are"
    return f"{number} weaker {lights} left in the map (option lights)"


def joined_panes(detection: _native.TreeDetection) -> list[str]:
    """Sentences on windows that were merged from panes."""
    return [
        f"the light at {place_of(direction)} is a window joined from {panes} panes"
        for panes, direction in zip(detection.panes, detection.direction, strict=True)
        if panes
    ]


def cut_lights(detection: _native.TreeDetection) -> list[str]:
    """Note on lights at the border of the visible part of the map."""
    cut = int(detection.is_cut.sum())
    if not cut:
        return []
    lights = "light touches" if cut == 1 else "lights touch"
    return [f"{cut} {lights} the border of what the map shows, so the flux is a lower bound"]


def details_of_tree(detection: _native.TreeDetection) -> tuple[str, ...]:
    """Details for developers of detectors."""
    return (*_rules(detection), *_clipping(detection), *_tiles(detection))


def _rules(detection: _native.TreeDetection) -> list[str]:
    lines = []
    if detection.threshold_rule is not None and detection.threshold_rule[2] is not None:
        fraction = percent(detection.threshold_rule[2])
        lines.append(
            f"the brightest {fraction} of the sphere counts as light, so the quantile is"
            " taken below the flux-weighted Otsu threshold"
        )
    if any(detection.panes):
        ratio, widest = detection.widest_bar
        lines.append(
            f"a window bar is darker than both panes; its width is at most {ratio:g} of the mean"
            f" depth of the panes, and at most {math.degrees(widest):g}°"
        )
    return lines


def _clipping(detection: _native.TreeDetection) -> list[str]:
    clipped = detection.clipped
    if clipped is None:
        return []
    level = f"the map is clipped at {clipped.clip_level:.3g}"
    if clipped.is_below_largest:
        level += ", below its largest possible value"
    fraction = f"{percent(clipped.clipped_fraction, 2)} of the sphere is clipped"
    expanded = (
        "the search used expanded luminance (Schlick 1994), in which values near the clip"
        " level are up to 50 times larger"
    )
    return [f"{level}; {fraction}", expanded]


def _tiles(detection: _native.TreeDetection) -> list[str]:
    tiles, dark = detection.tiles, detection.tiles - detection.opened_tiles
    return [f"{dark} of {tiles} tiles ({percent(dark / tiles)}) are dark and were not searched"]


def reason_of_article(relative: str, level: float, clip_level: float | None, code: float) -> str:
    """Rule that determined the article's threshold, with its code in an 8-bit file.

    `relative` is the rule of a relative threshold, and empty for an absolute one.
    """
    reason = relative or "a fixed value, as in the article"
    if clip_level is None:
        return reason
    if level >= clip_level:
        return f"{reason}; it lies above the clip level"
    fraction = f"{percent(level / clip_level)} of the clip level"
    return f"{reason}; {fraction}, code {code:.0f} of 255 in sRGB"
