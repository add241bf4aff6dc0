"""Tables of the programs, from the rows that the exporters use."""

from collections.abc import Callable

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

from envlights.export import TARGETS, Axes
from envlights.export.targets import target_named

#: Title of a fact.
VERSIONS = "versions that were checked"


def facts(name: str) -> dict[str, str]:
    """Facts about a target by their titles."""
    target = target_named(name)
    shows, units = target.shows, target.units
    light = {
        "spread": "soft light and shadows",
        "soften": "soft shadows only",
        "none": "not shown",
    }
    harmonics = {
        "exact": "as they are",
        "map": "as a map, 0 where negative",
        "none": "their mean",
    }
    most = [f"{shows.lights} lights"] * bool(shows.lights)
    most += [f"{shows.casters} shadows"] * bool(shows.casters)
    return {
        "file": ", ".join(f"`{suffix}`" for suffix in target.suffixes),
        "our +x, +y, +z": ", ".join(target.axes.names),
        "size of a light": light[shows.sizes],
        "harmonics": harmonics[shows.harmonics],
        "ambient light from above alone": "yes" if shows.floor else "no",
        "a map as surroundings": "yes" if shows.environment else "no",
        "at most": ", ".join(most) or "any number",
        "a calibrated light is in": units.irradiance,
        "a calibrated map is in": units.radiance,
        VERSIONS: target.versions or "formulas of its documentation",
        "remark": shows.remark,
        "source": shows.source,
    }


#: Titles of the tables of all programs, of axes and of units.
PROGRAMS = ("program", "file", "size of a light", "harmonics", "map", "at most", "checked versions")
AXES = ("target", "our +x", "our +y", "our +z, the centre of a map", "matrix, row by row", "handed")
UNITS = ("target", "lights", "ambient term and maps", "1 lux becomes", "source")


def programs_rows() -> list[tuple[str, ...]]:
    """Capabilities of each program, below their titles."""
    shown = [each for each in TARGETS if each.name not in {"json", "csv"}]
    return [PROGRAMS, *(_capabilities(each.name, each.title) for each in shown)]


def _capabilities(name: str, title: str) -> tuple[str, ...]:
    """Row of one program."""
    row, keys = facts(name), ("file", "size of a light", "harmonics", "a map as surroundings")
    return f"[{title}]({name}.md)", *(row[key] for key in (*keys, "at most")), row[VERSIONS]


def axes_rows() -> list[tuple[str, ...]]:
    """Axes of each target, below their titles."""
    rows = [(f"`{each.name}`", *each.axes.names, *_of_axes(each.axes)) for each in TARGETS]
    return [(*AXES, "our map in the target"), *rows]


def _of_axes(axes: Axes) -> tuple[str, ...]:
    """Matrix, handedness, and the place of an unrotated map."""
    matrix = " ".join(f"({' '.join(map(str, row))})" for row in axes.matrix)
    if axes.map is None:
        return matrix, axes.hand, "–"
    centre = Axes(axes.map).names[2]
    is_same = axes.map == axes.matrix
    return matrix, axes.hand, "agrees" if is_same else f"rotate it: its centre is along {centre}"


def units_rows() -> list[tuple[str, ...]]:
    """Units of each target, below their titles."""
    rows = [
        (
            each.title,
            each.units.irradiance,
            each.units.radiance,
            "1" if each.units.lumens == 1 else f"1 / {each.units.lumens:g}",
            each.units.source,
        )
        for each in TARGETS
    ]
    return [UNITS, *rows]


def program_rows(name: str) -> list[tuple[str, ...]]:
    """Facts about a target, below empty titles."""
    return [("", ""), *(row for row in facts(name).items() if row[1])]


#: Rows of the table of each directive.
TABLES: dict[str, Callable[..., list[tuple[str, ...]]]] = {
    "programs-table": programs_rows,
    "program-facts": program_rows,
    "axes-table": axes_rows,
    "units-table": units_rows,
}


class Table(SphinxDirective):
    """Table from the rows of the targets."""

    optional_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Rows of the table, as Markdown."""
        titles, *rows = TABLES[self.name](*self.arguments)
        lines = [titles, ["---"] * len(titles), *rows]
        return self.parse_text_to_nodes("\n".join(f"| {' | '.join(line)} |" for line in lines))


def setup(app) -> dict[str, bool]:
    """Offer the directives."""
    for name in TABLES:
        app.add_directive(name, Table)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
