"""Capabilities of a target, and the error of a rig that it shows."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights.environment.envmap import EnvMap
from envlights.kernels import probe, sampling
from envlights.kernels.ambient import ambient_rows

#: Rows of the map for an ambient term that is not constant; it changes slowly over the sphere.
ROWS = 128
#: Normals of the comparison: the irradiance of a rig is smooth.
_FACES = 5120
#: Constant term of the harmonics.
HARMONIC_MEAN = 0.5 / np.sqrt(np.pi)

#: Loss of sizes alone, for which `fit` measures the error.
_AS_POINTS = "lights as points"


class Capabilities(NamedTuple):
    """Parts of a rig that a target can show."""

    sizes: str = "spread"
    """Effect of an angular radius. "spread": light of a disc on every normal. "soften": soft edges
    of shadows alone. "none": no effect."""

    harmonics: str = "exact"
    """Form of nine harmonics. "exact": as they are. "map": radiance, cut off where negative.
    "none": their mean radiance."""

    floor: bool = True
    """True if ambient light from above the horizon alone can be shown."""

    environment: bool = True
    """True if a map can replace the ambient term."""

    lights: int | None = None
    """Largest number of lights; None: any number."""

    casters: int | None = None
    """Largest number of lights that cast shadows; None: any number."""

    cards: bool = False
    """True if cards are planes in space; False if they are discs like other lights."""

    uniform_cards: tuple[str, ...] = ()
    """Shapes of cards that light with one radiance, without their texture."""

    remark: str = ""
    """Losses in other words, and settings to make by hand."""

    source: str = ""
    """Document or source code that these fields are from."""

    def in_short(self) -> str:
        """Parts of a rig that it shows, in words."""
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
        """Ambient terms that a fit may choose, the simplest first."""
        return ("none", "constant", *(("sh2",) if self.harmonics == "exact" else ()))

    def losses(self, rig: Any) -> tuple[str, ...]:
        """Parts of a rig, or of lights, that are shown in another way."""
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
        """Loss of the lights beyond the limit; empty if there are none."""
        if self.lights is None or len(_lights(rig)) <= self.lights:
            return ""
        shown = f"the {self.lights} brightest of {len(_lights(rig))} lights"
        return f"{shown}, the others as ambient light"

    def irradiance(self, rig: Any, normals: NDArray[np.float64]) -> NDArray[np.float64]:
        """Irradiance at `normals` as the target shows a rig, or lights, (n, 3)."""
        every = _lights(rig)
        most = len(every) if self.lights is None else self.lights
        lights, surplus = every[:most], every[most:]
        radii = lights.angular_radius * (self.sizes == "spread")
        # Averaged over all normals, a light gives a quarter of its irradiance.
        mean = surplus.irradiance.sum(axis=0) / (4 * np.pi)
        parts = normals, mean, lights.direction, lights.irradiance, radii
        return probe.rig_irradiance(*parts) + self._ambient_irradiance(rig, normals)

    def _ambient_irradiance(self, rig: Any, normals: NDArray[np.float64]) -> NDArray[np.float64]:
        ambient, floor = _ambient(rig), getattr(rig, "floor", False) and self.floor
        if len(ambient) == 9 and self.harmonics == "map":
            rows = ambient_rows(ambient, ROWS, floor)
            return EnvMap(rows(slice(0, ROWS))).probe(normals)
        if len(ambient) == 9 and self.harmonics == "none":
            ambient = HARMONIC_MEAN * ambient[0]
        none = np.zeros((0, 3))
        return probe.rig_irradiance(normals, ambient, none, none, floor=floor)

    def change(self, rig: Any) -> float:
        """Relative RMS difference between the irradiance that is shown and that of the rig."""
        if not self.losses(rig):
            return 0.0
        normals, weights = sampling.icosphere(_FACES)
        shown = self.irradiance(rig, normals)
        return probe.relative_rms(shown, Capabilities().irradiance(rig, normals), weights)

    def error(self, rig: Any) -> float:
        """Relative RMS error of the irradiance that is shown.

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


#: Order of sizes and of harmonics, from those that show least.
_SIZES = ("none", "soften", "spread")
_HARMONICS = ("none", "map", "exact")


def common(capabilities: Iterable[Capabilities]) -> Capabilities:
    """Parts of a rig that several targets can all show."""
    each = (*capabilities, Capabilities())
    return Capabilities(
        sizes=min((one.sizes for one in each), key=_SIZES.index),
        harmonics=min((one.harmonics for one in each), key=_HARMONICS.index),
        floor=all(one.floor for one in each),
        environment=all(one.environment for one in each),
        lights=min((one.lights for one in each if one.lights is not None), default=None),
    )


def _lights(rig: Any) -> Any:
    """Lights of a rig, or lights themselves, as discs."""
    return getattr(rig, "lights", rig).discs()


def _ambient(rig: Any) -> NDArray[np.float64]:
    """Ambient term, (3,) or (9, 3)."""
    return np.asarray(getattr(rig, "ambient", np.zeros(3)))
