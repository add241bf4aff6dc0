"""`docs/benchmarks.md`, from the results alone."""

from itertools import product

import numpy as np
from curves.results import curves

_HEAD = """# Run time against error

`python -m benchmarks --out docs` measures everything on this page, and writes it. {machine}

Within a part all methods take turns in one process, warmed up. Times are medians over the rounds;
times and errors are geometric means over the cases. The spread is half the distance of the
quartiles over the median, at worst. Compare ratios: the times are those of this machine.
"""


def page(machine, parts, points):
    """The page; `parts` are the modules that were run, by name."""
    threads, cores = machine["threads"], machine["cores"]
    where = f"{machine['processor']}, {cores} cores, {threads} threads, {machine['maps']} maps"
    text = [_HEAD.format(machine=f"This is {where}, on {machine['date']}.")]
    for name, part in parts.items():
        found = [point for point in points if point.part == name]
        text += [
            f"\n## {part.TITLE}\n",
            f"{_first_lines(part)}\n",
            f"![{part.TITLE}](benchmarks/{name}.png)\n",
        ]
        text += _table(part.ERRORS, found)
        text += _losses(part, part.ERRORS, found) if part.ERRORS else _slopes(found)
    return "\n".join(text).rstrip() + "\n"


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
    shown = [method, f"{setting:g}", f"{1e3 * seconds:.3g} ms", f"{100 * spread:.0f} %"]
    return "| " + " | ".join([*shown, *(f"{value:.2g}" for value in values)]) + " |"


def _losses(part, errors, points):
    """A sentence for each error: which peers are faster and more accurate than ours, and where."""
    cases = len({point.case for point in points})
    text = []
    for error, label in errors.items():
        found = {}
        for our, their in product(points, repeat=2):
            if _is_beaten(part, error, our, their):
                found.setdefault((their.method, their.setting, our.method), set()).add(our.case)
        rows = [
            f"{their} ({setting:g}) against {our} on {len(on)} of {cases}"
            for (their, setting, our), on in sorted(found.items())
        ]
        said = "; ".join(rows) or "nowhere"
        text.append(f"\nFaster and more accurate than ours, {label}: {said}.")
    return text


def _is_beaten(part, error, our, their):
    """Whether `their` is faster and more accurate on the same case, with no more lights."""
    return (
        our.method in part.OURS
        and their.method not in part.OURS
        and our.case == their.case
        and part.are_comparable(our, their)
        and their.seconds < our.seconds
        and their.errors[error] < our.errors[error]
    )


def _slopes(points):
    """The exponent of each method between the two largest maps."""
    text = ["\nExponent of the run time in the number of pixels, between the two largest maps:"]
    for method in dict.fromkeys(point.method for point in points):
        (few, fast), (many, slow) = [(p.setting, p.seconds) for p in points if p.method == method][
            -2:
        ]
        text.append(f"{method} {np.log(slow / fast) / np.log(many / few):.2f};")
    return [" ".join(text).rstrip(";") + "."]
