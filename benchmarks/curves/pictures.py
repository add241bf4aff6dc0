"""Curves of run time against error, in logarithms; ours are drawn thick."""

import matplotlib as mpl
from curves.results import curves, told
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

_WIDTH, _HEIGHT = 5.6, 4.6


def picture(part, points):
    """A panel for each error over the run time, and over what the settings count, if they do.

    Without errors, the run time over the setting, a panel for each case.
    """
    panels = _panels(part, points)
    across = 2 if len(panels) == 4 else len(panels)
    down = len(panels) // across
    figure = Figure(figsize=(_WIDTH * across + 1.6, _HEIGHT * down), layout="constrained")
    every = figure.subplots(down, across, squeeze=False).ravel()
    colours = _colours(point.method for point in points)
    for axes, (across, up, lines) in zip(every, panels, strict=True):
        for method, rows in lines.items():
            _line(axes, rows, _style(colours[method], method in part.OURS), method)
        axes.set(xscale="log", yscale="log", xlabel=across, ylabel=up)
        for axis in (axes.xaxis, axes.yaxis):
            low, high = axis.get_view_interval()
            # Within a decade there may be no other numbers.
            if high > 10 * low:
                axis.set_minor_formatter(NullFormatter())
        axes.grid(which="both", alpha=0.2)
    # A method may be in some panels only.
    handles = [axes.get_legend_handles_labels() for axes in every]
    named = {
        name: line for lines, names in handles for line, name in zip(lines, names, strict=True)
    }
    figure.legend(named.values(), named.keys(), fontsize=8, loc="outside right center")
    figure.suptitle(part.TITLE + part.READ)
    return figure


def _panels(part, points):
    """Labels of the axes, and by method rows of x, y and what stands beside the point."""
    if not part.ERRORS:
        panels = {}
        for point in points:
            lines = panels.setdefault(point.case, {}).setdefault(point.method, [])
            lines.append((point.setting, 1e3 * point.seconds, ""))
        return [(case, "milliseconds", lines) for case, lines in panels.items()]
    panels = []
    for error, label in part.ERRORS.items():
        found = curves(points, error)
        over_time = {
            method: [(1e3 * seconds, value, told(setting)) for setting, seconds, value, _ in rows]
            for method, rows in found.items()
        }
        panels.append(("milliseconds", label, over_time))
        if part.COUNTED:
            over_count = {
                method: [(setting, value, "") for setting, _, value, _ in rows if setting > 0]
                for method, rows in found.items()
                if method not in part.UNCOUNTED
            }
            panels.append((part.COUNTED, label, over_count))
    return panels


def _line(axes, rows, style, label):
    axes.plot([row[0] for row in rows], [row[1] for row in rows], **style, label=label)
    for x, y, beside in rows:
        if len(rows) > 1:
            where = {"xytext": (3, 3), "textcoords": "offset points"}
            axes.annotate(beside, (x, y), **where, fontsize=7, color=style["color"])


def _colours(methods):
    """A colour for each method, the same in all panels."""
    every = [*mpl.colormaps["tab10"].colors, "black", "gold"]
    return {method: every[i % len(every)] for i, method in enumerate(dict.fromkeys(methods))}


def _style(colour, is_ours):
    width, dash = (2.5, "-") if is_ours else (1.2, "--")
    above = 3 if is_ours else 2
    line = {"color": colour, "linewidth": width, "linestyle": dash, "zorder": above}
    return line | {"marker": "o", "markersize": 5 if is_ours else 4}
