"""Curves of run time against error, in logarithms, with their names beside them; ours are thick."""

from itertools import pairwise, product

import matplotlib as mpl
import numpy as np
from curves.results import curves, setting_text
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

_WIDTH, _HEIGHT = 6.4, 4.8
#: Most levels of error for which a panel names the best method.
_LEVELS = 4
#: Of a point: where the text begins, and which of its sides that is.
_SIDES = [
    {
        "xytext": (9 * right, 9 * up),
        "textcoords": "offset points",
        "ha": {1: "left", 0: "center", -1: "right"}[right],
        "va": {1: "bottom", 0: "center", -1: "top"}[up],
    }
    for right, up in ((-1, -1), (-1, 0), (0, -1), (1, -1), (1, 0), (0, 1), (1, 1), (-1, 1))
]


def picture(part, points):
    """A panel for each error over the run time, and over what the settings count, if they do.

    An error that is a run time gets panels of its own, as their horizontal axis. Without errors,
    the run time over the setting, a panel for each case. The title of a panel names the fastest
    methods for an error.
    """
    panels = _panels(part, points)
    across = 2 if len(panels) == 4 else len(panels)
    down = len(panels) // across
    figure = Figure(figsize=(_WIDTH * across, _HEIGHT * down), layout="constrained")
    every = figure.subplots(down, across, squeeze=False).ravel()
    colours = _colours(point.method for point in points)
    for axes, (across, up, lines) in zip(every, panels, strict=True):
        for method, rows in lines.items():
            _line(axes, rows, _style(colours[method], method in part.OURS), method in part.OURS)
        axes.set(xscale="log", yscale="log", xlabel=across, ylabel=up)
        if part.ERRORS:
            axes.set_title(_best(lines, across), fontsize=8.5, loc="left")
        for axis in (axes.xaxis, axes.yaxis):
            _number(axis)
        axes.margins(0.12)
        axes.grid(which="major", alpha=0.25)
    figure.suptitle(part.TITLE + part.READ)
    figure.draw_without_rendering()
    for axes, (_, _, lines) in zip(every, panels, strict=True):
        _name(axes, lines, colours, part.OURS)
    return figure


def _panels(part, points):
    """Labels of the axes, and for each method its points (x, y, text)."""
    if not part.ERRORS:
        panels = {}
        for point in points:
            lines = panels.setdefault(point.case, {}).setdefault(point.method, [])
            lines.append((point.setting, 1e3 * point.seconds, ""))
        return [(f"number of {case}", "milliseconds", lines) for case, lines in panels.items()]
    panels, timed = [], getattr(part, "TIMED", ())
    for error, label in part.ERRORS.items():
        if error in timed:
            continue
        found = curves(points, error)
        over_time = {
            method: [
                (1e3 * seconds, value, setting_text(setting)) for setting, seconds, value, _ in rows
            ]
            for method, rows in found.items()
            if method not in getattr(part, "UNDRAWN", ())
        }
        panels.append((getattr(part, "CALL", "milliseconds"), label, over_time))
        for other in timed:
            times = curves(points, other)
            over_other = {
                method: [
                    (time[2], value, setting_text(setting))
                    for (setting, _, value, _), time in zip(rows, times[method], strict=True)
                ]
                for method, rows in found.items()
            }
            panels.append((part.ERRORS[other], label, over_other))
        if part.COUNTED:
            over_count = {
                method: [
                    (setting, value, setting_text(setting))
                    for setting, _, value, _ in rows
                    if setting
                ]
                for method, rows in found.items()
                if method not in part.UNCOUNTED
            }
            panels.append((part.COUNTED, label, over_count))
    return panels


def _best(lines, across):
    """Method that reaches each of some errors at the least value of the axis."""
    rows = [(*row, method) for method, rows in lines.items() for row in rows]
    low, high = min(row[1] for row in rows), max(row[1] for row in rows)
    # The wider the range, the fewer the steps.
    digits = (1,) if high > 1e3 * low else (1, 2, 5) if high > 10 * low else (1, 1.5, 2, 3, 5, 7)
    steps = [digit * 10.0**power for power, digit in product(range(-9, 2), digits)]
    levels = [step for step in steps if low < step < high]
    chosen = levels[:: max(1, -(-len(levels) // _LEVELS))][:_LEVELS]
    found = []
    for level in reversed(chosen):
        _, _, setting, method = min(row for row in rows if row[1] <= level)
        found.append(f"{level:.2g}: {method}" + (f" ({setting})" if setting else ""))
    two_lines = (";  ".join(some) for some in (found[:2], found[2:]))
    return f"least {across} to an error of\n" + "\n".join(two_lines)


def _line(axes, rows, style, is_ours):
    axes.plot([row[0] for row in rows], [row[1] for row in rows], **style)
    # Of others, the ends are enough to read the line.
    for i, (x, y, beside) in enumerate(rows):
        if len(rows) > 1 and (is_ours or i in (0, len(rows) - 1)):
            where = {"xytext": (3, 3), "textcoords": "offset points"}
            axes.annotate(beside, (x, y), **where, fontsize=7, color=style["color"])


def _number(axis):
    """Plain numbers at decades, and between them where there are few."""
    low, high = axis.get_view_interval()
    plain = FuncFormatter(lambda value, _: f"{value:,.10g}")
    if high < 50 * low:
        axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.set_major_formatter(plain)
    axis.set_minor_formatter(NullFormatter())


def _name(axes, lines, colours, ours):
    """Write the name of each line where it covers the least: beside one of its points."""
    drawn = np.concatenate([_dots(axes, rows) for rows in lines.values()])
    inside, taken = axes.get_window_extent(), []
    for method in sorted(lines, key=lambda method: method not in ours):
        weight = "bold" if method in ours else "normal"
        font = {"fontsize": 8.5, "color": colours[method], "weight": weight, "zorder": 4}
        every = product(lines[method], _SIDES)
        places = [axes.annotate(method, row[:2], **side, **font) for row, side in every]
        boxes = [place.get_window_extent() for place in places]
        covered = [_overlap(box, drawn, taken, inside) for box in boxes]
        best = int(np.argmin(covered))
        taken.append(boxes[best])
        for place in places[:best] + places[best + 1 :]:
            place.remove()


def _dots(axes, rows):
    """Places along a line, in pixels, a few pixels apart."""
    corners = axes.transData.transform([row[:2] for row in rows])
    between = [np.linspace(a, b, 30) for a, b in pairwise(corners)]
    return np.concatenate([corners, *between])


def _overlap(box, drawn, taken, inside):
    """Overlap of a text with lines and other texts; leaving the frame counts most."""
    within = ((drawn > box.p0 - 2) & (drawn < box.p1 + 2)).all(axis=1)
    outside = not all(inside.contains(*corner) for corner in box.corners())
    return within.sum() + 20 * sum(box.overlaps(other) for other in taken) + 100 * outside


def _colours(methods):
    """A colour for each method, the same in all panels."""
    every = [*mpl.colormaps["tab10"].colors, "black", "darkgoldenrod"]
    return {method: every[i % len(every)] for i, method in enumerate(dict.fromkeys(methods))}


def _style(colour, is_ours):
    width, dash = (2.8, "-") if is_ours else (1.0, "--")
    line = {"color": colour, "linewidth": width, "linestyle": dash, "zorder": 3 if is_ours else 2}
    return line | {"marker": "o", "markersize": 5.5 if is_ours else 3.5}
