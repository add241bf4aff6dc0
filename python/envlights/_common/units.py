"""Units of maps and lights: their own scale, or candela per square metre and lux."""

from __future__ import annotations

from envlights._common.check import check_choice

#: Units of an uncalibrated map.
OWN_SCALE = "the map's own scale"
#: Radiance with a luminance in cd/m2, and irradiance with a luminance in lux.
PHOTOMETRIC = "cd/m2"
#: Values of `units`, the default first.
UNITS = (OWN_SCALE, PHOTOMETRIC)


def checked_units(units: object) -> str:
    """Checked value of `units`; raises an error for unknown ones."""
    check_choice("units", units, UNITS)
    return str(units)


def in_lux(units: str) -> str:
    """Suffix " in lux" for a noun, or empty for uncalibrated maps."""
    return " in lux" if units == PHOTOMETRIC else ""


def in_nits(units: str) -> str:
    """Suffix " in cd/m2" for a noun, or empty for uncalibrated maps."""
    return f" in {PHOTOMETRIC}" if units == PHOTOMETRIC else ""


def statement(units: str) -> str:
    """Sentence for a file about the scale of its numbers."""
    if units == PHOTOMETRIC:
        return "the luminance of irradiance is in lux, that of radiance in cd/m2"
    return "the scale is that of the map, which is not calibrated"
