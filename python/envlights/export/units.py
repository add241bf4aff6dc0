"""Units of each target: the one place where numbers in lux and cd/m2 are converted.

A calibrated map has RGB whose luminance (Rec.709) is in cd/m2, and its lights have irradiance whose
luminance is in lux. Programs that count in W/m2 have a convention for the lumens in a watt. The
numbers of a map that is not calibrated are written as they are.
"""

from __future__ import annotations

from typing import NamedTuple

from envlights._common.units import PHOTOMETRIC, statement

#: Lumens per watt: the maximum of the photopic eye, 683 (SI), and that of white light in Radiance.
_SI, _RADIANCE = 683.0, 179.0


class TargetUnits(NamedTuple):
    """Units of the numbers in the file of a target."""

    lumens: float
    """Lumens in the target's unit of flux: numbers in lux and cd/m2 are divided by it."""

    irradiance: str
    """Unit of the irradiance of a light."""

    radiance: str
    """Unit of the radiance of an ambient term or a map."""

    source: str
    """Document that says so."""

    @property
    def factor(self) -> float:
        """Number in the file for 1 lux or 1 cd/m2."""
        return 1.0 / self.lumens

    def in_short(self) -> str:
        """Words for the table of targets."""
        return f"{self.irradiance} and {self.radiance} of a calibrated map"

    def statement(self, units: str) -> str:
        """Sentence for the file of a map in `units`."""
        if units != PHOTOMETRIC:
            return statement(units)
        said = f"irradiance is in {self.irradiance}, radiance in {self.radiance}"
        if self.lumens == 1:
            return said
        return f"{said}; 1 W is {self.lumens:g} lm ({self.source})"


#: Units by the name of the target.
UNITS = {
    "gltf": TargetUnits(
        1.0, "lux", "cd/m2", "KHR_lights_punctual: directional lights use illuminance in lux"
    ),
    "three": TargetUnits(
        1.0, "lux", "cd/m2", "three.js from release 155: DirectionalLight.intensity is in lux"
    ),
    "usd": TargetUnits(
        1.0, "lux", "cd/m2", "UsdLuxLightAPI: nits at exposure 0; normalized distant light: lux"
    ),
    "mitsuba": TargetUnits(
        1.0, "lux", "cd/m2", "Mitsuba 3 passes the numbers on: pixels of an image are in cd/m2"
    ),
    "pbrt": TargetUnits(
        1.0, "lux", "cd/m2", "pbrt-v4, lights.cpp: an RGB of 1 is scaled to 1 nit or 1 lux"
    ),
    "blender": TargetUnits(_SI, "W/m2", "W/(m2 sr)", "as in Blender's glTF importer"),
    "radiance": TargetUnits(_RADIANCE, "W/m2", "W/(m2 sr)", "WHTEFFICACY of Radiance"),
    "unity": TargetUnits(
        1.0, "lux", "cd/m2", "Unity HDRP, Light component: directional lights are in lux"
    ),
    "unreal": TargetUnits(
        1.0, "lux", "cd/m2", "Unreal Engine, Physical Lighting Units: directional lights are in lux"
    ),
    "mujoco": TargetUnits(
        1.0, "lux, times its scale", "cd/m2, times its scale", "MuJoCo's lights have no units"
    ),
    "godot": TargetUnits(
        1.0, "lux (energy: over pi)", "cd/m2", "Godot 4: energies have no units by default"
    ),
    "engine": TargetUnits(1.0, "lux", "cd/m2", "the numbers of the map"),
}
