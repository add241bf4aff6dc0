"""Picture of a split map: the map, the remainder, and the removed light."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from envlights import _thumbnails
from envlights.detection.removed_lights import RemovedLights
from envlights.detection.split import Split
from envlights.envmap import AnyMap, EnvMap, as_envmap
from envlights.kernels.image import LUMINANCE
from envlights.plot.figure import Picture, check_is
from envlights.plot.ground import degrees, draw_ground, expose, working
from envlights.plot.markers import (
    area,
    draw_legend,
    draw_numbers,
    draw_rims,
    draw_rings,
    legend_entries,
)


def split_picture(env: AnyMap, parts: Split) -> Picture:
    """Draw a map, the remainder, and the removed light, all with the exposure of the map.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map.
    parts : Split
        The result of `split` on it.

    Returns
    -------
    matplotlib.figure.Figure

    Examples
    --------
    >>> import envlights as el
    >>> env = el.EnvMap(el.synthetic.hall(64).radiance)
    >>> figure = split_picture(env, el.split(env))
    >>> len(figure.axes)
    3
    """
    check_is("parts", parts, Split)
    env = as_envmap(env)
    lights = parts.lights
    figure = Picture(figsize=(9, 15))
    on_map, on_rest, on_removed = np.ravel(figure.subplots(3, 1))
    whole, rest = working(env), working(parts.rest)
    ground = expose(whole)
    draw_ground(on_map, ground.codes)
    draw_ground(on_rest, _thumbnails.expose(rest, ground.white))
    draw_ground(on_removed, _thumbnails.expose(np.maximum(whole - rest, 0), ground.white))
    _draw_marks(on_removed, lights)
    brightest, left = _brightest(env), _brightest(parts.rest)
    title = f"the map; white is luminance {ground.white:.3g}, the brightest pixel has {brightest}"
    on_map.set_title(title, fontsize="small")
    on_rest.set_title(
        f"the map without the lights; the brightest pixel has {left}", fontsize="small"
    )
    on_removed.set_title("the removed radiance, and the lights", fontsize="small")
    share = 100 * lights.flux_share.sum()
    figure.suptitle(f"{lights.in_short()} removed, with {share:.3g} % of all light in the map")
    return figure


def _draw_marks(axes: Axes, lights: RemovedLights) -> None:
    """Draw rings around lights, and their numbers."""
    draw_rims(axes, lights.direction, lights.discs().angular_radius)
    at, areas = degrees(lights.direction), area(lights.share)
    draw_rings(axes, at, areas)
    draw_numbers(axes, at, areas)
    draw_legend(axes, legend_entries(lights.discs()))


def _brightest(env: EnvMap) -> str:
    """Largest luminance of a map."""
    largest = float((env.radiance @ LUMINANCE.astype(np.float32)).max())
    return np.format_float_positional(largest, 3, fractional=False, trim="-")
