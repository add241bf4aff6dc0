"""Pictures of a map: alone, with a rig and the probe, or with detected lights."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from envlights._common.check import flag
from envlights.detection.lights import DetectedLights
from envlights.environment.reading import AnyMap, as_envmap
from envlights.plot.figure import check_is
from envlights.plot.ground import degrees, draw_luminance, draw_map
from envlights.plot.markers import (
    RIM,
    draw_discs,
    draw_legend,
    draw_lights,
    draw_numbers,
    key_of,
    key_of_rims,
    line_scale,
    sizes_for,
)
from envlights.plot.outlines import outlines
from envlights.plot.page import Placement, Unpack, open_page, placed_picture
from envlights.plot.probe import (
    draw_difference_bar,
    draw_probes,
    error_limit,
    scale_for,
    shaded_ball,
    viewpoint,
)
from envlights.plot.wording import entitle
from envlights.rigs.rig import Rig, error_line, parts_line

#: Colour of the marker for the view direction.
_EYE = "deepskyblue"
#: Largest number of links in a picture.
_MOST_LINKS = 20_000


@placed_picture
def map_picture(env: AnyMap, *, stops: bool = False, **where: Unpack[Placement]) -> Figure:
    """Draw a map without lights.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map.
    stops : bool
        False: the map, exposed so that its lamps are visible; the title has the exposure. True: the
        luminance in false colours, in stops (powers of two) above and below the white of that
        exposure.
    **where
        `ax`, `figsize`, `dpi` and `transparent`; see `envlights.plot`.

    Examples
    --------
    >>> import envlights as el
    >>> figure = map_picture(el.synthetic.hall(64).radiance)
    >>> figure.get_suptitle().splitlines()[0]
    '128x64 pixels'
    """
    env = as_envmap(env)
    stops = flag("stops", stops)
    # Reserve width for the colour bar.
    page = open_page(where, [[0]], (10, 5.1 if stops else 5.6))
    (axes,) = page.panels
    draw = draw_luminance if stops else draw_map
    exposure = draw(axes, env)
    page.entitle(f"{env.width}x{env.height} pixels\n{exposure}")
    return page.figure


@placed_picture
def picture(env: AnyMap, rig: Rig, **where: Unpack[Placement]) -> Figure:
    """Draw the map with the lights on it, the probe under map and rig, and their difference.

    The probe is viewed from beside the brightest light, so that its lit and its dark side are
    visible; the map has a mark at the position of the viewer. Both probes have the same exposure;
    the difference is that of the luminance, in percent of the mean.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map.
    rig : Rig
        Rig to draw.
    **where
        `ax`: of the map, and of the three balls; `figsize`, `dpi`, `transparent`: see
        `envlights.plot`.

    Examples
    --------
    >>> import envlights as el
    >>> env = el.EnvMap(el.synthetic.hall(32).radiance)
    >>> figure = picture(env, el.fit(env, lights=1))
    >>> len(figure.axes)
    5
    """
    check_is("rig", rig, Rig)
    env = as_envmap(env)
    page = open_page(where, [[0, 0, 0], [1, 2, 3]], (10, 8.6), height_ratios=(1.6, 1))
    on_map, *balls = page.panels
    exposure = draw_map(on_map, env)
    sizes, eye = sizes_for(on_map, rig.lights.fraction), viewpoint(rig)
    draw_lights(on_map, rig.lights, sizes)
    shaded = shaded_ball(env, eye, rig.floor)
    drawn = draw_probes(balls, shaded, rig, scale_for([error_limit(shaded, rig)]))
    draw_difference_bar(page.figure, balls[2:], drawn)
    draw_legend(
        on_map,
        [
            *key_of(rig.lights.fraction, sizes),
            *key_of_rims(rig.lights.angular_radius),
            _draw_eye(on_map, eye),
        ],
    )
    entitle(on_map, exposure, "small")
    page.entitle(f"{parts_line(rig)}: {error_line(rig)}")
    return page.figure


@placed_picture
def detection_picture(env: AnyMap, lights: DetectedLights, **where: Unpack[Placement]) -> Figure:
    """Draw the map with its detected lights, as in Loghin (2021).

    Discs mark the directions of the lights, in their colours, with areas proportional to the
    flux. Lines are the outlines of their pixels, or their samples with a link to each. Crosses are
    their peaks.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map.
    lights : DetectedLights
        The result of `detect` on it.
    **where
        `ax`, `figsize`, `dpi` and `transparent`; see `envlights.plot`.

    Examples
    --------
    >>> import envlights as el
    >>> env = el.EnvMap(el.synthetic.hall(128).radiance)
    >>> figure = detection_picture(env, el.detect(env))
    >>> len(figure.axes)
    1
    """
    check_is("lights", lights, DetectedLights)
    env = as_envmap(env)
    page = open_page(where, [[0]], (12, 7))
    (axes,) = page.panels
    exposure = draw_map(axes, env)
    _draw_members(axes, lights)
    # Draw discs half as large as for a rig, because lamps may be close together.
    sizes = sizes_for(axes, lights.fraction, 0.5)
    at, areas = degrees(lights.direction), sizes.area(lights.fraction)
    draw_discs(axes, at, areas, lights.irradiance)
    peaks = degrees(lights.peak_direction)
    axes.plot(*peaks.T, "+", ms=5, mew=1, color="deepskyblue", clip_on=False, zorder=5)
    draw_numbers(axes, at, areas)
    outline, cross = (
        Line2D([], [], color=RIM, lw=1, label="outline"),
        Line2D([], [], ls="", marker="+", color="deepskyblue", label="peak"),
    )
    if lights.report.method != "tree":
        outline.set_label("samples, linked to their light")
    draw_legend(axes, [*key_of(lights.fraction, sizes), outline, cross])
    report = lights.report
    title = f"{lights.in_short()}; threshold {report.threshold:.3g} ({report.reason})"
    page.entitle(f"{title}\n{exposure}")
    return page.figure


def _draw_eye(axes: Axes, eye: NDArray[np.float64]) -> Line2D:
    """Mark the view direction of the probe."""
    ((azimuth, elevation),) = degrees(eye[None])
    # Draw it above the numbers, which could cover it.
    size = 9 * line_scale(axes)
    style: dict[str, Any] = {"marker": "^", "zorder": 6}
    axes.scatter([azimuth], [elevation], size**2, c=_EYE, edgecolors="black", lw=size / 9, **style)
    return Line2D([], [], ls="", marker="^", ms=size, mfc=_EYE, mec="black", label="viewer")


def _draw_members(axes: Axes, lights: DetectedLights) -> None:
    """Draw outlines of pixels, or samples with their links."""
    height, width = lights.report.working_size
    rows, columns = lights.members.pixel.T
    scale, corner = np.array([360 / width, -180 / height]), np.array([0.0, 90.0])
    if lights.report.method != "tree":
        at = np.stack([columns + 0.5, rows + 0.5], axis=1) * scale + corner
        homes = degrees(lights.direction)[lights.members.light]
        is_near = np.abs(homes[:, 0] - at[:, 0]) < 180  # no line across the whole map at the seam
        links = np.stack([at, homes], axis=1)[is_near][:_MOST_LINKS]
        axes.add_collection(LineCollection(list(links), colors=RIM, lw=0.4))
        axes.plot(*at.T, ".", ms=2, color=RIM)
        return
    number = np.zeros((height, width), np.int64)
    number[rows, columns] = 1 + lights.members.light
    axes.add_collection(LineCollection(list(outlines(number) * scale + corner), colors=RIM, lw=0.8))
