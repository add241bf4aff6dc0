"""Units of a target: the only place where lux and cd/m2 are converted.

A calibrated map has RGB whose luminance (Rec.709) is in cd/m2, and its lights have irradiance whose
luminance is in lux. Programs that count in W/m2 have a convention for the lumens in a watt. The
numbers of a map that is not calibrated are written as they are.
"""

from __future__ import annotations

from typing import NamedTuple

from envlights._common.units import PHOTOMETRIC, statement


class TargetUnits(NamedTuple):
    """Units of the numbers in a target's file."""

    source: str
    """Document that states the units."""

    irradiance: str = "lux"
    """Unit of the irradiance of a light."""

    radiance: str = "cd/m2"
    """Unit of the radiance of an ambient term or a map."""

    lumens: float = 1.0
    """Lumens per unit of flux in the target; values in lux and cd/m2 are divided by it."""

    def factor_of(self, units: str) -> float:
        """Factor on all values of a map in `units`."""
        return 1.0 / self.lumens if units == PHOTOMETRIC else 1.0

    def in_short(self) -> str:
        """Text for the table of targets."""
        return f"{self.irradiance} and {self.radiance} of a calibrated map"

    def statement(self, units: str) -> str:
        """Sentence for the file about a map in `units`."""
        if units != PHOTOMETRIC:
            return statement(units)
        said = f"irradiance is in {self.irradiance}, radiance in {self.radiance}"
        if self.lumens == 1:
            return said
        return f"{said}; 1 W is {self.lumens:g} lm ({self.source})"
