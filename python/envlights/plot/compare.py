"""Comparison of rigs, and the error against the number of lights."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, MaxNLocator

from envlights.envmap import AnyMap, as_envmap
from envlights.plot.figure import Picture, check_are_rigs
from envlights.plot.ground import EXTENT, draw_small_ground, expose, working
from envlights.plot.markers import draw_lights
from envlights.plot.probe import draw_probes, shaded_ball, viewpoint
from envlights.rig import Rig

#: Smallest number of points on the page for a degree of a map, in a row of a picture.
_POINTS = 0.95


def rigs_picture(env: AnyMap, *rigs: Rig) -> Picture:
    """Draw several rigs of one map, a row for each: lights, probes and the difference.

    All probes are viewed from beside the brightest light of the first rig.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map.
    *rigs : Rig
        One or more, such as fits with one light, with four, and with another ambient term.

    Returns
    -------
    matplotlib.figure.Figure

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
    figure = Picture(figsize=(13, 2.9 * len(rigs) + 0.3))
    rows = figure.subplots(len(rigs), 4, width_ratios=(2.3, 1, 1, 1.25), squeeze=False)
    ground, eye = expose(working(env)), viewpoint(rigs[0])
    shaded = {floor: shaded_ball(env, eye, floor) for floor in {rig.floor for rig in rigs}}
    for (on_map, *probes), rig in zip(rows, rigs, strict=True):
        draw_small_ground(on_map, ground.codes)
        draw_lights(on_map, rig.lights, _POINTS)
        on_map.set(xlim=EXTENT[:2], ylim=EXTENT[2:], title=rig.in_short())
        draw_probes(figure, probes, shaded[rig.floor], rig)
        for axes in probes:
            axes.title.set_fontsize("small")
    return figure


def error_picture(*rigs: Rig) -> Picture:
    """Draw the error against the number of lights, from the reports of rigs.

    Points are numbers of lights in the search; a ring is the rig itself, with sizes.

    Parameters
    ----------
    *rigs : Rig
        One or more, such as ``el.fit(env, error=0.01)`` with several ambient terms.

    Returns
    -------
    matplotlib.figure.Figure

    Examples
    --------
    >>> import envlights as el
    >>> rig = el.fit(el.synthetic.hall(32).radiance, lights=3)
    >>> figure = error_picture(rig)
    >>> figure.axes[0].get_xlabel()
    'lights'
    """
    check_are_rigs(rigs)
    figure = Picture(figsize=(7, 4.4))
    axes = figure.add_subplot()
    for number, rig in enumerate(rigs):
        _draw_curve(axes, rig, f"C{number}")
    axes.set(xlabel="lights", ylabel="relative RMS error (%)", yscale="log")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.grid(which="both", alpha=0.25)
    axes.legend()
    return figure


def _draw_curve(axes: Axes, rig: Rig, colour: str) -> None:
    """Errors of all numbers of lights in the search, and of the rig."""
    ambient = rig.report.ambient or "fixed"
    tried = {lights: 100 * error for lights, error in rig.report.search_errors.items() if error > 0}
    points = "points" if rig.report.sized_error is not None else "lights"
    label = f"ambient {ambient}: {points} in the search"
    axes.plot(list(tried), list(tried.values()), ".-", color=colour, label=label)
    sizes = " with sizes" if rig.lights.angular_radius.any() else ""
    label = f"the rig: {rig.lights.in_short()}{sizes}, {100 * rig.error:.3g} %"
    error = 100 * rig.error or float("nan")  # a logarithmic axis has no 0
    axes.plot([len(rig.lights)], [error], "o", ms=9, mfc="none", mec=colour, label=label)
