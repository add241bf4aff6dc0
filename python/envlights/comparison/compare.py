"""`compare`: errors of a lighting relative to another, on spheres and between lights."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import amount, named_arguments
from envlights._common.notes import black_note
from envlights._common.result import Result
from envlights._common.tables import Table
from envlights._common.words import degrees, percent
from envlights._native import EnvLightsError
from envlights.comparison import spectra
from envlights.comparison.image_errors import ImageErrors, errors_table
from envlights.comparison.light_set_difference import LightSetDifference
from envlights.comparison.light_sets import compare_lights
from envlights.comparison.lighting import (
    DEFAULT_ROWS,
    AnyLighting,
    Lighting,
    Pair,
    lighting_of,
    open_lighting,
    rows_of,
)
from envlights.comparison.protocol import Protocol, as_protocol, tone
from envlights.comparison.spheres import products_of, sphere_errors
from envlights.comparison.wording import (
    brightness,
    note_of_black,
    notes_of_floors,
    notes_of_lights,
    notes_of_maps,
    notes_of_protocol,
    notes_of_size,
    notes_of_units,
)
from envlights.environment.reading import check_reading
from envlights.kernels.gloss import LEAST_ROUGHNESS

if TYPE_CHECKING:
    from envlights.environment.envmap import EnvMap
    from envlights.environment.reading import Reading
    from envlights.rigs.lights import Lights
    from envlights.rigs.rig import Rig


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Result):
    """Errors of a guess against the truth, on spheres and between lights."""

    protocol: Protocol
    """Rules of the comparison."""

    spheres: Mapping[str, ImageErrors]
    """Errors of each sphere; "diffuse", "matte" and "mirror", unless the protocol has others."""

    lights: LightSetDifference
    """Difference of the lights, given by rigs or detected in maps.

    Lights of a rig and those found in a map have no ratio of fluxes; `scale` is the brightness."""

    vector_angle: float | None
    """Angle between the irradiance vectors in degrees; see `envlights.comparison.vector_angle`."""

    by_degree: NDArray[np.float64] = field(repr=False)
    """Inner products of the linear maps by degree, (4, degree): T T, T G, G G and (G - T)^2."""

    notes: tuple[str, ...] = ()
    """Notes on size, tone, means, black pixels, and other effects on the numbers."""

    @property
    def scale(self) -> float | None:
        """Factor that fits the guess best to the truth on the diffuse sphere, for linear maps.

        It is 2 for a guess that is half as bright, and None for a black one.
        """
        products = products_of(self.by_degree, spectra.lambertian())
        return products.squares()[2] if products.guess > 0 else None

    @property
    def probe_error(self) -> float:
        """Relative RMS error of irradiance over all normals, for linear maps."""
        return self._relative(spectra.lambertian())

    @property
    def shadow_error(self) -> float:
        """Relative RMS error of irradiance with part of the light blocked, over all planes."""
        return self._relative(spectra.shadows())

    def gloss_error(self, roughness: float = 0.33) -> float:
        """Relative RMS error of a rough metal ball over all views, for linear maps.

        Parameters
        ----------
        roughness : float
            From 0.2 to 1; its square is the width alpha of the distribution of microfacets.
        """
        value = amount("roughness", roughness)
        if not LEAST_ROUGHNESS <= value <= 1:
            raise EnvLightsError(
                f"roughness must be from {LEAST_ROUGHNESS:g} to 1, because narrower lobes depend on"
                f" degrees above 100; got {value:g}; a mirror is c.spheres['mirror']"
            )
        return self._relative(spectra.of_metal(value))

    def _relative(self, factors: NDArray[np.float64]) -> float:
        products = products_of(self.by_degree, factors)
        return float(np.sqrt(products.difference / products.truth))

    def in_short(self) -> str:
        """Name of the protocol, and the relative error of each sphere."""
        errors = (f"{name} {percent(each.relative or 0)}" for name, each in self.spheres.items())
        return f"{self.protocol.name}: {', '.join(errors)}"

    def _table(self) -> Table:
        return errors_table(self.spheres)

    def _lines(self) -> list[str]:
        """Brightness, errors without images, difference of lights, and notes."""
        names = ("probe", self.probe_error), ("shadow", self.shadow_error)
        errors = (*names, ("gloss", self.gloss_error()))
        line = ", ".join(f"{name} error {percent(value)}" for name, value in errors)
        vector = degrees(self.vector_angle)
        # Report brightness elsewhere, because the flux of lights is only a part of it.
        angle = "no lights to compare" if self.lights.angle is None else degrees(self.lights.angle)
        lights = f"angle of the lights: {angle}; of the irradiance vectors: {vector}"
        return [brightness(self.scale), line, lights, *self.notes]

    def to_dict(self) -> dict[str, Any]:
        """Dictionary of numbers, texts and lists, for example for JSON."""
        return {
            "protocol": self.protocol.name,
            "spheres": {name: each.to_dict() for name, each in self.spheres.items()},
            "scale": self.scale,
            "probe_error": self.probe_error,
            "shadow_error": self.shadow_error,
            "gloss_error": self.gloss_error(),
            "lights": self.lights.to_dict(),
            "vector_angle": self.vector_angle,
            "notes": list(self.notes),
        }


@named_arguments()
def compare(
    truth: AnyLighting,
    guess: AnyLighting,
    protocol: str | Protocol = "exact",
    *,
    reading: Reading | None = None,
) -> Comparison:
    r"""Compare two lightings: on a diffuse, a matte and a mirror sphere, and light by light.

    Parameters
    ----------
    truth, guess : EnvMap, Rig, Lights, path or array_like, shape (height, 2 * height, 3)
        Lightings in the frame of `EnvMap`. A path is a map, or a rig or lights that `save` wrote
        as ``.json`` or ``.csv``. The larger map is reduced to the smaller one by area means. Rigs
        and lights are drawn at the size of the other side; their shading is exact.
    protocol : {"exact", "stylelight", "diffusionlight"} or Protocol
        "exact": linear maps and spheres seen from all sides, without a camera or samples.
        The others render images as the published code of the papers does, with its tone and its
        means. A `Protocol` with other fields changes one choice.
    reading : mapping, optional
        Options on how the maps are read, as of `batch`. An `EnvMap` is used as it is; rigs and
        lights have none.

    Returns
    -------
    Comparison
        With `notes` on everything that changes the numbers.

    Raises
    ------
    EnvLightsError
        If a side cannot be read, `reading` holds an unknown option, the truth is black, or the
        protocol cannot be reproduced; then the sentence says what is missing.

    Notes
    -----
    From all sides, a sphere's mean squared pixel under the radiance L is
    :math:`\sum_l \lambda_l \sum_m L_{lm}^2 / 4 \pi`, so RMSE and scale-invariant RMSE are inner
    products of spherical harmonics. :math:`\lambda` is that of a clamped cosine (Ramamoorthi and
    Hanrahan 2001, equation 8) for "diffuse", that of GGX metal of roughness 0.3271 for "matte", and
    1 for "mirror", whose errors are the area-weighted ones of the maps. Degrees end at 100,
    for shadows of small lights at 2000. Angles
    are :math:`\mathrm{atan2}(|G \times T|, G \cdot T)` of pixels from all sides: 288 for
    "diffuse", 2048 for "matte", and all pixels of the maps for "mirror".

    See Also
    --------
    compare_folders : the same for all maps of two folders.
    image_errors : errors of images that you rendered yourself.

    Examples
    --------
    A guess that is twice as bright has the right colours and directions:

    >>> import envlights as el
    >>> hall = el.synthetic.hall(64).radiance
    >>> c = el.compare(hall, 2 * hall)
    >>> matte = c.spheres["matte"]
    >>> round(matte.relative, 6), round(matte.si_rmse, 6), round(matte.angle, 3)
    (1.0, 0.0, 0.0)
    """
    rules = as_protocol(protocol)
    check_reading(reading)
    sides = [_open(name, what, reading) for name, what in (("truth", truth), ("guess", guess))]
    linear, notes = _of_one_size(sides[0], sides[1], rules)
    if not linear.truth.radiance.any():
        raise EnvLightsError("truth must have light; it is black everywhere")
    toned, factors = _tone(linear, rules)
    spheres = {
        name: sphere_errors(toned, material, rules) for name, material in rules.materials.items()
    }
    lights = _light_set_difference(linear)
    notes += black_note(linear.guess.radiance, "guess")
    notes += notes_of_protocol(rules, factors)
    notes += [*note_of_black(spheres, rules.black), *notes_of_lights(lights, linear)]
    return Comparison(
        rules,
        spheres,
        lights,
        linear.vector_angle(),
        linear.by_degree,
        tuple(notes),
    )


def _light_set_difference(pair: Pair) -> LightSetDifference:
    """Difference of the lights; no flux ratio between a rig and detected lights."""
    difference = compare_lights(pair.truth.lights, pair.guess.lights)
    are_alike = (pair.truth.given is None) == (pair.guess.given is None)
    return difference if are_alike else replace(difference, flux_ratio=None)


def _open(name: str, what: Any, reading: Reading | None) -> EnvMap | Rig | Lights:
    try:
        return open_lighting(what, reading)
    except EnvLightsError as refusal:
        raise type(refusal)(f"{name}: {refusal}") from None


def _of_one_size(
    truth: EnvMap | Rig | Lights, guess: EnvMap | Rig | Lights, rules: Protocol
) -> tuple[Pair, list[str]]:
    """Lightings resampled to maps of one size, and notes on sizes and units."""
    heights = [rows for rows in map(rows_of, (truth, guess)) if rows is not None]
    rows = min([*heights, *([rules.rows] if rules.rows else [])] or [DEFAULT_ROWS])
    pair = Pair(lighting_of(truth, rows), lighting_of(guess, rows))
    named = {"truth": truth, "guess": guess}
    notes = [*notes_of_maps(named), *notes_of_size(named, rows), *notes_of_units(named)]
    return pair, [*notes, *notes_of_floors(named)]


def _tone(pair: Pair, rules: Protocol) -> tuple[Pair, list[float]]:
    if rules.gamma is None and rules.median is None:
        return pair, []
    toned = [tone(side.radiance, rules) for side in pair.sides]
    sides = [Lighting.of_cells(radiance) for radiance, _ in toned]
    return Pair(sides[0], sides[1]), [factor for _, factor in toned]
