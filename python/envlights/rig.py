"""The rig: ambient and directional lights, and how well they stand for the map."""

from __future__ import annotations

import os
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _html, _targets
from envlights._arrays import frozen
from envlights._blocks import in_blocks
from envlights._check import amount, flag, one_or_more, rotation
from envlights._native import EnvLightsError
from envlights._result import Result
from envlights.ambient import ambient_rows, turned_ambient
from envlights.envmap import EnvMap
from envlights.io.csv_table import read_csv
from envlights.io.files import as_path
from envlights.io.own_json import read_json
from envlights.kernels import probe
from envlights.kernels.sphere import FRAME
from envlights.lights import Lights, lights_of
from envlights.report import FitReport, StopReason

_KIND = "rig"
_VERSION = 3
#: Version 2 had neither sizes nor floors.
_READ = (2, 3)


@dataclass(frozen=True, eq=False, repr=False)
class Rig(Result):
    """Ambient and directional lights, and how well they stand for the map.

    Examples
    --------
    >>> rig = Rig([0.1, 0.1, 0.1], Lights([[0, 1, 0]], [[2, 2, 2]]), error=0.0)
    >>> rig.probe([[0, 1, 0], [0, -1, 0]]).round(3)
    array([[2.314, 2.314, 2.314],
           [0.314, 0.314, 0.314]])
    """

    ambient: NDArray[np.float64]
    """Radiance of a constant environment, linear RGB, shape (3,); or real spherical harmonics of it
    up to order 2, shape (9, 3), as `kernels.rig_irradiance` takes them. Their irradiance is nowhere
    negative on a fitted rig."""

    lights: Lights
    """Directional lights, brightest first."""

    error: float
    """Relative RMS error of the irradiance; `report` says on which normals."""

    report: FitReport = field(default_factory=FitReport)
    """How the rig was found."""

    notes: tuple[str, ...] = ()
    """What was cleaned or assumed in the map."""

    floor: bool = False
    """Whether a floor hides the ambient light from below the horizon."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "ambient", frozen(_ambient(self.ambient)))
        if flag("floor", self.floor) and self.ambient.ndim == 2:
            raise EnvLightsError("ambient must be one radiance where there is a floor; got (9, 3)")
        object.__setattr__(self, "error", amount("error", self.error))

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
            equations 4 to 6. Lights with a size are discs of one radiance, in closed form; over a
            floor the ambient light counts ``(1 + n_y) / 2`` times.
        """
        lights = self.lights
        rows, is_one = one_or_more("normals", normals)
        found = probe.rig_irradiance(
            rows,
            self.ambient,
            lights.direction,
            lights.irradiance,
            lights.angular_radius,
            floor=self.floor,
        )
        return found[0] if is_one else found

    def to_map(self, height: int) -> EnvMap:
        """The rig as a map: its lights as discs before its ambient term.

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
        Lights.to_map : how discs are drawn, and points.

        Examples
        --------
        >>> rig = Rig([0.1, 0.1, 0.1], Lights([[0, 1, 0]], [[2, 2, 2]], [0.2]), error=0.0)
        >>> rig.to_map(64).probe([[0, 1, 0], [0, -1, 0]]).round(3)
        array([[2.314, 2.314, 2.314],
               [0.314, 0.314, 0.314]])
        """
        discs = self.lights.to_map(height).radiance
        sky = ambient_rows(self.ambient, height, self.floor)
        return EnvMap(in_blocks(discs.shape, lambda rows: discs[rows] + sky(rows)))

    def rotated(self, matrix: ArrayLike) -> Rig:
        """The rig after a rotation: a light from the direction d then comes from ``matrix @ d``.

        Parameters
        ----------
        matrix : array_like, shape (3, 3)
            A rotation in our frame. Over a floor, only turns about the pole are possible.

        Returns
        -------
        Rig
            With the same error and report. ``rig.rotated(m).probe(normals @ m.T)`` is
            ``rig.probe(normals)``.

        Examples
        --------
        >>> rig = Rig([0.1, 0.1, 0.1], Lights([[0, 1, 0]], [[2, 2, 2]]), error=0.0)
        >>> rig.rotated([[0, 1, 0], [0, 0, 1], [1, 0, 0]]).lights.direction
        array([[1., 0., 0.]])
        """
        turn = rotation(matrix)
        if self.floor and not np.allclose(turn[1], [0, 1, 0], rtol=0, atol=1e-6):
            raise EnvLightsError("a rig over a floor can only be turned about the pole, +y")
        return replace(
            self, ambient=turned_ambient(self.ambient, turn), lights=self.lights.rotated(turn)
        )

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain numbers, lists and strings: what `save` writes."""
        return {
            "format": f"envlights {_KIND}",
            "version": _VERSION,
            "frame": FRAME,
            "units": "ambient: radiance; irradiance: at normal incidence; linear Rec.709 RGB;"
            " angular_radius: radians",
            "ambient": self.ambient.tolist(),
            "lights": self.lights.to_dict(),
            "error": self.error,
            "report": self.report.to_dict(),
            "notes": list(self.notes),
            "floor": self.floor,
        }

    def save(
        self, path: str | os.PathLike[str], environment: EnvMap | ArrayLike | None = None
    ) -> None:
        """Write the rig in the format that the suffix names, whole or not at all.

        ``.json`` is the package's own: lossless and versioned, and `load` reads it.

        Parameters
        ----------
        path : path-like
            `el.export.TARGETS` lists the suffixes, and what each format keeps and loses.
        environment : EnvMap or array_like, optional
            A map in place of the ambient term, for targets that take one.

        See Also
        --------
        envlights.export : the same as dictionaries and text.
        """
        _targets.save(self, path, environment)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Rig:
        """Read a rig that `save` wrote as ``.json``, or as ``.csv``: that holds no report.

        Raises
        ------
        EnvLightsError
            If the file is missing, of another kind or version, or holds impossible lights.
        """
        if as_path(path).suffix.lower() == ".csv":
            table = read_csv(path)
            if table.ambient is None or table.error is None:
                raise EnvLightsError(f"{path} holds lights alone; `Lights.load` reads them")
            lights = Lights(table.direction, table.irradiance, table.angular_radius)
            return cls(table.ambient, lights, table.error, floor=table.floor)
        return read_json(path, _KIND, _READ, _from_dict)

    def __str__(self) -> str:
        return "\n".join([str(self.lights), *self._lines()])

    def _html_parts(self) -> tuple[str, ...]:
        return (*self.lights._html_parts(), _html.lines("\n".join(self._lines())))

    def _lines(self) -> list[str]:
        """What is to be said beside the lights."""
        stop = self.report.stop_reason
        lines = [
            *_ambient_lines(self.ambient),
            "a floor hides the ambient light from below the horizon" if self.floor else "",
            error_line(self),
            "" if stop.is_success or stop is StopReason.NOT_FITTED else f"note: {stop.value}",
            *(f"note: {note}" for note in self.notes),
        ]
        return [line for line in lines if line]

    def in_short(self) -> str:
        """Its parts, and its error."""
        return f"{parts_line(self)}, error {100 * self.error:.3g} %"


def parts_line(rig: Rig) -> str:
    """The ambient term and the number of lights."""
    ambient = "harmonics" if len(rig.ambient) == 9 else "ambient"
    return f"{ambient} + {rig.lights.in_short()}"


def error_line(rig: Rig) -> str:
    """The error, and the normals on which it was measured, if it was."""
    measured_on = rig.report.measured_on
    where = f" on {measured_on}" if measured_on else ", as given"
    shadows = rig.report.with_shadows()
    return f"relative RMS error {100 * rig.error:.3g} %{where}{', ' if shadows else ''}{shadows}"


def _ambient(values: ArrayLike) -> NDArray[np.float64]:
    """An ambient term in the shape it came in, or a refusal where its radiance is impossible."""
    rows = probe.coefficients(values)
    if not np.isfinite(rows).all():
        raise EnvLightsError(f"ambient must be finite; got {rows.tolist()}")
    if len(rows) == 1 and (rows < 0).any():
        raise EnvLightsError(f"ambient must not be negative; got {rows[0].tolist()}")
    return rows.reshape(np.shape(values))


def _ambient_lines(ambient: NDArray[np.float64]) -> list[str]:
    rows = [" ".join(f"{value:>11.4g}" for value in row) for row in np.atleast_2d(ambient)]
    if len(rows) == 1:
        return ["ambient radiance  " + "  ".join(rows[0].split())]
    names = ("1", "y", "z", "x", "xy", "yz", "3zz-1", "xz", "xx-yy")
    table = [f"  {name:<5} {row}" for name, row in zip(names, rows, strict=True)]
    return ["ambient radiance, spherical harmonics (R, G, B):", *table]


def _from_dict(data: dict[str, Any]) -> Rig:
    return Rig(
        data["ambient"],
        lights_of(data["lights"]),
        data["error"],
        FitReport.from_dict(data["report"]),
        tuple(data["notes"]),
        data.get("floor", False),
    )
