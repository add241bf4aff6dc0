"""Capabilities of a target, and the resulting error of a rig."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights.environment.envmap import EnvMap
from envlights.kernels import probe, sampling
from envlights.kernels.ambient import ambient_rows, mean_ambient

#: Rows of the map for a non-constant ambient term, which varies slowly over the sphere.
ROWS = 128
#: Number of normals for the comparison, because the irradiance of a rig is smooth.
_FACES = 5120

#: Loss of sizes only, for which `fit` reports the error.
_AS_POINTS = "lights as points"


class Capabilities(NamedTuple):
    """Parts of a rig that a target can show."""

    sizes: str = "spread"
    """Effect of an angular radius. "spread": light from a disc at every normal. "soften": only soft
    shadow edges. "none": no effect."""

    harmonics: str = "exact"
    """Form of nine harmonics. "exact": unchanged. "map": radiance, clipped where negative. "none":
    mean radiance only."""

    floor: bool = True
    """True if ambient light can be restricted to directions above the horizon."""

    environment: bool = True
    """True if a map can replace the ambient term."""

    lights: int | None = None
    """Largest number of lights; None if unlimited."""

    casters: int | None = None
    """Largest number of lights with shadows; None if unlimited."""

    cards: bool = False
    """True if cards are planes in space; False if they are discs like other lights."""

    uniform_cards: tuple[str, ...] = ()
    """Shapes of cards that have uniform radiance instead of a texture."""

    remark: str = ""
    """Other losses, and manual settings."""

    source: str = ""
    """Document or source code that proves these fields."""

    def in_short(self) -> str:
        """Supported parts of a rig, as text."""
        sizes = {"spread": "sizes", "soften": "sizes in shadows alone", "none": "no sizes"}
        harmonics = {
            "exact": "harmonics",
            "map": "positive harmonics, as a map",
            "none": "no harmonics",
        }
        limits = ((self.lights, "lights"), (self.casters, "shadows"))
        shown = (
            *(f"at most {most} {what}" for most, what in limits if most is not None),
            sizes[self.sizes],
            harmonics[self.harmonics],
            "floor" if self.floor else "no floor",
            "map" if self.environment else "no map",
            *(["cards"] if self.cards else []),
        )
        return ", ".join(shown)

    def ambients(self) -> tuple[str, ...]:
        """Ambient terms that a fit may choose, simplest first."""
        return ("none", "constant", *(("sh2",) if self.harmonics == "exact" else ()))

    def losses(self, rig: Any) -> tuple[str, ...]:
        """Descriptions of the parts of a rig or of lights that the target changes."""
        ambient = _ambient(rig)
        harmonics = {
            "exact": "",
            "map": "harmonics only where they are positive",
            "none": "harmonics as one radiance",
        }
        floor = getattr(rig, "floor", False) and not self.floor
        lost = (
            self._surplus(rig),
            _AS_POINTS if self.sizes != "spread" and _lights(rig).angular_radius.any() else "",
            harmonics[self.harmonics] if len(ambient) == 9 else "",
            "ambient light from below the floor too" if floor and ambient.any() else "",
        )
        return tuple(filter(None, lost))

    def _surplus(self, rig: Any) -> str:
        """Description of the loss of surplus lights; empty if there are none."""
        if self.lights is None or len(_lights(rig)) <= self.lights:
            return ""
        shown = f"the {self.lights} brightest of {len(_lights(rig))} lights"
        return f"{shown}, the others as ambient light"

    def irradiance(self, rig: Any, normals: NDArray[np.float64]) -> NDArray[np.float64]:
        """Irradiance at `normals` as the target renders a rig or lights, (n, 3)."""
        every = _lights(rig)
        most = len(every) if self.lights is None else self.lights
        lights, surplus = every[:most], every[most:]
        radii = lights.angular_radius * (self.sizes == "spread")
        # Averaged over all normals, the irradiance of a light is a quarter of its value.
        mean = surplus.irradiance.sum(axis=0) / (4 * np.pi)
        parts = normals, mean, lights.direction, lights.irradiance, radii
        return probe.rig_irradiance(*parts) + self._ambient_irradiance(rig, normals)

    def _ambient_irradiance(self, rig: Any, normals: NDArray[np.float64]) -> NDArray[np.float64]:
        ambient, floor = _ambient(rig), getattr(rig, "floor", False) and self.floor
        if len(ambient) == 9 and self.harmonics == "map":
            rows = ambient_rows(ambient, ROWS, floor)
            return EnvMap(rows(slice(0, ROWS))).probe(normals)
        if len(ambient) == 9 and self.harmonics == "none":
            ambient = mean_ambient(ambient)
        none = np.zeros((0, 3))
        return probe.rig_irradiance(normals, ambient, none, none, floor=floor)

    def change(self, rig: Any) -> float:
        """Relative RMS difference between the rendered irradiance and that of the rig."""
        if not self.losses(rig):
            return 0.0
        normals, weights = sampling.icosphere(_FACES)
        shown = self.irradiance(rig, normals)
        return probe.relative_rms(shown, Capabilities().irradiance(rig, normals), weights)

    def error(self, rig: Any) -> float:
        """Relative RMS error of the rendered irradiance.

        It is exact if sizes are all that is lost. Otherwise, or without a fit, it assumes that the
        change is independent of the error of the rig. Lights alone, and rigs that were not
        measured, have no error of their own.
        """
        if getattr(rig, "error", None) is None:
            return self.change(rig)
        as_points = rig.report.points_error
        if as_points is not None and self.losses(rig) == (_AS_POINTS,):
            return float(as_points)
        return float(np.hypot(rig.error, self.change(rig)))


#: Values of sizes and harmonics, least capable first.
_SIZES = ("none", "soften", "spread")
_HARMONICS = ("none", "map", "exact")


def common(capabilities: Iterable[Capabilities]) -> Capabilities:
    """Capabilities that several targets have in common."""
    each = (*capabilities, Capabilities())
    return Capabilities(
        sizes=min((one.sizes for one in each), key=_SIZES.index),
        harmonics=min((one.harmonics for one in each), key=_HARMONICS.index),
        floor=all(one.floor for one in each),
        environment=all(one.environment for one in each),
        lights=min((one.lights for one in each if one.lights is not None), default=None),
    )


def _lights(rig: Any) -> Any:
    """Lights of a rig, or the given lights, as discs."""
    return getattr(rig, "lights", rig).discs()


def _ambient(rig: Any) -> NDArray[np.float64]:
    """Ambient term, (3,) or (9, 3)."""
    return np.asarray(getattr(rig, "ambient", np.zeros(3)))
