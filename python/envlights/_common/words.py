"""Numbers in texts: percent, degrees and counted nouns."""

from __future__ import annotations


def percent(fraction: float | None) -> str:
    """Fraction in percent, with three digits."""
    return "none" if fraction is None else f"{100 * fraction:.3g} %"


def degrees(angle: float | None) -> str:
    """Angle in degrees, with three digits."""
    return "none" if angle is None else f"{angle:.3g}°"


def quantity(number: int, noun: str) -> str:
    """Number of things: "1 light", "2 lights"."""
    return f"{number} {noun}{'' if number == 1 else 's'}"
