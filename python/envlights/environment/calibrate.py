"""Calibration of a map to candela per square metre, by a light meter or an exposure."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import amount, positive, reals
from envlights._common.units import PHOTOMETRIC
from envlights._common.words import percent
from envlights._native import LEAST_WHITE, EnvLightsError
from envlights.environment.fill import Fill
from envlights.environment.light import from_unseen, probe
from envlights.environment.pixels import MapPixels
from envlights.environment.repair import repair
from envlights.kernels import sphere
from envlights.kernels.image import LUMINANCE

#: Luminance of a value of 1 at EV100 0 in cd/m2: the saturation of a sensor by ISO 12232 with a
#: lens that passes 0.65 of the light, 78 / (100 * 0.65). Lagarde and de Rousiers, "Moving
#: Frostbite to Physically Based Rendering", 2014, section 5.1; Filament and Unity use it too.
_SATURATION = 1.2

#: Upward unit vector.
_UP = (0.0, 1.0, 0.0)

#: Start of the note of a calibration, which a later one replaces.
_NOTE = "calibrated to cd/m2"


class Readings(NamedTuple):
    """Arguments of `EnvMap.calibrated`; values that were not measured are None."""

    lux: float | None
    normal: ArrayLike | None
    shaded: float | None
    nits: float | None
    at: ArrayLike | None
    ev100: float | None

    def check(self) -> None:
        """Raise an error for several kinds of readings, or arguments of another kind."""
        kinds = [name for name in ("lux", "nits", "ev100") if getattr(self, name) is not None]
        if len(kinds) > 1:
            raise EnvLightsError(
                f"a map has one scale; got {' and '.join(kinds)}; give one of them, and compare the"
                " other with the calibrated map"
            )
        for name, of in (("normal", "lux"), ("shaded", "lux"), ("at", "nits")):
            if getattr(self, name) is not None and kinds != [of]:
                raise EnvLightsError(f"{name} belongs to {of}; give {of} too, or leave {name} out")
        if self.nits is not None and self.at is None:
            raise EnvLightsError(
                "nits needs the measured place: at=(x, y, z), a direction, or at=(row, column)"
            )

    def of_lux(self) -> tuple[float, NDArray[np.float64]]:
        """Measured illuminance, and the unit normal of the measured surface."""
        normal = reals("normal", _UP if self.normal is None else self.normal, 1)
        sphere.direction_to_uv(normal[None])  # raises an error for a vector whose length is not 1
        return positive("lux", self.lux), normal

    def ratio(self, lux: float) -> float | None:
        """Ratio of the illuminance to that with the sun shaded; None without a second reading."""
        if self.shaded is None:
            return None
        shaded = positive("shaded", self.shaded)
        if shaded >= lux:
            raise EnvLightsError(
                f"shaded must be below lux, because shade takes light away; got {shaded:g} lux in"
                f" the shade and {lux:g} in the sun"
            )
        return lux / shaded


def calibrate(pixels: MapPixels, readings: Readings, patch: float, fill: Fill) -> MapPixels:
    """Pixels in cd/m2, by one reading or by the exposure of the file; see `EnvMap.calibrated`."""
    readings.check()
    diameter = amount("patch", patch, most=180)
    if readings.lux is not None:
        return _by_lux(pixels, readings, fill)
    if readings.nits is not None and readings.at is not None:
        return _by_luminance(pixels, positive("nits", readings.nits), readings.at, diameter)
    return _by_exposure(pixels, readings.ev100)


def _by_lux(pixels: MapPixels, readings: Readings, fill: Fill) -> MapPixels:
    """Pixels scaled so that the luminance of their irradiance equals the reading of a lux meter."""
    lux, normal = readings.of_lux()
    ratio = readings.ratio(lux)
    source = f"{lux:g} lux on a surface that faces {_numbers(normal)}"
    if ratio is not None:
        pixels = _with_sun(pixels, ratio, normal, readings, fill)
        source += f", {readings.shaded:g} in the shade"
    return _in_scale(pixels, lux, float(probe(pixels, normal, fill) @ LUMINANCE), source)


def _with_sun(
    pixels: MapPixels, ratio: float, normal: NDArray[np.float64], readings: Readings, fill: Fill
) -> MapPixels:
    """Pixels with clipped light restored from two readings; see `EnvMap.repaired`."""
    if not pixels.clipped_fractions[0]:
        raise EnvLightsError(
            "shaded needs a map with a clipped sun, but no pixel is clipped: its sun has its"
            " true ratio to the sky; leave shaded out"
        )
    received, assumed = from_unseen(pixels, fill, normal)
    try:
        repaired = repair(pixels, None, ratio, normal, from_unseen=received)
    except EnvLightsError as refusal:
        raise EnvLightsError(
            f"lux and shaded, {readings.lux:g} and {readings.shaded:g}, contradict the map:"
            f" {refusal}"
        ) from None
    notes = [*pixels.notes, *assumed, repaired.note]
    return pixels.changed(repaired.radiance, pixels.coverage, notes, clip_level=None)


def _by_luminance(pixels: MapPixels, nits: float, at: ArrayLike, diameter: float) -> MapPixels:
    """Pixels scaled so that a disc has the luminance that a meter shows."""
    height, width, _ = pixels.radiance.shape
    direction = _direction_at(at, height, width)
    patch = _patch_of(pixels.cells(), pixels.coverage, direction, diameter)
    patch.check(pixels.clip_level)
    source = f"{nits:g} cd/m2 in a disc of {diameter:g} degrees at {_numbers(direction)}"
    return _in_scale(pixels, nits, patch.luminance, source)


def _by_exposure(pixels: MapPixels, ev100: float | None) -> MapPixels:
    """Pixels scaled so that the value 1 is the luminance that saturates the sensor."""
    if pixels.units == PHOTOMETRIC:
        raise EnvLightsError(
            "the map is in cd/m2 already, so 1 is not the saturation of a sensor; leave ev100 out,"
            " or calibrate it anew with lux=, or nits= and at="
        )
    value, source = ev100, f"EV100 {ev100}"
    if value is None:
        if pixels.ev100 is None:
            raise EnvLightsError(
                "give a reading: lux=, nits= with at=, or ev100=; without one, the file must be"
                " a JPEG or TIFF with exposure time, aperture and sensitivity in its EXIF"
            )
        value = pixels.ev100
        source = f"EV100 {value:.2f} of the EXIF (up to about one stop off by a tone curve)"
    wanted = _SATURATION * 2.0 ** amount("ev100", value, -60, 60)
    return _in_scale(pixels, wanted, 1.0, source)


def _in_scale(pixels: MapPixels, wanted: float, measured: float, source: str) -> MapPixels:
    """Pixels in cd/m2, scaled so that the luminance `measured` in the map becomes `wanted`."""
    radiance, factor, note = _in_nits(pixels.radiance, wanted, measured, source)
    level = None if pixels.clip_level is None else factor * pixels.clip_level
    notes = [*_other_notes(pixels.notes), note]
    own = {"clip_level": level, "units": PHOTOMETRIC, "ev100": None}
    return pixels.changed(radiance, pixels.coverage, notes, **own)


def _numbers(vector: NDArray[np.float64]) -> str:
    return f"({', '.join(f'{value + 0.0:.3g}' for value in vector)})"


def _in_nits(
    radiance: NDArray[np.float32], wanted: float, measured: float, source: str
) -> tuple[NDArray[np.float32], float, str]:
    """Radiance in cd/m2, its factor, and a note.

    Parameters
    ----------
    radiance : ndarray, shape (height, width, 3)
        Radiance on the scale of the map.
    wanted, measured : float
        Reading of the meter, and the same quantity in the map.
    source : str
        Reading in words.
    """
    if not measured > 0:
        raise EnvLightsError(f"the map is black there, so {source} gives no scale")
    factor = wanted / measured
    largest = factor * float(radiance.max(initial=0))
    if not 0 < largest < float(np.finfo(np.float32).max):
        raise EnvLightsError(
            f"{source} makes a largest sample of {largest:.3g} cd/m2, which single precision cannot"
            f" hold; the map has {measured:.4g} on its own scale"
        )
    note = f"{_NOTE} by {source}: radiance was multiplied by {factor:.4g}"
    return radiance * np.float32(factor), factor, note


def _other_notes(notes: tuple[str, ...]) -> list[str]:
    """Notes without the note of an earlier calibration."""
    return [note for note in notes if not note.startswith(_NOTE)]


class _Patch(NamedTuple):
    """Disc of a map that a luminance meter measures."""

    luminance: float
    """Mean luminance over the solid angle."""

    largest: float
    """Largest sample."""

    coverage: float
    """Smallest coverage of a pixel in the disc."""

    def check(self, clip_level: float | None) -> None:
        """Raise an error if the disc is clipped, or not completely visible in the map."""
        if self.coverage < 1:
            raise EnvLightsError(
                f"the map does not show all of the disc at `at` ({percent(self.coverage)} of a"
                " pixel); measure a place that it shows"
            )
        if clip_level is not None and self.largest >= LEAST_WHITE * clip_level:
            raise EnvLightsError(
                f"the disc at `at` is clipped at {clip_level:g}, so its luminance is unknown;"
                " measure a darker place"
            )


def _direction_at(at: ArrayLike, height: int, width: int) -> NDArray[np.float64]:
    """Unit vector to a direction (x, y, z) or to a pixel (row, column)."""
    place = reals("at", at, 1)
    if len(place) == 3:
        sphere.direction_to_uv(place[None])  # raises an error for a vector whose length is not 1
        return place
    if len(place) != 2:
        raise EnvLightsError(
            f"at must be a direction (x, y, z) or a pixel (row, column); got {len(place)} numbers"
        )
    row, column = place
    if not (0 <= row < height and 0 <= column < width):
        raise EnvLightsError(
            f"at must be a pixel of the map of {height} rows and {width} columns; got ({row:g},"
            f" {column:g})"
        )
    uv = [[(column + 0.5) / width, (row + 0.5) / height]]
    direction: NDArray[np.float64] = sphere.uv_to_direction(uv)[0]
    return direction


def _patch_of(
    cells: NDArray[np.float32],
    coverage: NDArray[np.float32] | None,
    direction: NDArray[np.float64],
    diameter: float,
) -> _Patch:
    """Pixels of a cell-centred map in a disc, whose diameter is in degrees; at least one pixel."""
    height, width, _ = cells.shape
    radius = math.radians(diameter) / 2
    theta = math.acos(min(max(direction[1], -1.0), 1.0))
    first = min(max(math.floor((theta - radius) / math.pi * height), 0), height - 1)
    rows = slice(first, min(math.ceil((theta + radius) / math.pi * height) + 1, height))
    forward = sphere.row_directions(height, rows) @ direction
    # If the disc contains no pixel centre, take the nearest pixel.
    is_in = forward >= min(math.cos(radius), float(forward.max()))
    weight = sphere.pixel_solid_angles(height, 2)[rows, :1].repeat(width, axis=1)[is_in]
    pixels = cells[rows][is_in]
    luminance = float(weight @ (pixels @ LUMINANCE) / weight.sum())
    fraction = 1.0 if coverage is None else float(coverage[rows][is_in].min())
    return _Patch(luminance, float(pixels.max()), fraction)
