"""Lights, and the rig that they make with an ambient term."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native, kernels
from envlights._check import amount, reals
from envlights._native import EnvLightsError
from envlights._result import Result
from envlights.files import as_path, write_atomically
from envlights.report import FitReport, StopReason

#: Rec.709 weights of linear red, green and blue in luminance.
LUMINANCE = np.array(_native.LUMINANCE)

_FORMAT = "envlights rig"
_VERSION = 2


@dataclass(frozen=True, eq=False, repr=False)
class Lights(Result):
    r"""Directional lights, brightest first.

    Parameters
    ----------
    direction : array_like, shape (n, 3)
        Unit vectors from the scene towards the lights: right-handed, +y up.
    irradiance : array_like, shape (n, 3)
        Linear RGB at normal incidence, in W m\ :sup:`-2` for radiance in W m\ :sup:`-2`
        sr\ :sup:`-1`; not negative.

    Examples
    --------
    >>> lights = Lights([[0, 1, 0], [1, 0, 0]], [[1, 1, 1], [5, 4, 3]])
    >>> lights.direction[0]
    array([1., 0., 0.])
    >>> len(lights), len(lights[:1])
    (2, 1)
    """

    direction: NDArray[np.float64]
    irradiance: NDArray[np.float64]

    def __post_init__(self) -> None:
        direction, irradiance = _light_arrays(self.direction, self.irradiance)
        brightest_first = np.argsort(-(irradiance @ LUMINANCE), kind="stable")
        for name, array in (("direction", direction), ("irradiance", irradiance)):
            object.__setattr__(self, name, frozen(array[brightest_first]))

    def __len__(self) -> int:
        return len(self.direction)

    def __getitem__(self, which: slice) -> Lights:
        check_slice(which)
        return Lights(self.direction[which], self.irradiance[which])

    def in_short(self) -> str:
        """How many there are."""
        return f"{len(self)} light{'' if len(self) == 1 else 's'}"

    def __str__(self) -> str:
        return _table(self)

    def to_dict(self) -> dict[str, list[list[float]]]:
        """Lists of numbers, for JSON and the like."""
        return {"direction": self.direction.tolist(), "irradiance": self.irradiance.tolist()}


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
    r"""Directional lights, brightest first."""

    error: float
    """Relative RMS error of the irradiance; `report` says on which normals."""

    report: FitReport = field(default_factory=FitReport)
    """How the rig was found."""

    notes: tuple[str, ...] = ()
    """What was cleaned or assumed in the map."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "ambient", frozen(_ambient(self.ambient)))
        object.__setattr__(self, "error", amount("error", self.error))

    def probe(self, normals: ArrayLike) -> NDArray[np.float64]:
        """Irradiance under the rig.

        Parameters
        ----------
        normals : array_like, shape (n, 3)
            Unit normals.

        Returns
        -------
        ndarray, shape (n, 3)
            ``pi * ambient + sum_j irradiance_j * max(0, n . direction_j)``; Madsen et al. (2003),
            equations 4 to 6.
        """
        return kernels.rig_irradiance(
            normals, self.ambient, self.lights.direction, self.lights.irradiance
        )

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain numbers, lists and strings: what `save` writes."""
        return {
            "format": _FORMAT,
            "version": _VERSION,
            "frame": "right-handed, +y up; image centre +z, left quarter +x; towards the light",
            "units": "ambient: radiance; irradiance: at normal incidence; linear Rec.709 RGB",
            "ambient": self.ambient.tolist(),
            "lights": self.lights.to_dict(),
            "error": self.error,
            "report": self.report.to_dict(),
            "notes": list(self.notes),
        }

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the rig as JSON: lossless, versioned, whole or not at all.

        Parameters
        ----------
        path : path-like
            A file with the suffix ``.json``.
        """
        if as_path(path).suffix.lower() != ".json":
            raise EnvLightsError(f"cannot save a rig as {path}; the suffix must be .json")
        text = json.dumps(self.to_dict(), indent=2, allow_nan=False) + "\n"
        write_atomically(path, lambda beside: beside.write_text(text, encoding="utf-8"))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Rig:
        """Read a rig that `save` wrote.

        Raises
        ------
        EnvLightsError
            If the file is missing, of another kind or version, or holds impossible lights.
        """
        try:
            data = json.loads(as_path(path).read_text(encoding="utf-8"))
        except OSError as error:
            raise EnvLightsError(f"cannot read {path}: {error.strerror}") from None
        except (ValueError, RecursionError) as error:
            raise EnvLightsError(f"{path} is no JSON file: {error}") from None
        _check_version(path, data)
        try:
            return _from_dict(data)
        except EnvLightsError as error:
            raise EnvLightsError(f"{path} holds no possible rig: {error}") from None
        except (AttributeError, KeyError, TypeError, ValueError) as error:
            raise EnvLightsError(f"{path} is no whole rig: {error!r}") from None

    def __str__(self) -> str:
        stop = self.report.stop_reason
        lines = [
            _table(self.lights),
            *_ambient_lines(self.ambient),
            error_line(self),
            "" if stop.is_success or stop is StopReason.NOT_FITTED else f"note: {stop.value}",
            *(f"note: {note}" for note in self.notes),
        ]
        return "\n".join(line for line in lines if line)

    def in_short(self) -> str:
        """What it is made of, and its error."""
        ambient = "harmonics" if len(self.ambient) == 9 else "ambient"
        return f"{ambient} + {self.lights.in_short()}, error {100 * self.error:.3g} %"


