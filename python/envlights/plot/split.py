"""Picture of a split map: the map, the remainder, and the removed light."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from envlights._common.words import percent
from envlights.environment.envmap import EnvMap
from envlights.environment.reading import AnyMap, as_envmap
from envlights.kernels import thumbnails
from envlights.kernels.image import LUMINANCE
from envlights.plot.figure import check_is
from envlights.plot.ground import degrees, draw_ground, expose, working
from envlights.plot.markers import (
    draw_legend,
    draw_numbers,
    draw_rims,
    draw_rings,
    key_of,
    key_of_rims,
    number_colours,
    sizes_for,
)
from envlights.plot.page import Placement, Unpack, grid, open_page, placed_picture
from envlights.plot.wording import entitle
from envlights.splitting.removed_lights import RemovedLights
from envlights.splitting.split import Split


@placed_picture
def split_picture(env: AnyMap, parts: Split, **where: Unpack[Placement]) -> Figure:
    """Draw a map, the remainder, and the removed light, at the exposure of the map.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map.
    parts : Split
        The result of `split` on it.
    **where
        `ax`: three axes; `figsize`, `dpi`, `transparent`: see `envlights.plot`.

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
    page = open_page(where, grid(3, 1), (9, 15))
    on_map, on_rest, on_removed = page.panels
    whole, remainder = working(env), working(parts.remainder)
    ground = expose(whole)
    draw_ground(on_map, ground.codes)
    draw_ground(on_rest, thumbnails.expose(remainder, ground.white))
    draw_ground(on_removed, thumbnails.expose(np.maximum(whole - remainder, 0), ground.white))
    _draw_marks(on_removed, lights)
    brightest, left = _brightest(env), _brightest(parts.remainder)
    title = f"the map: white is luminance {ground.white:.3g}, the brightest pixel {brightest}"
    entitle(on_map, title, "small")
    entitle(on_rest, f"without the lights: the brightest pixel {left}", "small")
    entitle(on_removed, "the removed radiance, and the lights", "small")
    flux = percent(lights.flux_fraction.sum())
    page.entitle(f"{lights.in_short()} removed, with {flux} of all light in the map")
    return page.figure


def _draw_marks(axes: Axes, lights: RemovedLights) -> None:
    """Draw rings around lights, and their numbers."""
    discs, sizes = lights.discs(), sizes_for(axes, lights.fraction)
    draw_rims(axes, lights.direction, discs.angular_radius)
    at, areas = degrees(lights.direction), sizes.area(lights.fraction)
    draw_rings(axes, at, areas)
    draw_numbers(axes, at, areas, colours=number_colours(discs.angular_radius))
    draw_legend(axes, [*key_of(lights.fraction, sizes), *key_of_rims(discs.angular_radius)])


def _brightest(env: EnvMap) -> str:
    """Largest luminance of a map, as text."""
    largest = float((env.radiance @ LUMINANCE.astype(np.float32)).max())
    return np.format_float_positional(largest, 3, fractional=False, trim="-")
