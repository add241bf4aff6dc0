"""Picture of a sun: its position in the map, and shadows without and with it."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from envlights._common.srgb import encode_srgb
from envlights._common.units import in_lux
from envlights.environment.reading import AnyMap, as_envmap
from envlights.fitting.fit import fit
from envlights.kernels import sphere
from envlights.plot.figure import hide_frame
from envlights.plot.ground import degrees, draw_map, white_of
from envlights.plot.markers import RIM, draw_legend, draw_rims, draw_rings
from envlights.plot.outlines import outlines
from envlights.plot.page import Placement, Unpack, open_page, placed_picture
from envlights.plot.probe import viewpoint
from envlights.plot.wording import entitle
from envlights.rigs.rig import Rig, parts_line
from envlights.scene.still_life import closed_still
from envlights.sun.choice import AUTO, AnySun, sun_of
from envlights.sun.result import Sun

#: Colour of the outline of the clipped region.
_OUTLINE = "deepskyblue"
#: Area of the sun marker in square points.
_MARK = 40.0
#: Columns of the shadow images.
_WIDTH = 240
#: Columns of the grid in which the clipped region is outlined.
_COLUMNS = 1024


@placed_picture
def sun(env: AnyMap, sun: AnySun = AUTO, **where: Unpack[Placement]) -> Figure:
    """Draw the sun of a clipped map, and the shadows of a ball and a box without and with it.

    On the map, a ring marks the sun, a circle the uncertainty of its direction, and a line the
    clipped part. The shadows are those of two fits over a floor with four lights: to the map as
    it is, and with the sun as one of them. Each image has its own exposure.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map.
    sun : "auto", array_like of shape (3,), SunAt or Sun
        The sun; see `with_sun`.
    **where
        `ax`: of the map, and of each of the images; `figsize`, `dpi`, `transparent`: see
        `envlights.plot`.

    Returns
    -------
    matplotlib.figure.Figure
        Without the second image if the answer is "perhaps" or "no".

    Examples
    --------
    >>> import envlights as el
    >>> env = el.EnvMap(np.full((64, 128, 3), 0.5))
    >>> noon = el.sun.Sun("sun", direction=[0.6, 0.8, 0], irradiance=[4, 4, 4])
    >>> figure = el.plot.sun(env, noon)
    >>> [axes.get_title().splitlines()[0] for axes in figure.axes[1:]]
    ['the map as it is', 'with the sun as a light']
    """
    env = as_envmap(env)
    found = sun_of(env, sun)
    below = [1, 2] if len(found.lights) else [1, 1]
    page = open_page(where, [[0, 0], below], (10, 8.6), height_ratios=(1.4, 1))
    rigs = {"the map as it is": fit(env, floor=True)}
    if len(found.lights):
        rigs["with the sun as a light"] = fit(env, sun=found, floor=True)
    on_map, *images = page.panels
    entitle(on_map, draw_map(on_map, env), "small")
    _draw_sun(on_map, found)
    ((u, _),) = sphere.direction_to_uv([viewpoint([*rigs.values()][-1])])
    for axes, (title, rig) in zip(images, rigs.items(), strict=True):
        _draw_shadows(axes, rig, 2 * np.pi * u, title)
    page.entitle(_title(found))
    return page.figure


def _draw_sun(axes: Axes, found: Sun) -> None:
    """Draw a marker, the uncertainty and the clipped region, with a legend."""
    entries = []
    if found.plateau is not None:
        step = max(found.plateau.shape[1] // _COLUMNS, 1)
        inside = found.plateau[::step, ::step] > 0
        scale = np.array([360.0, -180.0]) / inside.shape[::-1]
        lines = outlines(inside.astype(np.int64)) * scale + (0.0, 90.0)
        axes.add_collection(LineCollection(list(lines), colors=_OUTLINE, lw=1.2))
        entries.append(Line2D([], [], color=_OUTLINE, lw=1.2, label="clipped part"))
    if found.direction is not None:
        draw_rims(axes, found.direction[None], np.array([found.direction_uncertainty]))
        draw_rings(axes, degrees(found.direction[None]), np.array([_MARK]))
        ring: dict[str, Any] = {"ls": "", "marker": "o", "ms": 8, "mfc": "none", "mec": "black"}
        entries.append(Line2D([], [], **ring, label="the sun"))
        circle = "two of three suns are inside"
        if found.direction_uncertainty:
            entries.append(Line2D([], [], color=RIM, lw=1.4, label=circle))
    if entries:
        draw_legend(axes, entries)


def _draw_shadows(axes: Axes, rig: Rig, azimuth: float, title: str) -> None:
    """Draw a ball and a box on a floor."""
    image = closed_still(rig, azimuth, _WIDTH)
    axes.imshow(encode_srgb(image / white_of(image)))
    entitle(axes, f"{title}\n{parts_line(rig)}")
    hide_frame(axes)


def _title(found: Sun) -> str:
    """Answer of the search, with the values that are guesses."""
    lines = [f"answer {found.answer!r}: {found.in_short()}"]
    if len(found.lights):
        low, high = found.interval
        times = f", a guess: true times {low:.2g} to {high:.2g}" if low != high else ""
        luminance = float(found.lights.luminance[0])
        lines.append(f"irradiance {luminance:.3g}{in_lux(found.units)}{times}")
    return "\n".join(lines)
