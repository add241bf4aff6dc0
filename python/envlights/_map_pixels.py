"""Pixels of an environment map: radiance, layout on the sphere, clip level and notes."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _cleaning, _html, _map_text, _native, _thumbnails, _visibility, resampling
from envlights._arrays import convert
from envlights._check import amount, count, describe, texts
from envlights._map_array import image_array
from envlights._native import EnvLightsError
from envlights._notes import Note
from envlights._units import OWN_SCALE, checked_units, in_nits
from envlights._white import clip_level_of_codes
from envlights.io.hints import NO_HINTS, Hints
from envlights.io.images import MOST_PIXELS
from envlights.layouts.layout import equirectangular
from envlights.layouts.recognition import recognise
from envlights.layouts.records import REGISTRATIONS, Arguments, ArrangedPicture, Source
from envlights.layouts.sources import faces_of_mapping

if TYPE_CHECKING:
    from typing_extensions import Self

#: Projection of the pixels of every map.
PROJECTION = "equirectangular"


class MapPixels:
    """Radiance of all pixels with their layout, clip level and notes; see `EnvMap`."""

    _units = OWN_SCALE
    _ev100: float | None = None

    def __init__(
        self,
        radiance: ArrayLike | Mapping[str, ArrayLike],
        *,
        projection: str | None = None,
        faces: str | None = None,
        registration: str | None = None,
        mapping: str | None = None,
        fov: float | None = None,
        horizon: float | None = None,
        circle: ArrayLike | None = None,
        towards: ArrayLike | None = None,
        eye: str | None = None,
        width: int | None = None,
        notes: str | Iterable[str] = (),
        white: float | None = None,
        seen: ArrayLike | None = None,
        units: str = OWN_SCALE,
    ) -> None:
        self._units = checked_units(units)
        arguments = Arguments(
            projection, faces, registration, mapping, fov, horizon, circle, towards, eye
        )
        arguments.check()
        self._white = None if white is None else checked_clip_level(white)
        self._notes = texts("notes", notes)
        if isinstance(radiance, str | os.PathLike):
            raise EnvLightsError(
                "a map must be an array; `EnvMap.open` reads files; got"
                f" {describe(os.fspath(radiance))}"
            )
        self._set_pixels(radiance, seen, NO_HINTS, arguments, width)

    @classmethod
    def unchecked(
        cls,
        radiance: ArrayLike,
        *,
        registration: str = REGISTRATIONS[0],
        notes: Iterable[str] = (),
        white: float | None = None,
        seen: NDArray[np.float32] | None = None,
        source: Source | None = None,
        units: str = OWN_SCALE,
    ) -> Self:
        """Map without a check of its samples, for arrays that a kernel checks or has made.

        `source` is that of the map from which the array was made.
        """
        env = cls.__new__(cls)
        env._notes, env._white, env._units = list(notes), white, units
        array = image_array(radiance, env._notes, "a map")
        if array.samples.ndim == 4 or array.samples.shape[1] != 2 * array.samples.shape[0]:
            given: dict[str, Any] = {"registration": registration, "seen": seen}
            return cls(radiance, **given, notes=notes, white=white, units=units)
        linear = env._linear(array.samples, array.seen)
        linear, share = env._seen_light(linear, array.seen, seen)
        border_sampled = registration == REGISTRATIONS[1]
        layout = equirectangular(*linear.shape[:2], border_sampled=border_sampled)
        itself = Source(PROJECTION, linear.shape[:2], "", registration, "shape", layout)
        env._keep(linear, share, border_sampled, source or itself)
        return env

    def _set_pixels(
        self,
        radiance: ArrayLike | Mapping[str, ArrayLike],
        seen: ArrayLike | None,
        hints: Hints,
        arguments: Arguments,
        width: int | None,
    ) -> None:
        """Set all pixels from a picture in any layout."""
        columns = None if width is None else checked_width(width)
        picture, given = self._arranged(radiance, seen, hints, arguments)
        linear = self._linear(picture.samples, picture.seen)
        linear, share = self._seen_light(linear, picture.seen, given)
        cleaned, level = _cleaning.clean(linear, self._notes)
        self._white = level if self._white is None else self._white
        image, share, is_border = resampling.on_sphere(cleaned, share, picture.layout, columns)
        if image.shape != cleaned.shape:
            self._notes += _note_of_conversion(picture.source, image)
            if self._white is not None:
                image = np.minimum(image, np.float32(self._white))
        self._keep(image, share, is_border, picture.source)

    def _arranged(
        self,
        radiance: ArrayLike | Mapping[str, ArrayLike],
        seen: ArrayLike | None,
        hints: Hints,
        arguments: Arguments,
    ) -> tuple[ArrangedPicture, NDArray[np.float32] | None]:
        """Picture with its layout and the share of its alpha, and the share that is given."""
        if isinstance(radiance, Mapping):
            radiance, order = faces_of_mapping(radiance)
            hints = hints._replace(order=order)
        array = image_array(radiance, self._notes, "a map")
        picture = recognise(array.samples, hints, arguments, array.seen)
        self._notes += picture.notes
        if seen is None:
            return picture, None
        share = _visibility.checked_seen(seen, array.samples.shape[:-1])
        return picture, recognise(array.samples, hints, arguments, share).seen

    def _keep(
        self,
        radiance: NDArray[np.float32],
        seen: NDArray[np.float32] | None,
        is_border: bool,
        source: Source,
    ) -> None:
        """Keep the pixels of the map, and note what is not seen."""
        self._clipped: tuple[float, float] | None = None
        self._registration, self._source = REGISTRATIONS[is_border], source
        self._seen: NDArray[np.float32] | None = None
        self._radiance = _read_only(radiance)
        if seen is None or (share := _visibility.checked_seen(seen, radiance.shape[:2])) is None:
            return
        self._seen = _read_only(share)
        note = _visibility.note_of_unseen(self.coverage_fraction)
        if note not in self._notes:
            self._notes.append(note)

    @property
    def radiance(self) -> NDArray[np.float32]:
        """Linear RGB, (height, width, 3), read-only."""
        return self._radiance

    @property
    def projection(self) -> str:
        """Layout of the sphere in `radiance`: "equirectangular"; `source` has that of the input."""
        return PROJECTION

    @property
    def source(self) -> Source:
        """Picture from which the map was made: its layout, and how it was recognised."""
        return self._source

    @property
    def registration(self) -> str:
        """Layout of the pixels: "cell-centred" or "border-sampled"."""
        return self._registration

    @property
    def is_border_sampled(self) -> bool:
        """True if the outer pixels lie on the seam and the poles."""
        return self._registration == REGISTRATIONS[1]

    @property
    def notes(self) -> tuple[Note, ...]:
        """Remarks on samples that were changed and on assumptions; `code` has the kind of each."""
        return tuple(map(Note, self._notes))

    @property
    def white(self) -> float | None:
        """Clip level: the largest value that the radiance can hold; None if unknown."""
        return self._white

    @property
    def units(self) -> str:
        """Unit of the radiance: "cd/m2" for its luminance, or "the map's own scale".

        `calibrated` sets it. Irradiance of a map in cd/m2 has a luminance in lux.
        """
        return self._units

    @property
    def ev100(self) -> float | None:
        """Exposure value at ISO 100 of the picture, from the EXIF of its file; None if unknown.

        Known for JPEG and TIFF files of integers with exposure time, aperture and sensitivity, and
        for a merged series of them.
        """
        return self._ev100

    @property
    def clipped_fraction(self) -> float:
        """Fraction of the sphere with clipped radiance.

        With a known `white`: pixels with a channel at it, from code 254 of 255 on. Otherwise:
        pixels with the largest sample of the map, if there are several.
        """
        return self._clipped_fractions()[0]

    @property
    def clipped_flux_fraction(self) -> float:
        """Fraction of the luminance flux in clipped pixels.

        Lights that `fit` places there are a lower bound.
        """
        return self._clipped_fractions()[1]

    @property
    def seen(self) -> NDArray[np.float32] | None:
        """Share of each pixel that is seen, (height, width); None if all is."""
        return self._seen

    @property
    def coverage_fraction(self) -> float:
        """Fraction of the sphere that is seen."""
        if self._seen is None:
            return 1.0
        return _visibility.share_of_sphere(self._seen, self.is_border_sampled)

    @property
    def height(self) -> int:
        """Rows."""
        return int(self._radiance.shape[0])

    @property
    def width(self) -> int:
        """Columns."""
        return int(self._radiance.shape[1])

    def cells(self) -> NDArray[np.float32]:
        """Radiance of a cell-centred map of the same size and flux."""
        if self.is_border_sampled:
            return resampling.cells_of_borders(self._radiance)
        return self._radiance

    def __repr__(self) -> str:
        layout = f"{self.width}x{self.height} {PROJECTION}, {self._registration}"
        notes = f", notes: {'; '.join(self._notes)}" if self._notes else ""
        clipped, unit = self._clipped_in_words(), in_nits(self._units)
        units = f",{unit}" if unit else ""
        return f"{type(self).__name__}({layout}{units}{clipped}{notes})"

    def __str__(self) -> str:
        layout = f"{self.width}x{self.height} pixels, {PROJECTION}, {self._registration}"
        white = f"clip level {self._white:g}{self._clipped_in_words()}" if self._white else ""
        unit = in_nits(self._units)
        return _map_text.paragraph(self._radiance, layout, white, self._notes, unit)

    def _clipped_in_words(self) -> str:
        """Clipped part of a map with a clip level; empty for other maps."""
        return "" if self._white is None else _map_text.clipped(*self._clipped_fractions())

    def _repr_pretty_(self, printer: Any, _: bool) -> None:
        printer.text(repr(self) if printer.indentation else str(self))

    def _repr_html_(self) -> str:
        picture = _html.picture(_thumbnails.of_map(self._radiance), "the map")
        return _html.block(type(self).__name__, "", picture, _html.lines(str(self)))

    def __eq__(self, other: object) -> bool:
        """True if radiance, units, layout, clip level and seen share are equal."""
        if not isinstance(other, MapPixels):
            return NotImplemented
        layout, others = ((e.units, e.registration, e.white) for e in (self, other))
        if layout != others or (self.seen is None) != (other.seen is None):
            return False
        is_equal = self.seen is None or np.array_equal(self.seen, other.seen)  # type: ignore[arg-type]
        return is_equal and np.array_equal(self.radiance, other.radiance)

    __hash__: ClassVar[None] = None  # type: ignore[assignment]  # what is compared by its pixels

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        """Radiance as an array, for NumPy."""
        return convert(self._radiance, dtype, copy)

    def __reduce__(self) -> tuple[Any, ...]:
        layout: dict[str, Any] = {"projection": PROJECTION, "registration": self._registration}
        layout |= {"notes": self._notes, "white": self._white, "seen": self._seen}
        build = partial(type(self), **layout, units=self._units)
        return build, (self._radiance,), {"_source": self._source, "_ev100": self._ev100}

    def with_radiance(
        self, radiance: NDArray[np.float32], notes: Iterable[str], *, keeps_clip_level: bool = True
    ) -> Self:
        """Map of other samples at the same places.

        Parameters
        ----------
        radiance : ndarray of float32, shape (height, width, 3)
            Multiplied by `seen`; not checked.
        notes : iterable of str
            All notes of the new map.
        keeps_clip_level : bool
            False for radiance that was estimated above the clip level.

        Returns
        -------
        EnvMap
            Registration, clip level, seen part, source, units and exposure are those of this map.
        """
        env = type(self).unchecked(
            radiance,
            registration=self._registration,
            notes=notes,
            white=self._white if keeps_clip_level else None,
            seen=self._seen,
            source=self._source,
        )
        return self._of_same_scale(env)

    def _of_same_scale(self, env: Self) -> Self:
        """`env` with the units and the exposure of this map."""
        env._units, env._ev100 = self._units, self._ev100
        return env

    def _clipped_fractions(self) -> tuple[float, float]:
        if self._clipped is None:
            self._clipped = _native.clipped_fraction(
                self._radiance, self.is_border_sampled, self._white
            )
        return self._clipped

    def _seen_light(
        self,
        linear: NDArray[np.float32],
        of_array: NDArray[np.float32] | None,
        given: NDArray[np.float32] | None,
    ) -> tuple[NDArray[np.float32], NDArray[np.float32] | None]:
        """Radiance that is black where nothing is seen, and the seen share."""
        if of_array is not None:
            linear = _visibility.multiply_by_share(linear, of_array)
        share = of_array
        if given is not None:
            share = given if share is None else share * given
        if share is None or (share == 1).all():
            return linear, None
        return _visibility.multiply_by_share(linear, np.float32(1) * (share > 0)), share

    def _linear(self, array: NDArray[Any], seen: NDArray[np.float32] | None) -> NDArray[np.float32]:
        """Linear samples of `array`; the clip level of codes is that of pixels that are seen."""
        if array.dtype.kind != "f" and self._white is None:
            self._white = clip_level_of_codes(array, seen, self._notes)
        return _cleaning.linear(array, self._notes)


def checked_width(width: int) -> int:
    """Columns of a map, or a refusal."""
    columns = count("width", width, least=4)
    if columns % 2 or columns * columns > 2 * MOST_PIXELS:
        raise EnvLightsError(f"width must be an even number of columns, up to 32768; got {columns}")
    return columns


def _note_of_conversion(source: Source, image: NDArray[np.float32]) -> list[str]:
    """Note on the layout and the size of the picture from which a map was made."""
    (rows, columns), (height, width) = source.size, image.shape[:2]
    return [f"{source.projection} of {columns}x{rows} pixels, converted to {width}x{height} cells"]


def _read_only(array: NDArray[np.float32]) -> NDArray[np.float32]:
    view = array.view()
    view.flags.writeable = False
    return view


def checked_clip_level(white: float) -> float:
    """Clip level as a number above 0, or a refusal."""
    value = amount("white", white)
    if value == 0:
        raise EnvLightsError("white must be above 0; got 0")
    return value
