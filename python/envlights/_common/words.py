"""Numbers in texts, and texts in templates."""

from __future__ import annotations

import re


def percent(fraction: float | None, digits: int = 3) -> str:
    """Fraction in percent; numbers with more digits are whole, without an exponent."""
    if fraction is None:
        return "none"
    is_long = abs(100 * fraction) >= 10**digits - 0.5
    return f"{100 * fraction:.0f} %" if is_long else f"{100 * fraction:.{digits}g} %"


def degrees(angle: float | None) -> str:
    """Angle in degrees, with three digits."""
    return "none" if angle is None else f"{angle:.3g}°"


def quantity(number: int, noun: str) -> str:
    """Number with its noun: "1 light", "2 lights"."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def fill_template(template: str, **parts: str) -> str:
    """Template with placeholders replaced by texts: ``@UNITS@`` by `units`.

    The template is read once, so that a mark inside a text stays as it is.
    """
    return re.sub("@([A-Z_]+)@", lambda mark: parts[mark[1].lower()], template)
