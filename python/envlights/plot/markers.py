"""Markers of lights on a map: discs in their colour with an area for their share, rims, numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from envlights._thumbnails import colours_of
from envlights.lights import Lights
from envlights.plot.ground import EXTENT, degrees
from envlights.scene.surface import tangent_frames

#: Area of the disc of a light with a share of 1, and the least area, in square points.
_LARGEST, _SMALLEST = 900.0, 14.0
#: Shares in the legend.
_SHARES = (0.5, 0.1, 0.01)
#: Colour of rims and outlines: rare in photographs.
RIM = "#ff2bd6"
#: Size of numbers, and width of a letter and height of a line of them, in points.
_FONT, _LETTER, _LINE = 9, 5.8, 10.2
#: Smallest number of points on the page for a degree of a map that fills the page.
_POINTS = 1.6
#: Largest radius of a disc that numbers avoid, and their gap from discs, as fractions of the width.
_WIDEST_DISC, _GAP = 12 / 360, 0.8 / 360
#: Largest number of numbers on one map.
_MOST_NUMBERS = 40


def area(share: NDArray[np.float64]) -> NDArray[np.float64]:
    """Area of the markers of lights, in square points: the eye compares areas."""
    found: NDArray[np.float64] = np.maximum(_LARGEST * share, _SMALLEST)
    return found


def draw_lights(axes: Axes, lights: Lights, points: float = _POINTS) -> None:
    """Draw the rim of each light with a size, a disc in its colour, and numbers that fit.

    A degree of the map takes at least `points` of the page; discs shrink with it.
    """
    at, areas = degrees(lights.direction), area(lights.share) * (points / _POINTS) ** 2
    draw_rims(axes, lights.direction, lights.angular_radius)
    draw_discs(axes, at, areas, lights.irradiance)
    draw_numbers(axes, at, areas, points)


def draw_rims(axes: Axes, directions: NDArray[np.float64], radii: NDArray[np.float64]) -> None:
    """Draw a circle on the sphere around each direction; none of radius 0."""
    rims = [_rim(*each) for each in zip(directions, radii, strict=True)]
    if drawn := [rim for rim in rims if len(rim)]:
        axes.plot(*np.concatenate(drawn).T, color=RIM, lw=1.4)


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
    """Draw a ring for each light, which leaves the map visible."""
    x, y = at.T
    ring: dict[str, Any] = {"facecolors": "none", "clip_on": False}
    axes.scatter(x, y, s=_ring(areas), edgecolors="black", linewidths=2.8, zorder=3, **ring)
    axes.scatter(x, y, s=_ring(areas), edgecolors="white", linewidths=1.2, zorder=4, **ring)


def _ring(areas: NDArray[np.float64]) -> NDArray[np.float64]:
    """Area of a disc with its ring."""
    return 1.5 * areas + 12


def _rim(direction: NDArray[np.float64], radius: float) -> NDArray[np.float64]:
    """Azimuth and elevation along the rim of a disc, with gaps at the seam and at its end."""
    if not radius:
        return np.zeros((0, 2))
    angle = np.linspace(0, 2 * np.pi, 361)
    circle = np.sin(radius) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    (frame,) = tangent_frames(direction[None])
    rim = degrees(circle @ frame[:2] + np.cos(radius) * direction)
    rim[1:][np.abs(np.diff(rim[:, 0])) > 180] = np.nan
    return np.vstack([rim, [[np.nan, np.nan]]])


def draw_numbers(
    axes: Axes,
    at: NDArray[np.float64],
    areas: NDArray[np.float64],
    points: float = _POINTS,
    extent: tuple[float, float, float, float] = EXTENT,
) -> None:
    """Number lights beside their discs if there is room, the brightest first.

    A number neither covers another, nor any disc, nor leaves the picture. A unit of the axes, a
    degree of a map, takes `points` of the page.
    """
    radii = np.sqrt(_ring(areas) / np.pi) / points
    size = np.array([_LETTER, _LINE]) / points
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
            fontsize=_FONT,
            color="white",
            path_effects=[withStroke(linewidth=2.5, foreground="black")],
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
    """Left, bottom, right and top of free space for `text` beside a disc, or None.

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


def legend_entries(lights: Lights) -> list[Line2D]:
    """Legend entries of discs and rims."""
    entries = [
        _entry("o", f"{100 * share:g} %", 2 * np.sqrt(float(area(np.array(share))) / np.pi))
        for share in _SHARES
    ]
    entries[0].set_label(f"share of the light: {entries[0].get_label()}")
    if lights.angular_radius.any():
        entries.append(Line2D([], [], color=RIM, lw=1.4, label="size"))
    return entries


def _entry(marker: str, label: str, size: float) -> Line2D:
    return Line2D([], [], ls="", marker=marker, ms=size, mfc="0.75", mec="black", label=label)


def draw_legend(axes: Axes, entries: Sequence[Artist]) -> None:
    """Add a legend of the markers below the map."""
    axes.legend(
        handles=entries,
        loc="upper center",
        bbox_to_anchor=(0.5, -0.11),
        ncols=len(entries),
        frameon=False,
        handletextpad=0.6,
    )
