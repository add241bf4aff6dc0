"""Markers of lights on a map: coloured discs with area by flux fraction, rims, and numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.transforms import ScaledTranslation
from numpy.typing import NDArray

from envlights.kernels.thumbnails import colours_of
from envlights.plot.ground import EXTENT, degrees
from envlights.plot.wording import LETTER, font_size, is_narrow, points_per_unit, width_of
from envlights.rigs.lights import Lights
from envlights.scene.surface import tangent_frames

#: Area of the disc of the largest light, and smallest area, in square points, on a wide map.
_LARGEST, _SMALLEST = 450.0, 14.0
#: Smallest area of a disc on any map.
_VISIBLE = 4.0
#: Points per degree on a wide map; discs on smaller maps are scaled down.
_WIDE = 1.6
#: Fraction of the largest light below which all discs are scaled down, so that many lights do not
#: fill the map.
_LEAST_LARGEST = 0.05
#: Flux fractions that a size legend may show, and how many of them.
_SHARES, _KEYS = (0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001), 3
#: Colour of rims and outlines, rare in photographs.
RIM = "#ff2bd6"
#: Colours of light rims and their numbers, used cyclically.
TINTS = (RIM, "#00e0ff", "#ffe11a", "#4dff6a", "#ff8a1f", "#b79bff", "#ffffff", "#ff6a5e")
#: Font size of numbers relative to the style, and line height.
_FONT, _LINE = 0.9, 1.13
#: Width of the black border of numbers, relative to their font size.
_EDGE = 0.26
#: Largest disc radius that numbers avoid, and their distance from discs, relative to the map width.
_WIDEST_DISC, _GAP = 12 / 360, 0.8 / 360
#: Largest number of numbers on one map.
_MOST_NUMBERS = 40


class Sizes(NamedTuple):
    """Conversion of flux fractions to disc areas, because the eye compares areas."""

    whole: float
    """Area for a fraction of 1, in square points."""

    least: float
    """Smallest area of a disc, in square points."""

    def area(self, fraction: NDArray[np.float64]) -> NDArray[np.float64]:
        """Areas of the discs of lights, in square points."""
        found: NDArray[np.float64] = np.maximum(self.whole * fraction, self.least)
        return found


def sizes_for(
    axes: Axes,
    fraction: NDArray[np.float64],
    part: float = 1.0,
    extent: tuple[float, float, float, float] = EXTENT,
) -> Sizes:
    """Disc sizes for the lights of a map, or of several maps to be compared.

    The largest light gets `part` of the largest disc, unless all are small.
    """
    shrink = min(points_per_unit(axes, extent) / _WIDE, 1) ** 2
    largest = max(float(fraction.max(initial=0.0)), _LEAST_LARGEST)
    return Sizes(part * shrink * _LARGEST / largest, max(shrink * _SMALLEST, _VISIBLE))


def draw_lights(axes: Axes, lights: Lights, sizes: Sizes) -> None:
    """Draw coloured discs, rims for lights with a size, and as many numbers as fit.

    The number of a light has the colour of its rim.
    """
    at, areas = degrees(lights.direction), sizes.area(lights.fraction)
    draw_rims(axes, lights.direction, lights.angular_radius)
    draw_discs(axes, at, areas, lights.irradiance)
    draw_numbers(axes, at, areas, colours=number_colours(lights.angular_radius))


def number_colours(radii: NDArray[np.float64]) -> list[str]:
    """Colour of the number of each light: the colour of its rim, or white without a rim."""
    return [TINTS[k % len(TINTS)] if radius else "white" for k, radius in enumerate(radii)]


def draw_rims(axes: Axes, directions: NDArray[np.float64], radii: NDArray[np.float64]) -> None:
    """Draw a circle on the sphere around each direction, coloured cyclically; none for radius 0."""
    rims = [_rim(*each) for each in zip(directions, radii, strict=True)]
    pieces = [
        (piece, colour)
        for rim, colour in zip(rims, number_colours(radii), strict=True)
        for piece in _pieces(rim)
    ]
    if pieces:
        lines, colours = zip(*pieces, strict=True)
        style: dict[str, Any] = rim_style(line_scale(axes))
        axes.add_collection(LineCollection(list(lines), colors=list(colours), zorder=2.5, **style))


def rim_style(scale: float = 1.0) -> dict[str, Any]:
    """Style of rims: a line with a black edge, visible on dark and bright maps."""
    edge = withStroke(linewidth=2.6 * scale, foreground="black")
    return {"linewidth": 1.4 * scale, "path_effects": [edge]}


def line_scale(axes: Axes) -> float:
    """Scale factor for lines and markers; below 1 on a small map."""
    return min(max(points_per_unit(axes, EXTENT) / _WIDE, 0.5), 1.0)


def _pieces(rim: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Parts of a rim between its gaps."""
    gaps = np.flatnonzero(np.isnan(rim[:, 0]))
    return [part[~np.isnan(part[:, 0])] for part in np.split(rim, gaps) if len(part) > 1]


def draw_discs(
    axes: Axes,
    at: NDArray[np.float64],
    areas: NDArray[np.float64],
    irradiance: NDArray[np.float64],
) -> None:
    """Draw discs in the colours of lights, with a ring that is visible on dark and bright maps."""
    colours = colours_of(irradiance)
    x, y = at.T
    axes.scatter(x, y, s=_ring(areas), c="black", linewidths=0, clip_on=False, zorder=3)
    axes.scatter(
        x, y, s=areas, c=colours, edgecolors="white", linewidths=1.2, clip_on=False, zorder=4
    )


