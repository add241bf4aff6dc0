"""Table of a program's files, from the tables that the exporters use."""

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

import envlights as el
from envlights.export.units import UNITS


def vector(signs: tuple[int, ...]) -> str:
    """Axis of a program, such as +x, from its components."""
    (place,) = (index for index, sign in enumerate(signs) if sign)
    return f"{'+' if signs[place] > 0 else '−'}{'xyz'[place]}"


def facts(name: str) -> dict[str, str]:
    """Facts about a target by their titles."""
    target = next(target for target in el.export.TARGETS if target.name == name)
    matrix = el.export.AXES[name].matrix
    axes = (vector(tuple(row[ours] for row in matrix)) for ours in range(3))
    shows, units = target.shows, UNITS[name]
    light = {
        "spread": "lights every surface as a disc does",
        "soften": "softens shadows only",
        "none": "is not shown",
    }
    harmonics = {
        "exact": "as they are",
        "map": "a map, black where they are negative",
        "none": "their mean radiance",
    }
    most = [f"{shows.lights} lights"] * bool(shows.lights)
    most += [f"{shows.casters} shadows"] * bool(shows.casters)
    return {
        "file": ", ".join(f"`{suffix}`" for suffix in target.suffixes),
        "our +x, +y, +z": ", ".join(axes),
        "size of a light": light[shows.sizes],
        "harmonics": harmonics[shows.harmonics],
        "ambient light from above alone": "yes" if shows.floor else "no",
        "a map as surroundings": "yes" if shows.environment else "no",
        "at most": ", ".join(most) or "any number of lights",
        "a calibrated light is in": units.irradiance,
        "a calibrated map is in": units.radiance,
        "remark": shows.remark,
        "source": shows.source,
    }


class ProgramFacts(SphinxDirective):
    """Table of one program."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Rows of the table, as Markdown."""
        rows = [f"| {title} | {text} |" for title, text in facts(self.arguments[0]).items() if text]
        return self.parse_text_to_nodes("\n".join(["| | |", "|---|---|", *rows]))


def setup(app) -> dict[str, bool]:
    """Offer the directive."""
    app.add_directive("program-facts", ProgramFacts)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
