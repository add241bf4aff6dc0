"""Notes that say whether the direction and irradiance of a sun are measured, given or guessed."""

from __future__ import annotations


def of_light(sun: str, evidence: tuple[str, ...], irradiance: str) -> str:
    """Note on a sun as a light; `sun` and `irradiance` are the texts to combine."""
    return f"{sun}: {_of_direction(evidence)}; {irradiance}"


def _of_direction(evidence: tuple[str, ...]) -> str:
    if "map" in evidence:
        return "direction measured in the map"
    if not evidence or "given" in evidence:
        return "direction as given"
    return f"the direction is a guess, by {' and '.join(evidence)}"


def of_irradiance(evidence: tuple[str, ...], interval: tuple[float, float]) -> str:
    """Text on the source of the irradiance of a sun, and its interval."""
    if "map" in evidence:
        return "irradiance measured in the map"
    low, high = interval
    if low == high:
        return "irradiance as given"
    return f"the irradiance is a guess, in two of three maps true times {low:.2g} to {high:.2g}"


#: Note on the repair of a map that contains its own sun.
HOLDS_SUN = "no sun was added, because the map is not clipped and holds its own"
