"""Pixels of an environment map: radiance, layout on the sphere, clip level and notes."""

from __future__ import annotations

import os
from collections.abc import Iterable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _cleaning, _html, _map_text, _native, _thumbnails, _visibility, resampling
from envlights._arrays import convert
from envlights._check import amount, check_choice, describe, texts
from envlights._map_array import map_array
from envlights._native import EnvLightsError
from envlights._white import white_of_codes

if TYPE_CHECKING:
    from typing_extensions import Self

PROJECTIONS = ("equirectangular",)
REGISTRATIONS = ("cell-centred", "border-sampled")


class MapPixels:
    """Radiance of all pixels with their layout, clip level and notes; see `EnvMap`."""

    def __init__(
        self,
        radiance: ArrayLike,
        *,
        projection: str = "equirectangular",
        registration: str = "cell-centred",
        notes: str | Iterable[str] = (),
        white: float | None = None,
        seen: ArrayLike | None = None,
    ) -> None:
        check_choice("projection", projection, PROJECTIONS)
        check_choice("registration", registration, REGISTRATIONS)
        self._white = None if white is None else checked_white(white)
        self._clipped: tuple[float, float] | None = None
        self._notes = texts("notes", notes)
        self._projection, self._registration = projection, registration
        if isinstance(radiance, str | os.PathLike):
            raise EnvLightsError(
                "a map must be an array; `EnvMap.open` reads files; got"
                f" {describe(os.fspath(radiance))}"
            )
        array = map_array(radiance, self._notes)
        linear = self._with_seen(self._linear(array.samples, array.seen), array.seen, seen)
        cleaned, level = _cleaning.clean(linear, self._notes)
        self._white = level if self._white is None else self._white
        self._radiance = _read_only(cleaned)

    @classmethod
    def unchecked(
        cls,
        radiance: ArrayLike,
        *,
        registration: str = REGISTRATIONS[0],
        notes: Iterable[str] = (),
        white: float | None = None,
        seen: NDArray[np.float32] | None = None,
    ) -> Self:
        """Map without a check of its samples, for arrays that a kernel checks or has made."""
        env = cls.__new__(cls)
        env._notes = list(notes)
        env._projection, env._registration = PROJECTIONS[0], registration
        env._white, env._clipped = white, None
        array = map_array(radiance, env._notes)
        linear = env._linear(array.samples, array.seen)
        env._radiance = _read_only(env._with_seen(linear, array.seen, seen))
        return env

    @property
    def radiance(self) -> NDArray[np.float32]:
        """Linear RGB, (height, width, 3), read-only."""
        return self._radiance

    @property
    def projection(self) -> str:
        """Layout of the sphere in the image."""
        return self._projection

    @property
    def registration(self) -> str:
        """Layout of the pixels: "cell-centred" or "border-sampled"."""
        return self._registration

    @property
    def is_border_sampled(self) -> bool:
        """True if the outer pixels lie on the seam and the poles."""
        return self._registration == REGISTRATIONS[1]

    @property
    def notes(self) -> tuple[str, ...]:
        """Remarks on samples that were changed and on assumptions."""
        return tuple(self._notes)

    @property
    def white(self) -> float | None:
        """Clip level: the largest value that the radiance can hold; None if unknown."""
        return self._white

    @property
    def clipped_share(self) -> float:
        """Fraction of the sphere with clipped radiance.

        With a known `white`: pixels with a channel at it, from code 254 of 255 on. Otherwise:
        pixels with the largest sample of the map, if there are several.
        """
        return self._clipped_shares()[0]

    @property
    def clipped_flux_share(self) -> float:
        """Fraction of the luminance flux in clipped pixels.

        Lights that `fit` places there are a lower bound.
        """
        return self._clipped_shares()[1]

    @property
    def seen(self) -> NDArray[np.float32] | None:
        """Share of each pixel that is seen, (height, width); None if all is."""
        return self._seen

    @property
    def seen_share(self) -> float:
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
        layout = f"{self.width}x{self.height} {self._projection}, {self._registration}"
        notes = f", notes: {'; '.join(self._notes)}" if self._notes else ""
        return f"{type(self).__name__}({layout}{self._clipped_in_words()}{notes})"

    def __str__(self) -> str:
        layout = f"{self.width}x{self.height} pixels, {self._projection}, {self._registration}"
        white = f"clip level {self._white:g}{self._clipped_in_words()}" if self._white else ""
        return _map_text.paragraph(self._radiance, layout, white, self._notes)

    def _clipped_in_words(self) -> str:
        """Clipped part of a map with a clip level; empty for other maps."""
        return "" if self._white is None else _map_text.clipped(*self._clipped_shares())

    def _repr_pretty_(self, printer: Any, _: bool) -> None:
        printer.text(repr(self) if printer.indentation else str(self))

    def _repr_html_(self) -> str:
        picture = _html.picture(_thumbnails.of_map(self._radiance), "the map")
        return _html.block(type(self).__name__, "", picture, _html.lines(str(self)))

    def __eq__(self, other: object) -> bool:
        """True if radiance, layout, clip level and seen share are equal."""
        if not isinstance(other, MapPixels):
            return NotImplemented
        layout, others = ((e.projection, e.registration, e.white) for e in (self, other))
        if layout != others or (self.seen is None) != (other.seen is None):
            return False
        is_equal = self.seen is None or np.array_equal(self.seen, other.seen)  # type: ignore[arg-type]
        return is_equal and np.array_equal(self.radiance, other.radiance)

    __hash__ = None  # type: ignore[assignment]  # what is compared by its pixels

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        """Radiance as an array, for NumPy."""
        return convert(self._radiance, dtype, copy)

    def __reduce__(self) -> tuple[Any, ...]:
        layout = {"projection": self._projection, "registration": self._registration}
        build = partial(type(self), **layout, notes=self._notes, white=self._white, seen=self._seen)
        return build, (self._radiance,)

    def _clipped_shares(self) -> tuple[float, float]:
        if self._clipped is None:
            self._clipped = _native.clipped_share(
                self._radiance, self.is_border_sampled, self._white
            )
        return self._clipped

    def _with_seen(
        self,
        linear: NDArray[np.float32],
        of_array: NDArray[np.float32] | None,
        seen: ArrayLike | None,
    ) -> NDArray[np.float32]:
        """Set the seen share, and return radiance that is black where nothing is seen."""
        self._seen: NDArray[np.float32] | None = None
        if of_array is not None:
            linear = _visibility.multiply_by_share(linear, of_array)
        share = of_array
        if seen is not None:
            given = _visibility.checked_seen(seen, linear.shape[:2])
            share = given if share is None else share if given is None else share * given
        if share is None:
            return linear
        self._seen = _visibility.checked_seen(share, linear.shape[:2])
        if self._seen is None:
            return linear
        self._seen.flags.writeable = False
        note = _visibility.note_of_unseen(self.seen_share)
        if note not in self._notes:
            self._notes.append(note)
        return _visibility.multiply_by_share(linear, np.float32(1) * (self._seen > 0))

    def _linear(self, array: NDArray[Any], seen: NDArray[np.float32] | None) -> NDArray[np.float32]:
        """Linear samples of `array`; the clip level of codes is that of pixels that are seen."""
        if array.dtype.kind != "f" and self._white is None:
            self._white = white_of_codes(array, seen, self._notes)
        return _cleaning.linear(array, self._notes)


def _read_only(array: NDArray[np.float32]) -> NDArray[np.float32]:
    view = array.view()
    view.flags.writeable = False
    return view


def checked_white(white: float) -> float:
    """Clip level as a number above 0, or a refusal."""
    value = amount("white", white)
    if value == 0:
        raise EnvLightsError("white must be above 0; got 0")
    return value
