"""Rig: an ambient term and directional lights, with their error."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.arrays import freeze
from envlights._common.blocks import in_blocks
from envlights._common.check import amount, describe, flag, one_or_more, rotation, texts
from envlights._common.files import as_path
from envlights._common.notes import Note
from envlights._common.result import Result
from envlights._common.tables import Table as TextTable
from envlights._common.tables import frame_of
from envlights._common.units import in_nits, statement
from envlights._common.words import percent
from envlights._native import EnvLightsError
from envlights.environment.envmap import EnvMap
from envlights.environment.fill import Fill
from envlights.environment.reading import AnyMap
from envlights.export import saving
from envlights.export.formats.csv_table import Table, load_csv
from envlights.export.formats.own_json import read_json
from envlights.export.targets import error_in
from envlights.kernels import probe
from envlights.kernels.ambient import ambient_rows, mean_ambient, turned_ambient
from envlights.kernels.image import LUMINANCE
from envlights.kernels.sphere import FRAME
from envlights.rigs.light_arrays import LARGEST_LIGHT
from envlights.rigs.lights import Lights, lights_of, lights_of_table
from envlights.rigs.report import FitReport, StopReason

if TYPE_CHECKING:
    import pandas as pd

_KIND = "rig"
_VERSION = 5
#: Version 2 had neither sizes nor floors; version 3 had wall times, but no units; version 4 named
#: `FitReport.search_errors` "errors".
_READABLE_VERSIONS = (2, 3, 4, 5)


@dataclass(frozen=True, eq=False, repr=False)
class Rig(Result):
    """Ambient term and directional lights, with an error and a report.

    Examples
    --------
    >>> rig = Rig([0.1, 0.1, 0.1], Lights([[0, 1, 0]], [[2, 2, 2]]), error=0.0)
    >>> rig.probe([[0, 1, 0], [0, -1, 0]]).round(3)
    array([[2.314, 2.314, 2.314],
           [0.314, 0.314, 0.314]])
    """

    ambient: NDArray[np.float64]
    """Radiance of the ambient term, linear RGB, (3,), or its real spherical harmonics, (9, 3).

    The harmonics go up to order 2, as in `kernels.rig_irradiance`. The irradiance of a fitted rig
    is nowhere negative."""

    lights: Lights
    """Directional lights, brightest first."""

    error: float | None = None
    """Relative RMS error of irradiance at the normals stated in `report`.

    None if it was not measured; see `measured`."""

    report: FitReport = field(default_factory=FitReport)
    """Report of the fit."""

    notes: tuple[str, ...] = ()
    """Notes on changed samples of the map, and on assumptions."""

    floor: bool = False
    """True if a floor hides the ambient light from below the horizon."""

    def __post_init__(self) -> None:
        _check_types(self.lights, self.report)
        object.__setattr__(self, "ambient", freeze(_ambient(self.ambient)))
        object.__setattr__(self, "floor", flag("floor", self.floor))
        if self.floor and self.ambient.ndim == 2:
            raise EnvLightsError("ambient must be one radiance where there is a floor; got (9, 3)")
        object.__setattr__(self, "notes", tuple(map(Note, texts("notes", self.notes))))
        if self.error is not None:
            object.__setattr__(self, "error", amount("error", self.error))

    @classmethod
    def of(cls, ambient: ArrayLike, lights: Lights, env: AnyMap | None = None) -> Rig:
        """Rig from numbers, such as the output of a network, with its errors on a map.

        Parameters
        ----------
        ambient : array_like, shape (3,) or (9, 3)
            Radiance of the ambient term, or its harmonics.
        lights : Lights
            Directional lights.
        env : EnvMap, array_like or path, optional
            True map, on which the rig is `measured`. Default: `error` is None.

        Examples
        --------
        >>> sun = Lights([[0.6, 0.8, 0]], [[3, 2, 1]], [0.2])
        >>> Rig.of([0, 0, 0], sun)
        <Rig: ambient + 1 light, error not measured>
        >>> Rig.of([0, 0, 0], sun.dimmed(0, 0.9), sun.to_map(128))
        <Rig: ambient + 1 light, error 10 %>
        """
        rig = cls(ambient, lights)  # type: ignore[arg-type]  # which is converted
        return rig if env is None else rig.measured(env)

    def measured(self, env: AnyMap, *, fill: Fill = None) -> Rig:
        """Rig with its errors under a map, whatever the source of either.

        Parameters
        ----------
        env : EnvMap, array_like or path
            True map, in the units of the rig.
        fill : {"black", "harmonic", "ground"}, float or array_like, shape (3,), optional
            Radiance where the map shows nothing; see `EnvMap.filled`.

        Returns
        -------
        Rig
            With a new `error` and `report`: errors of the probe, by channel, with shadows and on
            metal, in the closed forms of `el.compare`. Fields that only a fit knows are empty.

        Raises
        ------
        EnvLightsError
            If the map is black or has other units, or `fill` is required.

        Examples
        --------
        >>> import envlights as el
        >>> rig = el.fit(el.synthetic.hall(64).radiance, lights=2)
        >>> night = rig.measured(0.5 * el.synthetic.hall(64).radiance)
        >>> round(night.error, 1), round(night.report.gloss_error(), 1)
        (1.0, 1.1)
        """
        # Import late, because this package is a layer above.
        measure = import_module("envlights.fitting.measure").measure
        return measure(self, env, fill)  # type: ignore[no-any-return]

    @property
    def units(self) -> str:
        """Unit of the ambient radiance: "cd/m2" for its luminance, or "the map's own scale".

        It is that of `lights`. In a rig in cd/m2, irradiance has a luminance in lux.
        """
        return self.lights.units

    def probe(self, normals: ArrayLike) -> NDArray[np.float64]:
        """Irradiance under the rig.

        Parameters
        ----------
        normals : array_like, shape (n, 3) or (3,)
            Unit normals, or one.

        Returns
        -------
        ndarray, shape (n, 3) or (3,)
            ``pi * ambient + sum_j irradiance_j * max(0, n . direction_j)``; Madsen et al. (2003),
            equations 4 to 6. Lights with a size are discs of uniform radiance, in closed form. Over
            a floor the ambient irradiance is multiplied by ``(1 + n_y) / 2``.
        """
        lights = self.lights
        rows, is_one = one_or_more("normals", normals)
        values = probe.rig_irradiance(
            rows,
            self.ambient,
            lights.direction,
            lights.irradiance,
            lights.angular_radius,
            floor=self.floor,
        )
        return values[0] if is_one else values

    def to_map(self, height: int) -> EnvMap:
        """Draw the rig as a map: radiance of the ambient term plus lights as discs.

        Over a floor, the ambient radiance fills the upper half alone. Harmonics that are negative
        somewhere are cut off there.

        Parameters
        ----------
        height : int
            Rows; the map is twice as wide.

        Returns
        -------
        EnvMap

        See Also
        --------
        Lights.to_map : method that draws the discs and points.

        Examples
        --------
        >>> rig = Rig([0.1, 0.1, 0.1], Lights([[0, 1, 0]], [[2, 2, 2]], [0.2]), error=0.0)
        >>> rig.to_map(64).probe([[0, 1, 0], [0, -1, 0]]).round(3)
        array([[2.314, 2.314, 2.314],
               [0.314, 0.314, 0.314]])
        """
        discs = self.lights.to_map(height).radiance
        sky = ambient_rows(self.ambient, height, self.floor)
        radiance = in_blocks(discs.shape, lambda rows: discs[rows] + sky(rows))
        return EnvMap(radiance, units=self.units)

    def rotated(self, matrix: ArrayLike) -> Rig:
        """Rotate the rig: light from direction d then comes from ``matrix @ d``.

        Parameters
        ----------
        matrix : array_like, shape (3, 3)
            A rotation in the frame of `EnvMap`. Over a floor, only rotations about +y are possible.

        Returns
        -------
        Rig
            Rig with the same error and report. ``rig.rotated(m).probe(normals @ m.T)`` is
            ``rig.probe(normals)``.

        Examples
        --------
        >>> rig = Rig([0.1, 0.1, 0.1], Lights([[0, 1, 0]], [[2, 2, 2]]), error=0.0)
        >>> rig.rotated([[0, 1, 0], [0, 0, 1], [1, 0, 0]]).lights.direction
        array([[1., 0., 0.]])
        """
        turn = rotation(matrix)
        if self.floor and not np.allclose(turn[1], [0, 1, 0], rtol=0, atol=1e-6):
            raise EnvLightsError("a rig over a floor can only be rotated about the pole, +y")
        return replace(
            self, ambient=turned_ambient(self.ambient, turn), lights=self.lights.rotated(turn)
        )

    def to_dict(self) -> dict[str, Any]:
        """All fields as plain numbers, lists and strings, as `save` writes them."""
        return {
            "format": f"envlights {_KIND}",
            "version": _VERSION,
            "frame": FRAME,
            "units": "ambient: radiance; irradiance: at normal incidence; linear Rec.709 RGB;"
            f" angular_radius: radians; {statement(self.units)}",
            "ambient": self.ambient.tolist(),
            "lights": self.lights.to_dict(),
            "error": self.error,
            "report": self.report.to_dict(),
            "notes": list(self.notes),
            "floor": self.floor,
        }

    def to_frame(self) -> pd.DataFrame:
        """Data frame with a row per light, as from `Lights.to_frame`; needs pandas.

        Its ``attrs`` hold `ambient`, `error`, `floor` and `units`.
        """
        frame = self.lights.to_frame()
        frame.attrs = {
            "ambient": self.ambient.tolist(),
            "error": self.error,
            "floor": self.floor,
            "units": self.units,
        }
        return frame

    def save(
        self,
        path: str | os.PathLike[str],
        environment: EnvMap | ArrayLike | None = None,
        **options: Any,
    ) -> None:
        """Write the rig in the format of the suffix; a failure leaves no file.

        ``.json`` is the package's own: lossless and versioned, and `load` reads it.

        Parameters
        ----------
        path : path-like
            `el.export.TARGETS` lists the suffixes, with the parts that each format keeps and loses.
        environment : EnvMap or array_like, optional
            Map that replaces the ambient term, for formats that accept one.
        **options
            Further arguments of the target's writer: ``up="z"`` of OpenUSD, ``scale=`` of MuJoCo.

        Warns
        -----
        UserWarning
            If the target shows the rig with a larger error, such as lights with a size as points.

        See Also
        --------
        envlights.export : functions that return dictionaries and text.
        """
        saving.save(self, path, environment, **options)

    def error_in(self, target: str) -> float:
        """Relative RMS error of the irradiance with which a target shows the rig.

        Parameters
        ----------
        target : str
            Name from `el.export.TARGETS`, such as "three".

        Returns
        -------
        float
            `error` if the target shows all of the rig. For a target that shows lights with a size
            as points, the error measured by `fit`. For other losses, or without a fit, the root of
            the sum of the squares of `error` and of the change in irradiance.

        Examples
        --------
        >>> rig = Rig([0.1, 0.1, 0.1], Lights([[0, 1, 0]], [[2, 2, 2]], [0.5]), error=0.01)
        >>> round(rig.error_in("blender"), 3), round(rig.error_in("three"), 3)
        (0.01, 0.062)
        """
        return error_in(self, target)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Rig:
        """Read a rig that `save` wrote as ``.json`` or ``.csv``; the latter has no report.

        Raises
        ------
        EnvLightsError
            If the file is missing, has another kind or version, or holds impossible lights.
        """
        if as_path(path).suffix.lower() == ".csv":
            return load_csv(path, _of_table)
        return read_json(path, _KIND, _READABLE_VERSIONS, _from_dict)

    def _pictures(self) -> Iterable[str]:
        return self.lights._pictures()

    def _table(self) -> TextTable:
        return self.lights.table()

    def _lines(self) -> list[str]:
        stop = self.report.stop_reason
        lines = [
            *_ambient_lines(self.ambient, in_nits(self.units)),
            "a floor hides ambient light from below the horizon" if self.floor else "",
            error_line(self),
            "" if stop.is_success or stop is StopReason.NOT_FITTED else f"note: {stop.value}",
            *(f"note: {note}" for note in self.notes),
        ]
        return [*self.lights._lines(), *(line for line in lines if line)]

    def _details(self) -> list[str]:
        return ["", *self.report.verbose().split("\n")]

    def in_short(self) -> str:
        """Ambient term, number of lights and error."""
        return f"{parts_line(self)}, error {error_in_words(self.error)}"


def rigs_to_frame(rigs: Iterable[Rig] | Mapping[str, Rig]) -> pd.DataFrame:
    """Data frame with a row per rig; needs pandas.

    Parameters
    ----------
    rigs : iterable of Rig, or mapping
        Rigs; the keys of a mapping, such as names of maps, are the index of the frame.

    Returns
    -------
    pandas.DataFrame
        Lights, luminance of the ambient term (of harmonics: its mean over all directions) and of
        all lights, error, and the columns of `FitReport.to_frame`.

    Raises
    ------
    EnvLightsError
        If one of `rigs` is no rig, or pandas is not installed.

    Examples
    --------
    >>> rig = Rig([0.1, 0.1, 0.1], Lights([[0, 1, 0]], [[2, 2, 2]]), error=0.25)
    >>> rigs_to_frame({"one": rig})["error"].to_dict()
    {'one': 0.25}
    """
    names = list(rigs) if isinstance(rigs, Mapping) else None
    if isinstance(rigs, str | Rig) or not isinstance(rigs, Iterable):
        raise EnvLightsError(f"rigs must be a sequence or a mapping of rigs; got {describe(rigs)}")
    each = list(rigs.values()) if isinstance(rigs, Mapping) else list(rigs)
    for rig in each:
        if not isinstance(rig, Rig):
            raise EnvLightsError(f"rigs must hold rigs of `fit`; got {describe(rig)}")
    rows = [{**_row(rig), **rig.report.row()} for rig in each]
    columns = (
        rows[0] if rows else _row(Rig(np.zeros(3), Lights(np.zeros((0, 3)), np.zeros((0, 3))), 0.0))
    )
    frame = frame_of({name: np.array([row[name] for row in rows]) for name in columns})
    return frame if names is None else frame.set_axis(names)


def _row(rig: Rig) -> dict[str, Any]:
    return {
        "lights": len(rig.lights),
        "ambient_luminance": mean_ambient(rig.ambient) @ LUMINANCE,
        "lights_luminance": rig.lights.luminance.sum(),
        "error": error_of(rig),
    }


def error_of(rig: Rig) -> float:
    """Error of a rig; NaN if not measured."""
    return np.nan if rig.error is None else rig.error


def error_in_words(error: float | None) -> str:
    """Error as a percentage, or the text "not measured"."""
    return "not measured" if error is None else percent(error)


def parts_line(rig: Rig) -> str:
    """Ambient term and number of lights."""
    ambient = "harmonics" if len(rig.ambient) == 9 else "ambient"
    return f"{ambient} + {rig.lights.in_short()}"


def error_line(rig: Rig) -> str:
    """Line with the errors of shading, with shadows, and of rough metal."""
    floor = " over a floor" if rig.floor else ""
    more = filter(None, (rig.report.with_shadows(), rig.report.with_gloss()))
    return ", ".join([f"relative RMS error {error_in_words(rig.error)}{floor}", *more])


def _check_types(lights: object, report: object) -> None:
    """Raise an error for lights that are no `Lights`, or a report that is no `FitReport`."""
    if not isinstance(lights, Lights):
        has_lights = isinstance(getattr(lights, "lights", None), Lights)
        wanted = "give its `lights`" if has_lights else "such as el.Lights(direction, irradiance)"
        raise EnvLightsError(f"lights must be el.Lights, {wanted}; got {describe(lights)}")
    if not isinstance(report, FitReport):
        raise EnvLightsError(
            "report must be the report of a rig, such as rig.report, or left out; got"
            f" {describe(report)}"
        )


def _ambient(values: ArrayLike) -> NDArray[np.float64]:
    """Checked ambient term, in its original shape."""
    rows = probe.coefficients(values)
    if not (np.abs(rows) <= LARGEST_LIGHT).all():
        raise EnvLightsError(
            f"ambient must be finite, and at most {LARGEST_LIGHT:.3g}; got {rows.tolist()}"
        )
    if len(rows) == 1 and (rows < 0).any():
        raise EnvLightsError(f"ambient must not be negative; got {rows[0].tolist()}")
    return rows.reshape(np.shape(values))


def _ambient_lines(ambient: NDArray[np.float64], unit: str) -> list[str]:
    rows = [" ".join(f"{value:>11.4g}" for value in row) for row in np.atleast_2d(ambient)]
    if len(rows) == 1:
        return [f"ambient radiance{unit}  " + "  ".join(rows[0].split())]
    names = ("1", "y", "z", "x", "xy", "yz", "3zz-1", "xz", "xx-yy")
    table = [f"  {name:<5} {row}" for name, row in zip(names, rows, strict=True)]
    return [f"ambient radiance{unit}, spherical harmonics (R, G, B):", *table]


def _of_table(table: Table) -> Rig:
    if table.ambient is None:
        raise EnvLightsError("it holds lights without an ambient term; use `Lights.load`")
    return Rig(table.ambient, lights_of_table(table), table.error, floor=table.floor)


def rig_fields(data: dict[str, Any]) -> tuple[Any, Any, Any, Any, Any, Any]:
    """Arguments for `Rig`, from the dictionary that `Rig.to_dict` returned."""
    return (
        data["ambient"],
        lights_of(data["lights"]),
        data["error"],
        FitReport.from_dict(data["report"]),
        tuple(texts("notes", data["notes"])),
        data.get("floor", False),
    )


def _from_dict(data: dict[str, Any]) -> Rig:
    return Rig(*rig_fields(data))
