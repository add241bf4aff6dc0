"""Comparison of rigs, and of their errors by number of lights."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from envlights.environment.reading import AnyMap, as_envmap
from envlights.plot.curve import mark_percents
from envlights.plot.figure import check_are_rigs
from envlights.plot.ground import draw_small_ground, expose, working
from envlights.plot.markers import draw_lights, sizes_for
from envlights.plot.page import Placement, Unpack, grid, open_page, placed_picture
from envlights.plot.probe import (
    draw_difference_bar,
    draw_probes,
    error_limit,
    scale_for,
    shaded_ball,
    viewpoint,
)
from envlights.plot.wording import entitle
from envlights.rigs.rig import Rig, error_in_words


@placed_picture
def rigs_picture(env: AnyMap, *rigs: Rig, **where: Unpack[Placement]) -> Figure:
    """Draw several rigs of a map, in a row each: lights, probes and the difference.

    All probes are viewed from beside the brightest light of the first rig, and have one exposure.
    Discs of all rigs have one scale of areas, and differences one scale of colours: it is
    logarithmic (asinh) where some rig is 5 times as accurate as another.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map.
    *rigs : Rig
        One or more, such as fits with one light, with four, and with another ambient term.
    **where
        `ax`: axes, four for each rig; `figsize`, `dpi`, `transparent`: see `envlights.plot`.

    Examples
    --------
    >>> import envlights as el
    >>> env = el.EnvMap(el.synthetic.hall(32).radiance)
    >>> figure = rigs_picture(env, el.fit(env, lights=1), el.fit(env, lights=2))
    >>> [each.get_title().split(",")[0] for each in figure.axes[:8:4]]
    ['ambient + 1 light', 'ambient + 2 lights']
    """
    check_are_rigs(rigs)
    env = as_envmap(env)
    size = (13, 2.5 * len(rigs) + 0.3)
    page = open_page(where, grid(len(rigs), 4), size, width_ratios=(2.3, 1, 1, 1))
    rows = [page.panels[first : first + 4] for first in range(0, len(page.panels), 4)]
    ground, eye = expose(working(env)), viewpoint(rigs[0])
    shaded = {floor: shaded_ball(env, eye, floor) for floor in {rig.floor for rig in rigs}}
    scale = scale_for([error_limit(shaded[rig.floor], rig) for rig in rigs])
    sizes = sizes_for(rows[0][0], np.concatenate([rig.lights.fraction for rig in rigs]))
    for (on_map, *probes), rig in zip(rows, rigs, strict=True):
        draw_small_ground(on_map, ground.codes)
        draw_lights(on_map, rig.lights, sizes)
        entitle(on_map, rig.in_short(), "medium")
        drawn = draw_probes(probes, shaded[rig.floor], rig, scale)
    draw_difference_bar(page.figure, [row[3] for row in rows], drawn)
    return page.figure


@placed_picture
def error_picture(*rigs: Rig, **where: Unpack[Placement]) -> Figure:
    """Draw the error against the number of lights, from the reports of rigs.

    Points are numbers of lights in the search; a ring is the rig itself, with sizes.

    Parameters
    ----------
    *rigs : Rig
        One or more, such as ``el.fit(env, error=0.01)`` with several ambient terms.
    **where
        `ax`, `figsize`, `dpi` and `transparent`; see `envlights.plot`.

    Examples
    --------
    >>> import envlights as el
    >>> rig = el.fit(el.synthetic.hall(32).radiance, lights=3)
    >>> figure = error_picture(rig)
    >>> figure.axes[0].get_xlabel()
    'lights'
    """
    check_are_rigs(rigs)
    page = open_page(where, [[0]], (7, 4.4))
    (axes,) = page.panels
    for number, rig in enumerate(rigs):
        _draw_curve(axes, rig, f"C{number}")
    axes.set(xlabel="lights", ylabel="relative RMS error (%)", yscale="log")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    mark_percents(axes)
    axes.legend()
    return page.figure


def _draw_curve(axes: Axes, rig: Rig, colour: str) -> None:
    """Draw the errors of all numbers of lights in the search, and the error of the rig."""
    ambient = rig.report.ambient or "fixed"
    tried = {lights: 100 * error for lights, error in rig.report.search_errors.items() if error > 0}
    points = "points" if rig.report.sized_error is not None else "lights"
    label = f"ambient {ambient}: {points} in the search"
    axes.plot(list(tried), list(tried.values()), ".-", color=colour, label=label)
    sizes = " with sizes" if rig.lights.angular_radius.any() else ""
    label = f"the rig: {rig.lights.in_short()}{sizes}, {error_in_words(rig.error)}"
    error = 100 * (rig.error or 0) or float("nan")  # a logarithmic axis has no 0
    axes.plot([len(rig.lights)], [error], "o", ms=9, mfc="none", mec=colour, label=label)
