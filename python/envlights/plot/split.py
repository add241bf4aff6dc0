"""A map, what is left of it without its lights, and the lights."""

from __future__ import annotations

import numpy as np

from envlights.detection.split import Split
from envlights.envmap import AnyMap, as_envmap
from envlights.plot.figure import Picture
from envlights.plot.ground import draw_map
from envlights.plot.markers import draw_legend, draw_lights, legend_entries

#: Rows of the map of lights, at most.
_ROWS = 512


def split_picture(env: AnyMap, parts: Split) -> Picture:
    """Draw a map, what is left of it, and its lights as discs, all in the exposure of the map.

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
    env = as_envmap(env)
    lights = parts.lights
    figure = Picture(figsize=(9, 15))
    on_map, on_rest, on_lights = np.ravel(figure.subplots(3, 1))
    exposure = draw_map(on_map, env)
    draw_map(on_rest, parts.rest, like=env)
    draw_map(on_lights, lights.to_map(min(env.height, _ROWS)), like=env)
    draw_lights(on_lights, lights.discs())
    draw_legend(on_lights, legend_entries(lights))
    on_map.set_title(f"the map: {exposure}", fontsize="small")
    on_rest.set_title("what is left", fontsize="small")
    on_lights.set_title("the lights", fontsize="small")
    share = 100 * lights.flux_share.sum()
    figure.suptitle(f"{lights.in_short()} with {share:.3g} % of the flux, taken out of a map")
    return figure
