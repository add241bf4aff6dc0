"""A map, what is left of it without its lights, and what was taken."""

from __future__ import annotations

import numpy as np

from envlights.detection.split import Split
from envlights.envmap import AnyMap, EnvMap, as_envmap
from envlights.plot.figure import Picture, check_is
from envlights.plot.ground import draw_ground, exposed
from envlights.plot.markers import draw_legend, draw_lights, legend_entries


def split_picture(env: AnyMap, parts: Split) -> Picture:
    """Draw a map, what is left of it, and what was taken, all in the exposure of the map.

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
    on_map, on_rest, on_taken = np.ravel(figure.subplots(3, 1))
    ground = exposed(env)
    draw_ground(on_map, ground)
    draw_ground(on_rest, exposed(parts.rest, ground.white))
    # What a channel has gained, where one light has several colours, is no light.
    taken = np.maximum(env.radiance - parts.rest.radiance, 0)
    draw_ground(on_taken, exposed(EnvMap(taken, registration=env.registration), ground.white))
    draw_lights(on_taken, lights.discs())
    draw_legend(on_taken, legend_entries(lights))
    on_map.set_title(f"the map: {ground.exposure}", fontsize="small")
    on_rest.set_title("what is left", fontsize="small")
    on_taken.set_title("what was taken, and its lights", fontsize="small")
    share = 100 * lights.flux_share.sum()
    figure.suptitle(f"{lights.in_short()} with {share:.3g} % of the flux, taken out of a map")
    return figure
