"""Notes of a comparison."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from envlights.comparison.image_errors import ImageErrors
from envlights.comparison.light_set_difference import LightSetDifference
from envlights.comparison.protocol import Protocol
from envlights.envmap import EnvMap
from envlights.lights import Lights
from envlights.rig import Rig


def notes_of_size(sides: Mapping[str, EnvMap | Rig | Lights], rows: int) -> list[str]:
    """Notes on maps that were reduced, and on parts of the sphere that were filled."""
    notes = []
    for name, what in sides.items():
        if not isinstance(what, EnvMap):
            notes.append(
                f"{name}: drawn as a map of {2 * rows}x{rows} pixels for mirrors and angles"
            )
            continue
        if what.height != rows:
            change = "reduced" if what.height > rows else "enlarged"
            size = f"{what.width}x{what.height} to {2 * rows}x{rows} pixels"
            notes.append(f"{name}: {change} from {size} by area means")
        if what.seen is not None:
            percent = 100 * (1 - what.coverage_fraction)
            notes.append(f"{name}: {percent:.3g} % of the sphere is not seen and was filled")
    return notes


def notes_of_units(sides: Mapping[str, EnvMap | Rig | Lights]) -> list[str]:
    """Note on maps in different units."""
    units = {name: what.units for name, what in sides.items()}
    if len(set(units.values())) == 1:
        return []
    texts = " and ".join(f"{name} in {unit}" for name, unit in units.items())
    return [f"{texts}: only angles and scale-invariant errors have a meaning"]


def notes_of_protocol(rules: Protocol, factors: list[float]) -> list[str]:
    """Notes on tone, sides, means and materials."""
    notes = [*_note_of_tone(rules, factors)]
    if rules.camera is None:
        notes.append("spheres seen from all sides, in closed form; angles from sampled pixels")
    else:
        notes.append("spheres in the images of one camera: another place gives other numbers")
    if rules.channels == "sum":
        notes.append(
            f"squares are summed over channels: RMSE is {np.sqrt(3):.2f} times the usual one"
        )
    for name, material in rules.materials.items():
        if material.base and material.specular:
            coat = f"specular {material.specular:g}, roughness {material.roughness:g}"
            notes.append(f"'{name}' is not Lambertian: it has a coat ({coat})")
    if rules.normalised:
        notes.append("norm-RMSE: each picture is divided by its own 99.9 % percentile")
    return notes


def _note_of_tone(rules: Protocol, factors: list[float]) -> list[str]:
    if not factors:
        return ["linear maps, not scaled"]
    power = "" if rules.gamma is None else f" by x^(1/{rules.gamma:g})"
    if rules.median is None:
        return [f"maps toned{power}: spheres are lit by encoded values"]
    scales = " and ".join(f"{factor:.3g}" for factor in factors)
    return [
        f"maps toned{power} and each scaled to its own median {rules.median:g}"
        f" (by {scales} for truth and guess): a brighter guess scores the same"
    ]


def note_of_black(spheres: Mapping[str, ImageErrors], black: str) -> list[str]:
    """Note on pixels whose colour has no angle."""
    shares = {name: each.black for name, each in spheres.items() if each.black > 0}
    if not shares:
        return []
    texts = ", ".join(f"{100 * share:.2g} % of '{name}'" for name, share in shares.items())
    rule = "left out of the angle" if black == "left out" else "counted as perfect in the angle"
    return [f"black pixels are {rule}: {texts}"]


def note_of_lights(lights: LightSetDifference) -> list[str]:
    """Notes on the lights, named as such."""
    return [f"lights: {note}" for note in lights.notes]
