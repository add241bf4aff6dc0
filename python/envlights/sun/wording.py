"""Notes on a sun: a guess is called a guess."""

from __future__ import annotations

from envlights.sun.result import Sun


def of_sun(sun: Sun, measured: str) -> str:
    """Note on the light of a sun, whose irradiance may be `measured`."""
    moon = " (or moon, which a picture cannot tell)" if sun.points else ""
    measures = measured or _of_irradiance(sun)
    return f"{sun.in_short()}{moon}: {_of_direction(sun)}; {measures}"


def _of_direction(sun: Sun) -> str:
    if "map" in sun.evidence:
        return "direction measured in the map"
    if not sun.evidence or "given" in sun.evidence:
        return "direction as given"
    return f"the direction is a guess, by {' and '.join(sun.evidence)}"


def _of_irradiance(sun: Sun) -> str:
    if "map" in sun.evidence:
        return "irradiance measured in the map"
    low, high = sun.interval
    if low == high:
        return "irradiance as given"
    return f"the irradiance is a guess, in two of three maps true times {low:.2g} to {high:.2g}"


#: Note on a repair of a map that holds its own sun.
HOLDS_SUN = "no sun was added, because the map is not clipped and holds its own"


def without_sun(sun: Sun) -> str:
    """Note on a map for which no sun was added."""
    if sun.answer == "sun":
        return "no sun was added, because it is not the brightest light of the map; use `split`"
    why = f": {sun.notes[0]}" if sun.notes else ""
    hint = "; give its direction to add it" if sun.answer == "perhaps" else ""
    return f"no sun was added, because the answer is {sun.answer!r} ({sun.in_short()}){why}{hint}"
