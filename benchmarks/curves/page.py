"""`docs/benchmarks.md`, from the results alone."""

import numpy as np
from curves.results import curves, told

_HEAD = """# Run time against error

`python -m benchmarks --out docs` measures everything on this page, and writes it; with the names of
parts, it measures those anew. Each part says on what machine it was measured.

Within a part all methods take turns in one process, warmed up. Times are medians over the rounds;
times and errors are geometric means over the cases. The spread is half the distance of the
quartiles over the median, at worst. Compare ratios: the times are those of one machine.
"""


def page(found):
    """The page; `found` has for each part its name, module, machine and rows."""
    text = [_HEAD]
    for name, part, machine, rows in found:
        text += [f"\n## {part.TITLE}\n", f"{_first_lines(part)}\n", f"{_measured_on(machine)}\n"]
        text += _table_of_rows(rows) if is_table(part) else _curves(name, part, rows)
    return "\n".join(text).rstrip() + "\n"


def is_table(part):
    """Whether a part has rows in place of curves."""
    return hasattr(part, "rows")


def _measured_on(machine):
    threads, cores = machine["threads"], machine["cores"]
    few = "; a quick run, with few rounds" if machine["quick"] else ""
    return (
        f"Measured on {machine['date']}: {machine['processor']}, {cores} cores, of which"
        f" {threads} {'was' if threads == 1 else 'were'} used{few}."
    )


def _curves(name, part, points):
    """The picture, the table, and what is lost."""
    cases = len({point.case for point in points})
    text = [
        f"![{part.TITLE}](benchmarks/{name}.png)\n",
        f"{cases} case{'s' if cases != 1 else ''}.\n",
        *_table(part.ERRORS, points),
    ]
    return text + (_losses(part, part.ERRORS, points) if part.ERRORS else _slopes(points))


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
    if not errors:
        return [*rows, *(_row(p.method, p.setting, p.seconds, p.spread, []) for p in points)]
    first = next(iter(by_error.values()))
    for method, settings in first.items():
        for index, (setting, seconds, _, spread) in enumerate(settings):
            values = [by_error[error][method][index][2] for error in errors]
            rows.append(_row(method, setting, seconds, spread, values))
    return rows


def _row(method, setting, seconds, spread, values):
    milliseconds = f"{1e3 * seconds:,.0f}" if seconds >= 1 else f"{1e3 * seconds:.3g}"
    shown = [method, told(setting), f"{milliseconds} ms", f"{100 * spread:.0f} %"]
    return "| " + " | ".join([*shown, *(f"{value:.2g}" for value in values)]) + " |"


def _losses(part, errors, points):
    """Two sentences for each error: which peers beat ours, and which none of ours matches."""
    cases = len({point.case for point in points})
    text = []
    for error, label in errors.items():
        beaten, unbeaten = {}, {}
        ours = [point for point in points if point.method in part.OURS]
        for their in (point for point in points if point.method not in part.OURS):
            rivals = [our for our in ours if our.case == their.case]
            name = _named(their)
            for our in rivals:
                if part.are_comparable(our, their) and _is_better(their, our, error):
                    key = f"{name} against {_named(our)}"
                    beaten.setdefault(key, set()).add(our.case)
            if not any(_is_matched(our, their, error) for our in rivals):
                unbeaten.setdefault(name, set()).add(their.case)
        text.append(f"\nFaster and more accurate than ours, {label}: {_said(beaten, cases)}.")
        text.append(
            f"\nPeers that none of ours matches in less time, {label}: {_said(unbeaten, cases)}."
        )
    return text


def _named(point):
    """A method, with its setting if it has one."""
    return point.method + ("" if point.setting is None else f" ({told(point.setting)})")


def _said(found, cases):
    rows = [f"{name} on {len(on)} of {cases}" for name, on in sorted(found.items())]
    return "; ".join(rows) or "none"


def _is_better(one, other, error):
    """Whether a point is faster and more accurate than another."""
    return one.seconds < other.seconds and one.errors[error] < other.errors[error]


def _is_matched(our, their, error):
    """Whether ours is faster and no less accurate: many find all lights of an easy map."""
    return our.seconds < their.seconds and our.errors[error] <= their.errors[error]


def _slopes(points):
    """Slopes over the larger maps, and how near the largest comes to the measured bandwidth."""
    text = [
        "\nExponent of the run time in the number of pixels, a line through the three largest maps;"
        " in brackets the share of the bandwidth that `array.max()` has on the largest:"
    ]
    seconds = {}
    for point in points:
        seconds.setdefault(point.method, []).append((point.setting, point.seconds))
    _, one_pass = seconds["array.max()"][-1]
    for method, sizes in seconds.items():
        slope, _ = np.polyfit(*np.log(sizes[-3:]).T, 1)
        text.append(f"{method} {slope:.2f} ({100 * one_pass / sizes[-1][1]:.0f} %);")
    return [" ".join(text).rstrip(";") + "."]
