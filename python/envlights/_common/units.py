"""Units of maps and lights: their own scale, or candela per square metre and lux."""

from __future__ import annotations

from envlights._common.check import check_choice

#: Scale of a map that nobody has calibrated.
OWN_SCALE = "the map's own scale"
#: Radiance with a luminance in cd/m2, and irradiance with a luminance in lux.
PHOTOMETRIC = "cd/m2"
#: Values of `units`, the default first.
UNITS = (OWN_SCALE, PHOTOMETRIC)


def checked_units(units: object) -> str:
    """One of `UNITS`, or a refusal."""
    check_choice("units", units, UNITS)
    return str(units)


def in_lux(units: str) -> str:
    """Unit of irradiance after a noun, " in lux"; empty for a scale without a name."""
    return " in lux" if units == PHOTOMETRIC else ""


def in_nits(units: str) -> str:
    """Unit of radiance after a noun, " in cd/m2"; empty for a scale without a name."""
    return f" in {PHOTOMETRIC}" if units == PHOTOMETRIC else ""


def statement(units: str) -> str:
    """Sentence of a file on the scale of its numbers."""
    if units == PHOTOMETRIC:
        return "the luminance of irradiance is in lux, that of radiance in cd/m2"
    return "the scale is that of the map, which is not calibrated"
