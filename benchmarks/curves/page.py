"""`docs/lab/benchmarks.md`, from the results alone."""

import numpy as np
from curves.results import curves, setting_text

_HEAD = """# Run time against error

`python -m benchmarks --out docs/lab` measures this page and writes it; with the names of parts, it
measures those again. Each part names its machine. The last table compares the page with a second
run.

In a part all methods alternate in one warm process, round by round; a round repeats calls that take
less than 3 ms. New processes repeat all parts, because memory and other load differ between
processes. Times are medians over the processes of the medians over their rounds; on one thread they
are processor times. Times and errors are geometric means over the cases. The spread is half the
interval of 99.9 % of the mean over the processes, by Student's t, of the median case. Compare
ratios, not times: the times are those of one machine.
"""


def page(found):
    """The page; `found` has for each part its name, module, machine and rows."""
    text = [_HEAD]
    for name, part, machine, rows in found:
        text += [f"\n## {part.TITLE}\n", f"{_first_lines(part)}\n", f"{_measured_on(machine)}\n"]
        text += _table_of_rows(rows) if is_table(part) else _curves(name, part, rows)
    return "\n".join(text).rstrip() + "\n"


def is_table(part):
    """True for a part with rows instead of curves."""
    return not hasattr(part, "points")


def _measured_on(machine):
    threads, cores = machine["threads"], machine["cores"]
    often = machine["processes"]
    few = "; a quick run with few rounds" if machine["quick"] else ""
    load = f"; load {machine['load']} at the start" if machine.get("load") else ""
    return (
        f"Measured on {machine['date']}: {machine['processor']}, {threads} of {cores} cores;"
        f" {often} process{'es' if often > 1 else ''}{load}{few}."
    )


def _curves(name, part, points):
    """The picture, the table, and what is lost."""
    cases = len({point.case for point in points})
    text = [f"![{part.TITLE}](benchmarks/{name}.png)\n"]
    if part.ERRORS:
        text += [f"{cases} case{'s' if cases != 1 else ''}.\n", *_table(part.ERRORS, points)]
    return text + (_losses(part, part.ERRORS, points) if part.ERRORS else _slopes(part, points))


def _table_of_rows(rows):
    """A table whose columns are the keys of the first row."""
    if not rows:
        return ["Nothing to measure here."]
    head = list(rows[0])
    text = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return text + ["| " + " | ".join(_cell(row[key]) for key in head) + " |" for row in rows]


def _cell(value):
    return f"{value:.2g}" if isinstance(value, float) else str(value)


def _first_lines(part):
    return " ".join(part.__doc__.split())


def _table(errors, points):
    """A row for each method and setting."""
    head = ["method", "setting", "time", "spread", *errors.values()]
    rows = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    by_error = {error: curves(points, error) for error in errors}
    first = next(iter(by_error.values()))
    for method, settings in first.items():
        for index, (setting, seconds, _, spread) in enumerate(settings):
            values = [by_error[error][method][index][2] for error in errors]
            rows.append(_row(method, setting, seconds, spread, values))
    return rows


def _row(method, setting, seconds, spread, values):
    milliseconds = f"{1e3 * seconds:,.0f}" if seconds >= 1 else f"{1e3 * seconds:.3g}"
    share = "" if spread is None else f"{100 * spread:.0f} %"
    shown = [method, setting_text(setting), f"{milliseconds} ms", share]
    return "| " + " | ".join([*shown, *(f"{value:.2g}" for value in values)]) + " |"


def _losses(part, errors, points):
    """Two sentences for each error: peers that beat ours, and peers that ours never match."""
    cases = len({point.case for point in points})
    text = []
    for error, label in errors.items():
        beaten, unbeaten = {}, {}
        ours = [point for point in points if point.method in part.OURS]
        for their in (point for point in points if point.method not in part.OURS):
            rivals = [our for our in ours if our.case == their.case]
            name = _label(their)
            for our in rivals:
                if part.are_comparable(our, their) and _is_better(their, our, error):
                    key = f"{name} against {_label(our)}"
                    beaten.setdefault(key, set()).add(our.case)
            if not any(_is_matched(our, their, error) for our in rivals):
                unbeaten.setdefault(name, set()).add(their.case)
        text.append(
            f"\nFaster than a setting of ours and with a smaller {label} (number of cases):"
            f" {_listing(beaten, cases)}."
        )
        text.append(
            f"\nNot beaten by a setting of ours in both time and {label} (number of cases):"
            f" {_listing(unbeaten, cases)}."
        )
    return text


def _label(point):
    """A method, with its setting if it has one."""
    return point.method + ("" if point.setting is None else f" ({setting_text(point.setting)})")


def _listing(found, cases):
    rows = [f"{name} on {len(on)} of {cases}" for name, on in sorted(found.items())]
    return "; ".join(rows) or "none"


def _is_better(one, other, error):
    """True if a point is faster and more accurate than another."""
    return one.seconds < other.seconds and one.errors[error] < other.errors[error]


def _is_matched(our, their, error):
    """True if ours is faster and at least as accurate; ties are common on easy maps."""
    return our.seconds < their.seconds and our.errors[error] <= their.errors[error]


def _slopes(part, points):
    """Tables of run time by size with exponents, and of memory if it was measured."""
    text = []
    for case in dict.fromkeys(point.case for point in points):
        found = [point for point in points if point.case == case]
        sizes = sorted({point.setting for point in found})
        text += [f"\nRun time in milliseconds, by the number of {case}:\n"]
        head = ["method", *(setting_text(size) for size in sizes), "exponent"]
        is_bound = case == "pixels"
        head += ["of the bandwidth"] if is_bound else []
        text += ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
        for method in dict.fromkeys(point.method for point in found):
            seconds = {p.setting: p.seconds for p in found if p.method == method}
            cells = [method, *(f"{1e3 * seconds[size]:.3g}" for size in sizes)]
            cells.append(f"{_slope(seconds):.2f}")
            cells += [f"{100 * _one_pass(found) / seconds[sizes[-1]]:.0f} %"] if is_bound else []
            text.append("| " + " | ".join(cells) + " |")
    return [*text, *_memory([point for point in points if point.errors]), "\n" + part.SAID]


def _slope(values):
    """Exponent of a power law: a line through the three largest."""
    return np.polyfit(*np.log(sorted(values.items())[-3:]).T, 1)[0]


def _one_pass(points):
    """Seconds of the pass over the largest map that sets the bandwidth."""
    return max((p.setting, p.seconds) for p in points if p.method == "array.max()")[1]


def _memory(points):
    """Peak megabytes by the number of pixels."""
    if not points:
        return []
    sizes = sorted({point.setting for point in points})
    head = ["method", *(setting_text(size) for size in sizes), "bytes a pixel"]
    text = ["\nPeak memory in megabytes beyond the map, by the number of pixels:\n"]
    text += ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for method in dict.fromkeys(point.method for point in points):
        found = {p.setting: p.errors["memory"] for p in points if p.method == method}
        slope = 2**20 * np.polyfit(list(found), list(found.values()), 1)[0]
        slope = slope if slope > 1e-6 else 0.0  # rounding
        cells = [method, *(f"{found[size]:.3g}" for size in sizes), f"{slope:.2g}"]
        text.append("| " + " | ".join(cells) + " |")
    return text
