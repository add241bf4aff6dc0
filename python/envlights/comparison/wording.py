"""Notes of a comparison."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from envlights._common.notes import warnings
from envlights._common.words import percent, quantity
from envlights.comparison.image_errors import ImageErrors
from envlights.comparison.light_set_difference import LightSetDifference
from envlights.comparison.lighting import Lighting, Pair
from envlights.comparison.protocol import Protocol
from envlights.environment.envmap import EnvMap
from envlights.rigs.lights import Lights
from envlights.rigs.rig import Rig


def notes_of_size(sides: Mapping[str, EnvMap | Rig | Lights], rows: int) -> list[str]:
    """Notes on reduced maps, and on filled parts of the sphere."""
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
        if what.coverage is not None:
            filled = percent(1 - what.coverage_fraction)
            notes.append(f"{name}: {filled} of the sphere is not seen and was filled")
    return notes


def notes_of_maps(sides: Mapping[str, EnvMap | Rig | Lights]) -> list[str]:
    """Notes of the maps on possible errors in the numbers."""
    maps = {name: what for name, what in sides.items() if isinstance(what, EnvMap)}
    return [f"{name}: {note}" for name, what in maps.items() for note in warnings(what.notes)]


def notes_of_units(sides: Mapping[str, EnvMap | Rig | Lights]) -> list[str]:
    """Note on maps in different units."""
    units = {name: what.units for name, what in sides.items()}
    if len(set(units.values())) == 1:
        return []
    texts = " and ".join(f"{name} in {unit}" for name, unit in units.items())
    return [f"{texts}: only angles and scale-invariant errors have a meaning"]


def notes_of_floors(sides: Mapping[str, EnvMap | Rig | Lights]) -> list[str]:
    """Note on one rig over a floor, whose error on a map is `Rig.measured`."""
    floors = [name for name, what in sides.items() if getattr(what, "floor", False)]
    if len(floors) != 1:
        return []
    return [
        f"the {floors[0]} was fitted over a floor and the other side has none: light from below"
        " counts as an error here; `rig.measured(env)` has the error above the floor"
    ]


def notes_of_protocol(rules: Protocol, factors: list[float]) -> list[str]:
    """Notes on tone, views, means and materials."""
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
    """Note on pixels that are ignored because black has no colour angle."""
    shares = {name: each.black for name, each in spheres.items() if each.black > 0}
    if not shares:
        return []
    texts = ", ".join(f"{percent(fraction)} of '{name}'" for name, fraction in shares.items())
    rule = "left out of the angle" if black == "left out" else "counted as perfect in the angle"
    return [f"black pixels are {rule}: {texts}"]


def notes_of_lights(lights: LightSetDifference, pair: Pair) -> list[str]:
    """Notes on the lights: their source on each side, and remarks."""
    sources = (
        _source(name, side) for name, side in zip(("truth", "guess"), pair.sides, strict=True)
    )
    return [f"lights: {note}" for note in ("; ".join(sources), *lights.notes)]


def _source(name: str, side: Lighting) -> str:
    number = quantity(len(side.lights), "light")
    if side.given is not None:
        return f"{number} of the {name} as given"
    fraction = percent(float(side.lights.fraction.sum()))
    return f"{number} found by `detect` in the {name}, with {fraction} of its light"


def brightness(scale: float | None) -> str:
    """Line on the brightness ratio of guess and truth."""
    if scale is None:
        return "brightness: the guess is black"
    ratio = f"{1 / scale:.3g} times as bright as the truth" if scale else "unlike the truth"
    return f"brightness: the guess is {ratio} (best scale on the diffuse sphere {scale:.3g})"