def draw_rings(axes: Axes, at: NDArray[np.float64], areas: NDArray[np.float64]) -> None:
    """Draw a ring around each light, so that the map stays visible inside."""
    x, y = at.T
    ring: dict[str, Any] = {"facecolors": "none", "clip_on": False}
    axes.scatter(x, y, s=_ring(areas), edgecolors="black", linewidths=2.8, zorder=3, **ring)
    axes.scatter(x, y, s=_ring(areas), edgecolors="white", linewidths=1.2, zorder=4, **ring)


def _ring(areas: NDArray[np.float64]) -> NDArray[np.float64]:
    """Area of a disc including its ring."""
    return 1.5 * areas + 12


def _rim(direction: NDArray[np.float64], radius: float) -> NDArray[np.float64]:
    """Azimuth and elevation along the rim of a disc, with gaps at the seam."""
    if not radius:
        return np.zeros((0, 2))
    angle = np.linspace(0, 2 * np.pi, 361)
    circle = np.sin(radius) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    (frame,) = tangent_frames(direction[None])
    rim = degrees(circle @ frame[:2] + np.cos(radius) * direction)
    rim[1:][np.abs(np.diff(rim[:, 0])) > 180] = np.nan
    return rim


def draw_numbers(
    axes: Axes,
    at: NDArray[np.float64],
    areas: NDArray[np.float64],
    extent: tuple[float, float, float, float] = EXTENT,
    colours: Sequence[str] | None = None,
) -> None:
    """Number lights beside their discs where there is room, brightest first.

    A number neither covers another, nor any disc, nor leaves the picture.
    """
    points, font = points_per_unit(axes, extent), _FONT * font_size("font.size")
    radii = np.sqrt(_ring(areas) / np.pi) / points
    # A digit is wider than the mean letter.
    size = font * np.array([1.2 * LETTER, _LINE]) / points
    reach = np.minimum(radii, _WIDEST_DISC * (extent[1] - extent[0]))[:, None]
    occupied = np.hstack([at - reach, at + reach])
    for k in range(min(len(at), _MOST_NUMBERS)):
        others = np.delete(occupied, k, axis=0)
        box = _free_box(f"{k + 1}", size, at[k], radii[k], others, extent)
        if box is None:
            continue
        occupied = np.vstack([occupied, box])
        axes.text(
            (box[0] + box[2]) / 2,
            (box[1] + box[3]) / 2,
            f"{k + 1}",
            ha="center",
            va="center",
            fontsize=font,
            color=colours[k] if colours is not None else "white",
            path_effects=[withStroke(linewidth=_EDGE * font, foreground="black")],
            zorder=5,
        )


def _free_box(
    text: str,
    size: NDArray[np.float64],
    at: NDArray[np.float64],
    radius: float,
    occupied: NDArray[np.float64],
    extent: tuple[float, float, float, float],
) -> NDArray[np.float64] | None:
    """Left, bottom, right and top of free space for `text` beside a disc; None if there is none.

    `size` is that of a letter in units of the axes.
    """
    half, gap = size * (len(text), 1) / 2, _GAP * (extent[1] - extent[0])
    for across, up in ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1)):
        middle = at + np.array([across, up]) * (radius + half + gap)
        box = np.concatenate([middle - half, middle + half])
        inside = box[0] >= extent[0] and box[2] <= extent[1] and box[1] >= extent[2]
        apart = (box[2:] <= occupied[:, :2]).any(axis=1) | (box[:2] >= occupied[:, 2:]).any(axis=1)
        if inside and box[3] <= extent[3] and apart.all():
            return box
    return None


def key_of(fraction: NDArray[np.float64], sizes: Sizes) -> list[Line2D]:
    """Legend of disc areas, with flux fractions that occur among the lights."""
    largest = float(fraction.max(initial=0.0))
    named = [fraction for fraction in _SHARES if fraction <= max(largest, _SHARES[-1])][::2][:_KEYS]
    # Omit fractions below the smallest area, because they look the same.
    seen = [fraction for fraction in named if sizes.whole * fraction >= sizes.least] or named[:1]
    entries = [
        _entry("o", f"{100 * fraction:g} %", _diameter(sizes, fraction)) for fraction in seen
    ]
    entries[0].set_label(f"fraction {entries[0].get_label()}")
    return entries


def key_of_rims(radii: NDArray[np.float64]) -> list[Line2D]:
    """Legend of rims; empty if no light has a size."""
    if not radii.any():
        return []
    return [Line2D([], [], color=RIM, label="size", **rim_style())]


def _diameter(sizes: Sizes, fraction: float) -> float:
    return 2 * float(np.sqrt(sizes.area(np.array(fraction)) / np.pi))


def _entry(marker: str, label: str, size: float) -> Line2D:
    return Line2D([], [], ls="", marker=marker, ms=size, mfc="0.75", mec="black", label=label)


def draw_legend(axes: Axes, entries: Sequence[Artist]) -> None:
    """Add a legend below the map, in as many columns as fit; none on a narrow map."""
    if is_narrow(axes):
        return
    font = font_size("legend.fontsize")
    widths = [font * (LETTER * len(str(entry.get_label())) + 4) for entry in entries]
    is_row = sum(widths) < 1.1 * width_of(axes)
    columns = len(entries) if is_row else int(width_of(axes) / max(widths))
    has_marks = len(axes.get_xticks()) > 0
    # Leave room for ticks and axis label between axes and legend.
    room = font_size("xtick.labelsize") * 1.6 + font_size("axes.labelsize") if has_marks else 0.0
    down = ScaledTranslation(0, -(room + 2) / 72, axes.figure.dpi_scale_trans)
    axes.legend(
        handles=list(entries),
        loc="upper center",
        bbox_to_anchor=(0.5, 0),
        bbox_transform=axes.transAxes + down,
        ncols=min(max(columns, 1), len(entries)),
        frameon=False,
        handletextpad=0.6,
    )