def error_line(rig: Rig) -> str:
    """The error and the normals that it is of, or that nobody measured it."""
    measured_on = rig.report.measured_on
    where = f" on {measured_on}" if measured_on else ", as given"
    return f"relative RMS error {100 * rig.error:.3g} %{where}"


def _ambient(values: ArrayLike) -> NDArray[np.float64]:
    """An ambient term that no renderer has to take light away for, in the shape it came in."""
    rows = kernels.probe.coefficients(values)
    if not np.isfinite(rows).all():
        raise EnvLightsError(f"ambient must be finite; got {rows.tolist()}")
    if len(rows) == 1 and (rows < 0).any():
        raise EnvLightsError(f"ambient must not be negative; got {rows[0].tolist()}")
    return rows.reshape(np.shape(values))


def _table(lights: Lights) -> str:
    """One line a light."""
    if not len(lights):
        return "no directional light"
    flux = lights.irradiance @ LUMINANCE
    whole = flux.sum() or 1.0  # black lights have no share
    uv = kernels.direction_to_uv(lights.direction)
    lines = ["light  azimuth  elevation   share      irradiance (R, G, B)"]
    for i, ((u, v), power) in enumerate(zip(uv, flux, strict=True), start=1):
        rgb = "".join(f"{value:>11.4g}" for value in lights.irradiance[i - 1])
        share = 100 * power / whole
        lines.append(f"{i:>5}  {360 * u:>6.1f}°  {90 - 180 * v:>+8.1f}°  {share:>4.1f} %{rgb}")
    return "\n".join(lines)


def _ambient_lines(ambient: NDArray[np.float64]) -> list[str]:
    rows = [" ".join(f"{value:>11.4g}" for value in row) for row in np.atleast_2d(ambient)]
    if len(rows) == 1:
        return ["ambient radiance  " + "  ".join(rows[0].split())]
    names = ("1", "y", "z", "x", "xy", "yz", "3zz-1", "xz", "xx-yy")
    table = [f"  {name:<5} {row}" for name, row in zip(names, rows, strict=True)]
    return ["ambient radiance, spherical harmonics (R, G, B):", *table]


def _light_arrays(
    direction: ArrayLike, irradiance: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The arrays of `Lights`, refused where no renderer could use them."""
    direction = reals("direction", direction, 2)
    irradiance = reals("irradiance", irradiance, 2)
    kernels.direction_to_uv(direction)  # refuses what is no unit vector
    if irradiance.shape != direction.shape:
        raise EnvLightsError(
            f"irradiance must have the shape {direction.shape}; got {irradiance.shape}"
        )
    if not np.isfinite(irradiance).all() or (irradiance < 0).any():
        raise EnvLightsError("irradiance must be finite and not negative")
    return direction, irradiance


def check_slice(which: object) -> None:
    """Refuse an index that is no slice: a single light is no `Lights`."""
    if not isinstance(which, slice):
        raise EnvLightsError(
            "lights are taken by slices, such as lights[:4], and one by the arrays, such as"
            f" lights.direction[0]; got {which!r}"
        )


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """A copy of `array` that cannot be written to."""
    return sealed(array.copy())


def sealed(array: NDArray[Any]) -> NDArray[Any]:
    """`array` itself, which nobody else has: from now on it cannot be written to."""
    array.flags.writeable = False
    return array


def _check_version(path: object, data: Any) -> None:
    if not isinstance(data, dict) or data.get("format") != _FORMAT:
        raise EnvLightsError(f"{path} is no rig: it does not say 'format': '{_FORMAT}'")
    if data.get("version") != _VERSION:
        seen = data.get("version")
        raise EnvLightsError(f"{path} is a rig of version {seen!r}; this package reads {_VERSION}")


def _from_dict(data: dict[str, Any]) -> Rig:
    lights = data["lights"]
    # A list without entries has lost its second axis.
    direction = np.reshape(lights["direction"], (-1, 3))
    irradiance = np.reshape(lights["irradiance"], (-1, 3))
    return Rig(
        data["ambient"],
        Lights(direction, irradiance),
        data["error"],
        FitReport.from_dict(data["report"]),
        tuple(data["notes"]),
    )
