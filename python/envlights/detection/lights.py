"""Detected lights with their measurements, and the report of the detection."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.arrays import seal
from envlights._common.check import flag, reals, rotation
from envlights._common.fields import fields_of, read_fields
from envlights._common.former import former_attributes
from envlights._common.result import Result
from envlights._common.tables import MOST_ROWS
from envlights._common.times import time_lines
from envlights._common.units import OWN_SCALE, checked_units, statement
from envlights._common.words import percent
from envlights._native import EnvLightsError
from envlights.detection import measurements
from envlights.detection.members import LeftOut, Members
from envlights.export.formats.own_json import read_json
from envlights.kernels.sphere import FRAME
from envlights.rigs.light import DetectedLight, remarks_of
from envlights.rigs.light_arrays import light_arrays, rotate, row_of, rows_of
from envlights.rigs.lights import (
    Lights,
    Rows,
    brightest_first,
    origins,
    place_cells,
    rgb_cell,
    rgb_heading,
)

if TYPE_CHECKING:
    from typing_extensions import Self

_KIND, _VERSION = "detected lights", 3
#: Readable file versions; version 2 had no units, and always members.
_READABLE_VERSIONS = (2, 3)
_UNITS = (
    "irradiance: at normal incidence, above the local background; flux: integral of radiance over"
    " the light; both linear Rec.709 RGB; solid_angle: steradians; other angles: radians;"
    " peak_luminance: radiance; members: light, row, first column and length of runs of pixels"
)
#: Solid angle, in steradians, above which a light is broad.
_BROAD = 0.5


@dataclass(frozen=True, eq=False, repr=False)
class DetectionReport(Result):
    """Report of a detection: its threshold, and lights that were not listed."""

    method: str
    """Detector: "tree" or "loghin"."""

    threshold: float
    """Luminance above which a pixel is bright."""

    reason: str
    """Rule that determined the threshold."""

    working_size: tuple[int, int]
    """Height and width of the reduced map in which lights were detected."""

    clip_level: float | None = None
    """Luminance at which the map is clipped; None for unclipped maps, and for "loghin"."""

    skipped: tuple[str, ...] = ()
    """Sentences on dropped or merged lights, or on why there are none."""

    notes: tuple[str, ...] = ()
    """Notes on the map and on single lights."""

    remainder: tuple[float, ...] | None = None
    """Mean radiance of the map without the lights, linear RGB; None for "loghin"."""

    details: tuple[str, ...] = ()
    """Numbers for developers of detectors, printed by ``envlights detect --verbose``."""

    seconds: Mapping[str, float] = field(default_factory=dict, compare=False)
    """Wall time of each stage."""

    def to_dict(self) -> dict[str, Any]:
        """All fields except the times as plain numbers, lists and strings."""
        return fields_of(self)

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> DetectionReport:
        """Report from the dictionary that `to_dict` returned."""
        return read_fields(cls, data)

    def in_short(self) -> str:
        """Method and threshold."""
        return f"{self.method}, threshold {self.threshold:.4g}"

    def _lines(self) -> list[str]:
        clipped = (
            "; clipped map: lights are separated by the depth of their clipped regions, and ordered"
            " by an estimate of their brightness; the light of clipped ones is a lower bound:"
            " `envlights split --sun` or `with_sun` finds a clipped sun, and `envlights repair` or"
            " `repaired` estimates other light that was cut off"
        )
        return [
            f"threshold {self.threshold:.3g} ({self.reason}){clipped if self.clip_level else ''}",
            *self.skipped,
            *(f"note: {note}" for note in self.notes),
        ]

    def _details(self) -> list[str]:
        height, width = self.working_size
        return [
            f"method: {self.method}, on a working map of {width}x{height} pixels",
            *self.details,
            *time_lines(self.seconds),
        ]


#: Fields that are not arrays with a row per light.
_NO_ARRAYS = ("members", "report", "units", "notes", "origin")


@former_attributes(share="fraction", flux_share="flux_fraction")
@dataclass(frozen=True, eq=False, repr=False)
class DetectedLights(Lights):
    r"""Lights of a map, brightest first, with the measurements of each light.

    `irradiance` is that of a surface facing the light, above the local background :math:`B`:
    :math:`|\int (L - B)\, \omega\, d\omega|`, as in all `Lights`. A rig of these lights, with the
    background as its ambient term, has the irradiance of the map.

    Each array has a row for each light. `lights[:4]` holds the first four with their members;
    `report` still describes the whole detection.

    Examples
    --------
    >>> import envlights as el
    >>> lamp = el.synthetic.Disc((1, 0, 0), 5.0, (9, 9, 9))
    >>> lights = el.detect(el.synthetic.scene(128, background=[0.1] * 3, shapes=[lamp]).radiance)
    >>> len(lights), lights.direction.round(2) + 0.0
    (1, array([[1., 0., 0.]]))
    """

    angular_radius: NDArray[np.float64] = field(init=False)
    """Radius in radians of a disc with the same solid angle, shape (n,).

    The error is below 5 % for discs that are at least two pixels wide. The pixels of a narrower
    disc do not determine its radius: a smaller and brighter disc can have the same pixels."""

    peak_direction: NDArray[np.float64]
    """Unit vectors to the peak of each light, shape (n, 3)."""

    solid_angle: NDArray[np.float64]
    """Solid angle of each light in steradians, shape (n,)."""

    elongation: NDArray[np.float64]
    """Ratio of length to width, shape (n,); 1 for a disc."""

    orientation: NDArray[np.float64]
    """Unit vectors along the long axis of each light, orthogonal to its direction, shape (n, 3)."""

    peak_luminance: NDArray[np.float64]
    """Luminance at the peak, shape (n,)."""

    flux_fraction: NDArray[np.float64]
    """Fraction of the luminance flux of the whole map, shape (n,)."""

    is_clipped: NDArray[np.bool_]
    """True for lights that are clipped at the map's largest possible value, or have a flat top.

    Its irradiance is then a lower bound."""

    flux: NDArray[np.float64]
    r"""Integral of the radiance over each light, :math:`\int L\, d\omega`, shape (n, 3).

    The background behind the light is included. Pixels on the rim count by the part that the light
    covers."""

    members: Members = field(compare=False)
    """Pixels or samples of the lights; stored in ``.json`` files, omitted when pickled."""

    report: DetectionReport
    """Report of the detection."""

    weight: NDArray[np.float64] | None = None
    """Weights by which the lights of a clipped map are sorted, shape (n,); see `detect`.

    None for other maps, whose lights are ordered by flux."""

    direction_uncertainty: NDArray[np.float64] | None = None
    """Direction errors in radians that two thirds of clipped lights do not exceed, shape (n,).

    None for other maps, where the direction is the flux centroid."""

    is_cut: NDArray[np.bool_] = None  # type: ignore[assignment]
    """True for lights at the border of the visible part of the map, shape (n,).

    Its irradiance and flux are then lower bounds. `papers.loghin.detect` flags no light."""

    def __post_init__(self) -> None:
        checked_units(self.units)
        if self.is_cut is None:
            object.__setattr__(self, "is_cut", np.zeros(len(np.asarray(self.flux)), bool))
        arrays = {name: np.asarray(getattr(self, name)) for name in self._array_names()}
        direction, irradiance = light_arrays(self.direction, self.irradiance)
        arrays |= {"direction": direction, "irradiance": irradiance}
        arrays |= measurements.check_measurements(arrays)
        order = self._order(np.asarray(self.flux))
        for name, array in arrays.items():
            if len(array) != len(order):
                raise EnvLightsError(
                    f"{name} must have a row for each light ({len(order)}); got {len(array)}"
                )
            object.__setattr__(self, name, seal(array[order]))
        radius = 2 * np.arcsin(np.sqrt(np.clip(self.solid_angle / (4 * np.pi), 0, 1)))
        object.__setattr__(self, "angular_radius", seal(radius))
        rank = np.argsort(order)
        object.__setattr__(self, "members", self.members.renumbered(rank))
        if self.origin is not None:
            object.__setattr__(self, "origin", origins(self.origin, order))

    def _order(self, flux: NDArray[np.float64]) -> NDArray[np.intp]:
        """Indices of the lights in descending order of flux, or of weight in a clipped map."""
        if self.weight is None:
            return brightest_first(flux)
        return np.argsort(-np.asarray(self.weight), kind="stable")

    def __reduce__(self) -> tuple[Any, ...]:
        """Omit the pixels from a pickle, because they are a thousand times larger than the rest."""
        kind, values = super().__reduce__()
        return kind, tuple(LeftOut() if isinstance(each, Members) else each for each in values)

    def __deepcopy__(self, _: object = None) -> Self:
        return replace(self)

    __copy__ = __deepcopy__

    @overload
    def __getitem__(self, which: int) -> DetectedLight: ...

    @overload
    def __getitem__(self, which: Rows) -> Self: ...

    def __getitem__(self, which: int | Rows) -> DetectedLight | Self:
        """A single light, or the lights selected by a slice, a list of indices or a mask."""
        kept = rows_of(which, len(self))
        if kept is None:
            return self._light(row_of(which, len(self)))
        arrays: dict[str, Any] = {name: getattr(self, name)[kept] for name in self._array_names()}
        members = self.members.of(kept, len(self))
        origin = self._arrays()["origin"][kept]
        report, units = self.report, self.units
        return type(self)(**arrays, members=members, report=report, units=units, origin=origin)

    def _light(self, row: int) -> DetectedLight:
        arrays = {each.name: getattr(self, each.name) for each in fields(DetectedLight)}
        rows = {name: None if array is None else array[row] for name, array in arrays.items()}
        return DetectedLight(**{name: _plain(value) for name, value in rows.items()})

    def __iter__(self) -> Iterator[DetectedLight]:
        return (self._light(row) for row in range(len(self)))

    @property
    def fraction(self) -> NDArray[np.float64]:
        """Fraction of the map's flux in each light, an alias of `flux_fraction`, (n,)."""
        return self.flux_fraction

    def rotated(self, matrix: ArrayLike) -> Self:
        """Lights after a rotation; members and report still refer to the map before it."""
        turn = rotation(matrix)
        return replace(
            self,
            direction=rotate(self.direction, turn),
            peak_direction=rotate(self.peak_direction, turn),
            orientation=rotate(self.orientation, turn),
        )

    def discs(self) -> Lights:
        """Lights as discs with the same irradiance and solid angle.

        A light of more than half the sphere becomes a disc of half the sphere.
        """
        return self._edited()

    @property
    def is_broad(self) -> NDArray[np.bool_]:
        """True for lights above 0.5 sr: a bright region rather than a lamp."""
        broad: NDArray[np.bool_] = self.solid_angle > _BROAD
        return broad

    def to_dict(self) -> dict[str, Any]:
        """All fields except the times as plain numbers, lists and strings; `save` writes them."""
        arrays = {
            name: getattr(self, name).tolist() for name in (*self._array_names(), "angular_radius")
        }
        return {
            "format": f"envlights {_KIND}",
            "version": _VERSION,
            "frame": FRAME,
            "units": f"{_UNITS}; {statement(self.units)}",
            **arrays,
            "scale": self.units,
            **({} if isinstance(self.members, LeftOut) else {"members": self.members.to_runs()}),
            "report": self.report.to_dict(),
        }

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> DetectedLights:
        """Read detected lights that `save` wrote as ``.json``, without their times.

        Raises
        ------
        EnvLightsError
            If the file is missing, has another kind or version, or holds impossible lights.
        """
        return read_json(path, _KIND, _READABLE_VERSIONS, _from_dict)

    def _lines(self) -> list[str]:
        together = f"together: {percent(self.flux_fraction.sum())} of all light in the map"
        return ["", together, *self.report._lines()]

    def _details(self) -> list[str]:
        return self.report._details()

    def _cells(self) -> tuple[list[str], list[list[str]]]:
        columns = ["light", "azimuth", "elevation", "fraction", "radius", "peak"]
        rows = [
            [
                *place_cells(self, row),
                f"{np.rad2deg(self.angular_radius[row]):.2f}°",
                f"{self.peak_luminance[row]:.4g}",
                rgb_cell(self.irradiance[row]),
                self._remarks(row),
            ]
            for row in range(min(len(self), MOST_ROWS))
        ]
        return [*columns, rgb_heading(self.units), ""], rows

    def _remarks(self, row: int) -> str:
        """Text for the last column of the table."""
        return "  ".join(remarks_of(self._light(row)))

    def columns(self) -> dict[str, NDArray[Any]]:
        """Columns of `Lights.columns`, and the scalar measurements of each light."""
        arrays = {name: getattr(self, name) for name in (*self._array_names(), "is_broad")}
        scalars = {name: array for name, array in arrays.items() if array.ndim == 1}
        if "direction_uncertainty" in scalars:
            radians = scalars.pop("direction_uncertainty")
            scalars["direction_uncertainty_deg"] = np.rad2deg(radians)
        return {**super().columns(), **scalars}

    def _array_names(self) -> tuple[str, ...]:
        """Names of the constructor's arrays with a row per light."""
        names = (each.name for each in fields(self) if each.init)
        arrays = (name for name in names if name not in _NO_ARRAYS)
        return tuple(name for name in arrays if getattr(self, name) is not None)


def _from_dict(data: dict[str, Any]) -> DetectedLights:
    report = DetectionReport.from_dict(data["report"])
    arrays = {
        name: reals(name, np.reshape(data[name], (-1, 3)), 2) for name in measurements.VECTORS
    }
    given = [*measurements.NUMBERS, *(n for n in measurements.OF_CLIPPED if n in data)]
    arrays |= {name: reals(name, np.asarray(data[name], np.float64), 1) for name in given}
    clipped = [flag("is_clipped", each) for each in data["is_clipped"]]
    # Files of older versions have no `is_cut`.
    cut = [flag("is_cut", each) for each in data.get("is_cut", [False] * len(clipped))]
    runs, lights = data.get("members"), len(arrays["direction"])
    numbers: dict[str, Any] = {**arrays}
    return DetectedLights(
        **numbers,
        is_clipped=np.array(clipped, bool),
        is_cut=np.array(cut, bool),
        members=LeftOut() if runs is None else Members.from_runs(runs, lights, report.working_size),
        report=report,
        units=data.get("scale", OWN_SCALE),
    )


def _plain(value: Any) -> Any:
    """`value` as a Python number if it is a NumPy scalar."""
    return value.item() if isinstance(value, np.generic) else value
