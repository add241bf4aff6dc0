"""Lights of a photograph, as pixel positions, and as directions if its field of view is known."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common import html
from envlights._common.arrays import seal
from envlights._common.check import amount, counts, flag, reals
from envlights._common.files import write_atomically
from envlights._common.result import Result
from envlights._common.tables import MOST_ROWS, Table, frame_of
from envlights._common.words import percent
from envlights._native import EnvLightsError
from envlights.detection.lights import DetectionReport
from envlights.environment.envmap import EnvMap
from envlights.export import saving
from envlights.export.formats.own_json import read_json
from envlights.kernels import thumbnails
from envlights.kernels.image import LUMINANCE
from envlights.rigs.light_arrays import light_arrays, row_of, rows_of
from envlights.rigs.lights import Lights, Rows, brightest_first, rgb_cell

if TYPE_CHECKING:
    import pandas as pd

_KIND, _VERSION = "lights of a photograph", 1
#: First line of a CSV file of positions.
_TABLE = "# envlights CSV of a photograph, version 1"
#: Description of the coordinate frame in `to_dict`.
_FRAME = "of the photograph: it looks along +z, its right is -x, its upper side +y"
_UNITS = (
    "position: x, y in pixels of the photograph from its top left corner; peak_pixel: row, column;"
    " pixel_flux: radiance times pixels of the photograph; irradiance: at normal incidence; all"
    " linear Rec.709 RGB; samples: row, column in the working size"
)
#: Array fields with a row per light; the last two are None without a field of view.
_ARRAYS = ("position", "pixel_flux", "peak_pixel", "peak_luminance", "flux_fraction", "is_clipped")
_WITH_FIELD = ("direction", "irradiance")
#: Array fields of samples: pixels, and indices.
_PIXELS, _INDICES = ("first", "pixel", "maximum"), ("survivor", "light")
#: Columns of a data frame beside those of `_SCALARS`; the last ones need a field of view.
_COLUMNS = ("x_px", "y_px", "red", "green", "blue")
_MORE_COLUMNS = ("irradiance_red", "irradiance_green", "irradiance_blue", "x", "y", "z")
#: Numeric array fields in a data frame.
_SCALARS = ("fraction", "luminance", "peak_luminance", "is_clipped")


@dataclass(frozen=True, eq=False, repr=False)
class PhotographSamples(Result):
    """Samples of the lights, brightest first, in pixels of the working size."""

    first: NDArray[np.int64]
    """Row and column of each sample at its first position, shape (k, 2)."""

    pixel: NDArray[np.int64]
    """Row and column of each sample, after a move to a maximum, shape (k, 2)."""

    maximum: NDArray[np.int64]
    """Row and column of the brightest pixel in the window of each sample, shape (k, 2)."""

    survivor: NDArray[np.int64]
    """Index of the sample that suppresses each sample, or its own index, shape (k,)."""

    light: NDArray[np.int64]
    """Index of the light of each sample, shape (k,)."""

    def in_short(self) -> str:
        """Number of samples."""
        return f"{len(self.pixel)} samples"

    @classmethod
    def checked(cls, data: Mapping[str, Any], lights: int) -> PhotographSamples:
        """Samples from the dictionary of a file, after a check that indices are in range."""
        first, pixel, maximum = (_rows(name, data[name], 2).astype(np.int64) for name in _PIXELS)
        survivor, light = (reals(name, data[name], 1).astype(np.int64) for name in _INDICES)
        count = len(survivor)
        if any(len(array) != count for array in (first, pixel, maximum, light)):
            raise EnvLightsError("samples must have arrays of one length")
        for name, array, most in zip(_INDICES, (survivor, light), (count, lights), strict=True):
            if not ((array >= 0) & (array < most)).all():
                raise EnvLightsError(f"{name} of the samples must be indices below {most}")
        return cls(first, pixel, maximum, survivor, light)

    def of(self, kept: NDArray[np.intp], lights: int) -> PhotographSamples:
        """Samples of the `kept` lights, renumbered; `lights` is the original number."""
        place = np.full(lights, -1)
        place[kept] = np.arange(len(kept))
        light = place[self.light]
        # A sample and its suppressing sample belong to the same light.
        number = np.cumsum(light >= 0) - 1
        arrays = self.first, self.pixel, self.maximum, number[self.survivor], light
        return PhotographSamples(*(array[light >= 0] for array in arrays))


@dataclass(frozen=True, eq=False, repr=False)
class PhotographLight(Result):
    """Single light of a photograph, the type of ``lights[0]``; see `PhotographLights`."""

    position: NDArray[np.float64]
    pixel_flux: NDArray[np.float64]
    peak_pixel: NDArray[np.int64]
    peak_luminance: float
    flux_fraction: float
    is_clipped: bool
    direction: NDArray[np.float64] | None = None
    irradiance: NDArray[np.float64] | None = None

    @property
    def luminance(self) -> float:
        """Luminance of the flux; see `PhotographLights.luminance`."""
        return float(self.pixel_flux @ LUMINANCE)

    def in_short(self) -> str:
        """Position of the light, and its fraction of the flux."""
        x, y = self.position
        return f"x {x:.1f}, y {y:.1f}, {percent(self.flux_fraction)}"

    def __str__(self) -> str:
        if self.direction is None or self.irradiance is None:
            return self.in_short()
        forward = ", ".join(f"{value:.4f}" for value in self.direction)
        received = ", ".join(f"{value:.4g}" for value in self.irradiance)
        return f"{self.in_short()}\ndirection {forward}; irradiance {received}"


@dataclass(frozen=True, eq=False, repr=False)
class PhotographLights(Result):
    """Lights of a photograph, brightest first.

    Each array has a row for each light. `lights[:4]` holds the first four with their samples;
    `report` still describes the whole detection. With directions, `discs` are lights for a scene,
    in the frame of the photograph.
    """

    position: NDArray[np.float64]
    """Position (x, y) of each light, in pixels from the top left corner of the photograph, (n, 2).

    The centre of the first pixel is at (0.5, 0.5)."""

    pixel_flux: NDArray[np.float64]
    """Radiance of each light summed over pixels of the photograph, linear RGB, (n, 3)."""

    peak_pixel: NDArray[np.int64]
    """Row and column of the brightest sample of each light in the photograph, (n, 2)."""

    peak_luminance: NDArray[np.float64]
    """Luminance at this pixel, (n,)."""

    flux_fraction: NDArray[np.float64]
    """Fraction of the luminance of the whole photograph, (n,)."""

    is_clipped: NDArray[np.bool_]
    """True for lights that are clipped at the largest possible value, or have a flat top, (n,)."""

    samples: PhotographSamples
    """Samples of the lights."""

    report: DetectionReport
    """Report of the detection."""

    size: tuple[int, int]
    """Height and width of the photograph."""

    field_of_view: float | None = None
    """Horizontal field of view in radians; None if unknown."""

    direction: NDArray[np.float64] | None = None
    """Unit vectors to the lights, (n, 3); None without a field of view.

    They are in the frame of the photograph: it looks along +z, its right is -x, its upper side
    +y."""

    irradiance: NDArray[np.float64] | None = None
    """Linear RGB at normal incidence, (n, 3); None without a field of view.

    The background behind a light is included."""

    picture: NDArray[np.uint8] = field(
        default_factory=lambda: np.zeros((1, 1, 3), np.uint8), compare=False
    )
    """Reduced photograph for display, sRGB codes, (rows, columns, 3)."""

    def __post_init__(self) -> None:
        order = brightest_first(np.asarray(self.pixel_flux))
        for name in self._array_names():
            object.__setattr__(self, name, seal(np.asarray(getattr(self, name))[order]))
        object.__setattr__(self, "samples", self.samples.of(order, len(order)))

    def __len__(self) -> int:
        return len(self.position)

    @overload
    def __getitem__(self, which: int) -> PhotographLight: ...

    @overload
    def __getitem__(self, which: Rows) -> PhotographLights: ...

    def __getitem__(self, which: int | Rows) -> PhotographLight | PhotographLights:
        """A single light, or the lights selected by a slice, a list of indices or a mask."""
        kept = rows_of(which, len(self))
        if kept is None:
            return self._light(row_of(which, len(self)))
        values = {each.name: getattr(self, each.name) for each in fields(self)}
        values |= {name: values[name][kept] for name in self._array_names()}
        values["samples"] = self.samples.of(kept, len(self))
        return PhotographLights(**values)

    def __iter__(self) -> Iterator[PhotographLight]:
        return (self._light(row) for row in range(len(self)))

    def _light(self, row: int) -> PhotographLight:
        rows = {name: getattr(self, name)[row] for name in self._array_names()}
        plain = {name: value if np.ndim(value) else value.item() for name, value in rows.items()}
        return PhotographLight(**plain)

    def _array_names(self) -> tuple[str, ...]:
        """Names of the array fields with a row per light."""
        return _ARRAYS if self.direction is None else (*_ARRAYS, *_WITH_FIELD)

    @property
    def luminance(self) -> NDArray[np.float64]:
        """Luminance of each light, summed over pixels of the photograph, (n,)."""
        values: NDArray[np.float64] = self.pixel_flux @ LUMINANCE
        return values

    @property
    def fraction(self) -> NDArray[np.float64]:
        """Fraction of the luminance of the whole photograph, an alias of `flux_fraction`, (n,)."""
        return self.flux_fraction

    def in_short(self) -> str:
        """Number of lights, and the size and field of view of the photograph."""
        height, width = self.size
        view = "" if self.field_of_view is None else f", {np.rad2deg(self.field_of_view):.3g}° wide"
        return f"{len(self)} light{'' if len(self) == 1 else 's'}, {width}x{height} pixels{view}"

    def __str__(self) -> str:
        return f"{self._heading()}\n\n{self.report}"

    def verbose(self) -> str:
        """Text with all details of the report."""
        return f"{self._heading()}\n\n{self.report.verbose()}"

    def _heading(self) -> str:
        return str(self.table()) if len(self) else "no light"

    def _html_parts(self) -> tuple[str, ...]:
        picture = html.picture(thumbnails.nearest_columns(self.picture), "the photograph")
        return (
            picture,
            *([self.table().html()] if len(self) else ()),
            html.lines(str(self.report)),
        )

    def table(self) -> Table:
        """Table of the first dozen lights, and a summary of the others."""
        hidden = self.fraction[MOST_ROWS:]
        lights = "light" if len(hidden) == 1 else "lights"
        summary = f"{len(hidden)} more {lights}, {percent(hidden.sum(), 2)} together"
        colours = thumbnails.hex_of(self.pixel_flux[:MOST_ROWS])
        rows = [self._cells(row) for row in range(min(len(self), MOST_ROWS))]
        last = ["direction", "irradiance (R, G, B)"]
        if self.direction is None:
            last = ["radiance x pixels (R, G, B)"]
        columns = ["light", "x", "y", "fraction", "peak", *last, ""]
        return Table(columns, rows, summary if len(hidden) else "", colours)

    def _cells(self, row: int) -> list[str]:
        x, y = self.position[row]
        place = [f"{row + 1}", f"{x:.1f}", f"{y:.1f}", f"{100 * self.flux_fraction[row]:.1f} %"]
        place.append(f"{self.peak_luminance[row]:.4g}")
        remark = "clipped" if self.is_clipped[row] else ""
        if self.direction is None or self.irradiance is None:
            return [*place, rgb_cell(self.pixel_flux[row]), remark]
        forward = "  ".join(f"{value:+.3f}" for value in self.direction[row])
        return [*place, forward, rgb_cell(self.irradiance[row]), remark]

    def discs(self) -> Lights:
        """Lights as points, in the frame of the photograph; raises an error without directions."""
        if self.direction is None or self.irradiance is None:
            raise EnvLightsError(
                "the lights of this photograph have no directions, because its field of view is"
                " unknown; give fov= to `detect_photograph`"
            )
        return Lights(self.direction, self.irradiance)

    def to_frame(self) -> pd.DataFrame:
        """Data frame with a row per light and a column per component; needs pandas."""
        return frame_of(self._frame_columns())

    def _frame_columns(self) -> dict[str, NDArray[Any]]:
        columns = dict(zip(_COLUMNS, [*self.position.T, *self.pixel_flux.T], strict=True))
        columns |= {name: getattr(self, name) for name in _SCALARS}
        if self.direction is None or self.irradiance is None:
            return columns
        return columns | dict(
            zip(_MORE_COLUMNS, [*self.irradiance.T, *self.direction.T], strict=True)
        )

    def save(
        self,
        path: str | os.PathLike[str],
        environment: EnvMap | ArrayLike | None = None,
        **options: Any,
    ) -> None:
        """Write the lights in the format of the suffix; a failure leaves no file.

        Parameters
        ----------
        path : path-like
            ``.json`` keeps everything but the picture, and `load` reads it. ``.csv`` without
            directions is a table of places. The other formats of `Lights.save` need directions.
        environment : EnvMap or array_like, optional
            Map around the lights, for formats that accept one.
        **options
            Further arguments of the target's writer: ``up="z"`` of OpenUSD, ``scale=`` of MuJoCo.

        Raises
        ------
        EnvLightsError
            If the format needs directions, and there are none.
        """
        target = saving.target_for(path, environment, options).name
        if target == "csv" and self.direction is None:
            write_atomically(path, lambda beside: beside.write_text(self._csv(), encoding="utf-8"))
            return
        saving.save(self if target == "json" else self.discs(), path, environment, **options)

    def _csv(self) -> str:
        """CSV text with a row per light, for spreadsheets."""
        columns, (height, width) = self._frame_columns(), self.size
        about = (
            f"# {width}x{height} pixels; x, y from the top left corner; red, green, blue: linear"
        )
        lines = [_TABLE, f"{about} Rec.709 radiance times pixels", ",".join(columns)]
        numbers = [array + 0 for array in columns.values()]  # converts False to 0
        rows = zip(*(array.tolist() for array in numbers), strict=True)
        return "\n".join([*lines, *(",".join(map(repr, row)) for row in rows)]) + "\n"

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> PhotographLights:
        """Read lights that `save` wrote as ``.json``, without times and picture."""
        return read_json(path, _KIND, (_VERSION,), _from_dict)

    def to_dict(self) -> dict[str, Any]:
        """All fields except times and picture as plain numbers, lists and strings."""
        arrays = {name: getattr(self, name).tolist() for name in self._array_names()}
        samples = {name: getattr(self.samples, name).tolist() for name in (*_PIXELS, *_INDICES)}
        return {
            "format": f"envlights {_KIND}",
            "version": _VERSION,
            "frame": _FRAME,
            "units": _UNITS,
            "size": list(self.size),
            "field_of_view": self.field_of_view,
            **dict.fromkeys(_WITH_FIELD),
            **arrays,
            "samples": samples,
            "report": self.report.to_dict(),
        }


def _from_dict(data: dict[str, Any]) -> PhotographLights:
    """Lights from the dictionary of `to_dict`, after checks; without the picture."""
    lights = len(data["position"])
    arrays: dict[str, Any] = {
        "position": _rows("position", data["position"], 2),
        "pixel_flux": _rows("pixel_flux", data["pixel_flux"], 3),
        "peak_pixel": _rows("peak_pixel", data["peak_pixel"], 2).astype(np.int64),
        "peak_luminance": reals("peak_luminance", data["peak_luminance"], 1),
        "flux_fraction": reals("flux_fraction", data["flux_fraction"], 1),
        "is_clipped": np.array([flag("is_clipped", each) for each in data["is_clipped"]], bool),
    }
    if data["direction"] is not None:
        given = (_rows(name, data[name], 3) for name in _WITH_FIELD)
        arrays["direction"], arrays["irradiance"] = light_arrays(*given)
    for name, array in arrays.items():
        is_usable = name == "direction" or (np.isfinite(array).all() and (array >= 0).all())
        if len(array) != lights or not is_usable:
            raise EnvLightsError(f"{name} must have {lights} rows of finite numbers from 0 on")
    height, width = counts("size", data["size"])
    view = data["field_of_view"]
    return PhotographLights(
        **arrays,
        samples=PhotographSamples.checked(data["samples"], lights),
        report=DetectionReport.from_dict(data["report"]),
        size=(height, width),
        field_of_view=None if view is None else amount("field_of_view", view, most=np.pi),
    )


def _rows(name: str, values: Any, columns: int) -> NDArray[np.float64]:
    """Two-dimensional array of rows; an empty list becomes shape (0, columns)."""
    return reals(name, np.reshape(values, (-1, columns)), 2)


# Register as a sequence, although `count` and `index` are missing.
Sequence.register(PhotographLights)
