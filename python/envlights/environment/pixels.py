"""Pixels of an equirectangular map with their properties: the content of an `EnvMap`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._common.srgb import encode_srgb
from envlights._common.units import OWN_SCALE
from envlights.environment import resample
from envlights.environment.coverage import (
    checked_coverage,
    fraction_of_sphere,
    multiply_by_coverage,
    note_of_coverage,
)
from envlights.environment.layouts.picture_layout import PictureLayout, equirectangular
from envlights.environment.layouts.projections import REGISTRATIONS
from envlights.environment.layouts.records import Origin

#: Projection of every map.
PROJECTION = "equirectangular"


@dataclass(frozen=True, eq=False)
class MapPixels:
    """Radiance of a map with its layout, coverage, clip level, notes and units."""

    radiance: NDArray[np.float32]
    """Linear RGB, (height, 2 height, 3), black where not covered; read-only."""

    is_border_sampled: bool
    """True if the outer pixels lie on the seam and the poles."""

    source: Origin
    """Original picture of the map."""

    coverage: NDArray[np.float32] | None = None
    """Coverage of each pixel, 0 to 1, (height, width); None if the map is complete."""

    clip_level: float | None = None
    """Largest value that the radiance can hold; None if unknown."""

    notes: tuple[str, ...] = ()
    """Notes on changes and assumptions."""

    units: str = OWN_SCALE
    """Unit of the radiance; see `EnvMap.units`."""

    ev100: float | None = None
    """Exposure value at ISO 100 of the picture; None if unknown."""

    def __post_init__(self) -> None:
        for name in ("radiance", "coverage"):
            array = getattr(self, name)
            if array is not None and array.flags.writeable:
                object.__setattr__(self, name, _read_only(array))

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), tuple(getattr(self, field.name) for field in fields(self))

    @property
    def registration(self) -> str:
        """Positions of the pixels: "cell-centred" or "border-sampled"."""
        return REGISTRATIONS[self.is_border_sampled]

    @property
    def layout(self) -> PictureLayout:
        """Pixel layout for the kernels."""
        size = self.radiance.shape[:2]
        return equirectangular(*size, border_sampled=self.is_border_sampled)

    @property
    def coverage_fraction(self) -> float:
        """Covered fraction of the sphere."""
        if self.coverage is None:
            return 1.0
        return fraction_of_sphere(self.coverage, self.is_border_sampled)

    @cached_property
    def clipped_fractions(self) -> tuple[float, float]:
        """Fractions of the sphere, and of the luminance flux, in clipped pixels."""
        fractions = _native.clipped_fraction(self.radiance, self.is_border_sampled, self.clip_level)
        if self.clip_level is None and fractions[0] and are_decoded_codes(self.radiance):
            # As in codes, the code below the largest one counts too.
            white = float(self.radiance.max())
            return _native.clipped_fraction(self.radiance, self.is_border_sampled, white)
        return fractions

    @property
    def found_clip_level(self) -> float | None:
        """Clip level if known, or the largest sample if many pixels have it; otherwise None."""
        if self.clip_level is None and self.clipped_fractions[0]:
            return float(self.radiance.max())
        return self.clip_level

    @property
    def clip_level_of_picture(self) -> float | None:
        """Clip level if known, or the largest sample of floats decoded from 8-bit codes."""
        if self.clip_level is not None or not are_decoded_codes(self.radiance):
            return self.clip_level
        return self.found_clip_level

    def cells(self) -> NDArray[np.float32]:
        """Radiance resampled to a cell-centred map of the same size and flux."""
        if self.is_border_sampled:
            return resample.cells_of_borders(self.radiance)
        return self.radiance

    def changed(
        self,
        radiance: NDArray[np.float32],
        coverage: NDArray[np.float32] | None,
        notes: Iterable[str],
        **others: Any,
    ) -> MapPixels:
        """Pixels with another radiance and coverage; `others` are further fields to replace."""
        if coverage is not None:
            radiance = multiply_by_coverage(radiance, np.float32(1) * (coverage > 0))
        pixels = replace(self, radiance=radiance, notes=tuple(notes), **others)
        return with_coverage(pixels, coverage)


def are_decoded_codes(radiance: NDArray[np.float32]) -> bool:
    """True if the floats are values of many 8-bit sRGB codes; checks a sample of the pixels.

    The picture may have another exposure, if the largest value is white.
    """
    rows, columns = (max(side // 64, 1) for side in radiance.shape[:2])
    # Unlike `np.unique`, this loads no module of NumPy.
    values = np.sort(radiance[::rows, ::columns], axis=None)
    values = values[np.append(True, values[1:] > values[:-1])]
    if len(values) > 256:
        return False
    white = float(radiance.max(initial=0)) or 1.0
    return any(_are_values_of_codes(values / scale) for scale in (1, white))


def _are_values_of_codes(values: NDArray[np.float32]) -> bool:
    if values.max(initial=0) > 1:
        return False
    codes = 255 * encode_srgb(values)
    whole = np.round(codes)
    # A lamp of radiance 1 in the dark has only the codes 0 and 255.
    return bool(np.abs(codes - whole).max(initial=0) < 0.01 and len(np.unique(whole)) > 8)


def with_coverage(pixels: MapPixels, coverage: NDArray[np.float32] | None) -> MapPixels:
    """Pixels with the given coverage and a note on it, or without coverage for None."""
    if coverage is not None:
        coverage = checked_coverage(coverage, pixels.radiance.shape[:2])
    pixels = replace(pixels, coverage=coverage)
    if coverage is None:
        return pixels
    note = note_of_coverage(pixels.coverage_fraction)
    return pixels if note in pixels.notes else replace(pixels, notes=(*pixels.notes, note))


def are_equal(one: MapPixels, other: MapPixels) -> bool:
    """True if radiance, units, layout, clip level and coverage are equal."""
    known, others = ((e.units, e.registration, e.clip_level) for e in (one, other))
    if known != others or (one.coverage is None) != (other.coverage is None):
        return False
    is_equal = one.coverage is None or np.array_equal(one.coverage, other.coverage)  # type: ignore[arg-type]
    return is_equal and np.array_equal(one.radiance, other.radiance)


def _read_only(array: NDArray[np.float32]) -> NDArray[np.float32]:
    view = array.view()
    view.flags.writeable = False
    return view
