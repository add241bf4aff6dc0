"""Picture of white balls under a map and under rigs, in a row."""

from __future__ import annotations

from matplotlib.figure import Figure

from envlights.environment.reading import AnyMap, as_envmap
from envlights.plot.figure import check_are_rigs
from envlights.plot.page import Placement, Unpack, grid, open_page, placed_picture
from envlights.plot.probe import draw_probe, shaded_ball, viewpoint, white_for
from envlights.plot.wording import entitle
from envlights.rigs.rig import Rig


@placed_picture
def probes(env: AnyMap, *rigs: Rig, **where: Unpack[Placement]) -> Figure:
    """Draw white balls under a map and under rigs, in a row with a common exposure.

    The colours are the sRGB codes of the irradiance over that of the brightest point under the map,
    without any other curve. All balls are viewed from beside the brightest light of the first rig;
    over a floor, if that rig is.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map.
    *rigs : Rig
        One or more, such as fits with one light and with four.
    **where
        `ax`: one for the map, and one for each rig; `figsize`, `dpi`, `transparent`: see
        `envlights.plot`.

    Raises
    ------
    EnvLightsError
        If there is no rig.

    References
    ----------
    IEC 61966-2-1 (1999), the encoding of sRGB.

    Examples
    --------
    >>> import envlights as el
    >>> env = el.EnvMap(el.synthetic.hall(32).radiance)
    >>> figure = probes(env, el.fit(env, lights=1), el.fit(env, lights=2))
    >>> [axes.get_title() for axes in figure.axes]
    ['map', '1 light', '2 lights']
    """
    check_are_rigs(rigs)
    env = as_envmap(env)
    columns = 1 + len(rigs)
    page = open_page(where, grid(1, columns), (1.9 * columns, 2.2))
    shaded = shaded_ball(env, viewpoint(rigs[0]), rigs[0].floor)
    white = white_for(shaded.irradiance)
    lights = [shaded.irradiance, *(rig.probe(shaded.ball.normals) for rig in rigs)]
    titles = ["map", *(rig.lights.in_short() for rig in rigs)]
    for axes, title, light in zip(page.panels, titles, lights, strict=True):
        draw_probe(axes, shaded.ball, light, white)
        entitle(axes, title)
    return page.figure
