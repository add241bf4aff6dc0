"""Directional lights with angular radii, sorted by brightness."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common import html
from envlights._common.arrays import seal
from envlights._common.check import rotation, texts
from envlights._common.files import as_path
from envlights._common.former import former_attributes
from envlights._common.notes import Note
from envlights._common.result import TableResult
from envlights._common.tables import MOST_ROWS, Table
from envlights._common.units import OWN_SCALE, checked_units, in_lux
from envlights._common.words import percent, quantity
from envlights._native import EnvLightsError
from envlights.environment.envmap import EnvMap
from envlights.export import saving
from envlights.export.formats.csv_table import Table as CsvTable
from envlights.export.formats.csv_table import load_csv
from envlights.export.formats.own_json import read_json
from envlights.frames import frame_named
from envlights.kernels import thumbnails
from envlights.kernels.angles import angle_cells, azimuths, elevations
from envlights.kernels.image import LUMINANCE
from envlights.kernels.probe import disc_map
from envlights.rigs.editing import Editable
from envlights.rigs.light import Light
from envlights.rigs.light_arrays import LARGEST_LIGHT, light_arrays, radii, rotate, row_of, rows_of
from envlights.rigs.lobes import SphericalGaussians, lobes


def brightest_first(irradiance: NDArray[np.float64]) -> NDArray[np.intp]:
    """Row order of `irradiance`, (n, 3), by decreasing luminance; stable for equal luminances.

    All arrays with one value for each light use this order. Sorting again changes nothing, because
    luminance is not a matrix product here, whose rounding may depend on the row.
    """
    red, green, blue = LUMINANCE[:, None] * irradiance.T
    luminance = red + green + blue
    # Treat luminances that differ only by rounding as equal.
    unit = max(luminance.max(initial=0.0), sys.float_info.min)
    order: NDArray[np.intp] = (-(luminance / unit).round(9)).argsort(kind="stable")
    return order


#: Index of several lights: a slice, a list of indices, or a mask.
Rows = slice | list[int] | NDArray[Any]


@former_attributes(share="fraction")
@dataclass(frozen=True, eq=False, repr=False)
class Lights(Editable["Lights"], TableResult):
    r"""Directional lights, brightest first.

    Parameters
    ----------
    direction : array_like, shape (n, 3)
        Unit vectors from the scene towards the lights: right-handed, +y up.
    irradiance : array_like, shape (n, 3)
        Linear RGB at normal incidence, in W m\ :sup:`-2` for radiance in W m\ :sup:`-2`
        sr\ :sup:`-1`; not negative.
    angular_radius : array_like, shape (n,), optional
        Radians from 0 to pi / 2. The light is a disc of uniform radiance: its irradiance divided by
        :math:`\pi \sin^2 a`. 0 is a point. Default: all are points.
    units : {"the map's own scale", "cd/m2"}
        Unit of the radiance of the map; with "cd/m2", the luminance of `irradiance` is in lux.
    notes : str or iterable of str
        Remarks on estimates, which texts and files repeat. A detection has a `report` instead.
    origin : tuple of int, optional
        Of chosen and changed lights (``lights[:2]``, `moved`, `dimmed`, ...): the number that each
        had before; -1 for an added light.

    Examples
    --------
    >>> lights = Lights([[0, 1, 0], [1, 0, 0]], [[1, 1, 1], [5, 4, 3]], [0.5, 0.0])
    >>> lights.direction[0], lights.angular_radius
    (array([1., 0., 0.]), array([0. , 0.5]))
    >>> len(lights), len(lights[:1])
    (2, 1)
    >>> [round(light.luminance, 2) for light in lights]
    [4.14, 1.0]
    """

    direction: NDArray[np.float64]
    irradiance: NDArray[np.float64]
    # The constructor replaces None.
    angular_radius: NDArray[np.float64] = None  # type: ignore[assignment]
    units: str = field(default=OWN_SCALE, kw_only=True)
    notes: tuple[str, ...] = field(default=(), kw_only=True)
    origin: tuple[int, ...] | None = field(default=None, kw_only=True, compare=False)

    def __post_init__(self) -> None:
        checked_units(self.units)
        object.__setattr__(self, "notes", tuple(map(Note, texts("notes", self.notes))))
        direction, irradiance = light_arrays(self.direction, self.irradiance)
        radius = radii(self.angular_radius, len(direction))
        order = brightest_first(irradiance)
        object.__setattr__(self, "direction", seal(direction[order]))
        object.__setattr__(self, "irradiance", seal(irradiance[order]))
        object.__setattr__(self, "angular_radius", seal(radius[order]))
        if self.origin is not None:
            object.__setattr__(self, "origin", origins(self.origin, order))

    @classmethod
    def unchecked(
        cls,
        direction: NDArray[np.float64],
        irradiance: NDArray[np.float64],
        angular_radius: NDArray[np.float64],
        units: str,
    ) -> Lights:
        """Lights from the arrays of a kernel, sorted by brightness, without checks."""
        lights = cls.__new__(cls)
        object.__setattr__(lights, "direction", seal(direction))
        object.__setattr__(lights, "irradiance", seal(irradiance))
        object.__setattr__(lights, "angular_radius", seal(angular_radius))
        object.__setattr__(lights, "units", units)
        object.__setattr__(lights, "notes", ())
        object.__setattr__(lights, "origin", None)
        return lights

    def __len__(self) -> int:
        return len(self.direction)

    @overload
    def __getitem__(self, which: int) -> Light: ...

    @overload
    def __getitem__(self, which: Rows) -> Lights: ...

    def __getitem__(self, which: int | Rows) -> Light | Lights:
        """A single light, or the lights selected by a slice, a list of indices or a mask."""
        rows = rows_of(which, len(self))
        if rows is None:
            return self._light(row_of(which, len(self)))
        return self._edited(**{name: array[rows] for name, array in self._arrays().items()})

    def _arrays(self) -> dict[str, Any]:
        return {
            "direction": self.direction,
            "irradiance": self.irradiance,
            "angular_radius": np.minimum(self.angular_radius, np.pi / 2),
            "origin": np.arange(len(self)) if self.origin is None else np.array(self.origin, int),
        }

    def _edited(self, **changed: Any) -> Lights:
        return Lights(**self._arrays() | changed, units=self.units, notes=self.notes)

    def _light(self, row: int) -> Light:
        radius, fraction = float(self.angular_radius[row]), float(self.fraction[row])
        return Light(self.direction[row], self.irradiance[row], radius, fraction)

    def __iter__(self) -> Iterator[Light]:
        return (self._light(row) for row in range(len(self)))

    @property
    def azimuth(self) -> NDArray[np.float64]:
        """Radians from -z over +x, increasing with map columns, from 0 to 2 pi, (n,)."""
        return azimuths(self.direction)

    @property
    def elevation(self) -> NDArray[np.float64]:
        """Radians above the horizon, from -pi / 2 to pi / 2, (n,)."""
        return elevations(self.direction)

    @property
    def luminance(self) -> NDArray[np.float64]:
        """Luminance of each irradiance, (n,)."""
        values: NDArray[np.float64] = self.irradiance @ LUMINANCE
        return values

    @property
    def fraction(self) -> NDArray[np.float64]:
        """Fraction of each light in the total luminance, (n,); 0 if all are black."""
        shares: NDArray[np.float64] = self.luminance / (self.luminance.sum() or 1.0)
        return shares

    def in_short(self) -> str:
        """Number of lights."""
        return quantity(len(self), "light")

    def _lines(self) -> list[str]:
        return [f"note: {note}" for note in self.notes]

    def _pictures(self) -> list[str]:
        if not len(self):
            return []
        arrays = self.direction, self.irradiance, self.angular_radius
        return [html.picture(thumbnails.of_lights(*arrays), "directions of the lights")]

    def table(self) -> Table:
        """Table of the first dozen lights, and a summary of the others."""
        columns, rows = self._cells()
        colours = thumbnails.hex_of(self.irradiance[:MOST_ROWS])
        return Table(columns, rows, hidden_lights(self.fraction), colours)

    def _cells(self) -> tuple[list[str], list[list[str]]]:
        """Column names, and cells of the first dozen lights."""
        has_sizes = self.angular_radius.any()
        sizes = ["radius"] if has_sizes else []
        columns = ["light", "azimuth", "elevation", "fraction", *sizes, rgb_heading(self.units)]
        rows = [
            [
                *place_cells(self, row),
                *([f"{np.rad2deg(self.angular_radius[row]):.2f}°"] if has_sizes else []),
                rgb_cell(self.irradiance[row]),
            ]
            for row in range(min(len(self), MOST_ROWS))
        ]
        return columns, rows

    def columns(self) -> dict[str, NDArray[Any]]:
        """Columns with a row per light; names that end in ``_deg`` are angles in degrees.

        Each component of a vector or colour has a column.
        """
        angles = {
            "azimuth_deg": np.rad2deg(self.azimuth),
            "elevation_deg": np.rad2deg(self.elevation),
            "radius_deg": np.rad2deg(self.angular_radius),
        }
        colours = dict(zip(("red", "green", "blue"), self.irradiance.T, strict=True))
        vectors = dict(zip("xyz", self.direction.T, strict=True))
        return {
            **angles,
            "fraction": self.fraction,
            "luminance": self.luminance,
            **colours,
            **vectors,
        }

    def to_dict(self) -> dict[str, Any]:
        """Lists of numbers, for example for JSON."""
        return {
            "direction": self.direction.tolist(),
            "irradiance": self.irradiance.tolist(),
            "angular_radius": self.angular_radius.tolist(),
            "scale": self.units,
            **({"notes": list(self.notes)} if self.notes else {}),
            **({"origin": list(self.origin)} if self.origin is not None else {}),
        }

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
            `el.export.TARGETS` lists the suffixes, with the parts that each format keeps and loses.
        environment : EnvMap or array_like, optional
            Map around the lights, such as the remainder of a split map, for formats that accept
            one.
        **options
            Further arguments of the target's writer: ``up="z"`` of OpenUSD, ``scale=`` of MuJoCo.

        Raises
        ------
        EnvLightsError
            If the suffix is unknown, the target accepts no map or no such option, or the file
            cannot be written.

        Warns
        -----
        UserWarning
            If the target shows the lights with a larger error, such as lights with a size as
            points.
        """
        saving.save(self, path, environment, **options)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Lights:
        """Read lights that `save` wrote as ``.json`` or ``.csv``.

        Raises
        ------
        EnvLightsError
            If the file is missing, has another kind or version, or holds impossible lights.
        """
        if as_path(path).suffix.lower() == ".csv":
            return load_csv(path, lights_of_table)
        return read_json(path, "lights", (1, 2), lights_of)

    def discs(self) -> Lights:
        """Lights as discs of uniform radiance: this object itself."""
        return self

    def rotated(self, matrix: ArrayLike) -> Lights:
        """Rotate the lights: light from direction d then comes from ``matrix @ d``.

        Parameters
        ----------
        matrix : array_like, shape (3, 3)
            A rotation in the frame of `EnvMap`.

        Examples
        --------
        A quarter turn about the pole, from +z to +x:

        >>> lamp = Lights([[0, 0, 1]], [[3, 2, 1]])
        >>> lamp.rotated([[0, 0, 1], [0, 1, 0], [-1, 0, 0]]).direction
        array([[1., 0., 0.]])
        """
        return replace(self, direction=rotate(self.direction, rotation(matrix)))

    def in_frame(self, frame: str) -> NDArray[np.float64]:
        """Directions to the lights in the frame of another program, (n, 3).

        Parameters
        ----------
        frame : str
            Name from `el.frames.FRAMES`, such as "opencv", "blender" or "unreal".

        Examples
        --------
        There and back:

        >>> from envlights import frames
        >>> there = Lights([[0, 0.6, 0.8]], [[3, 2, 1]]).in_frame("opencv")
        >>> there
        array([[ 0. , -0.6,  0.8]])
        >>> Lights(frames.FRAMES["opencv"].from_target(there), [[3, 2, 1]]).direction
        array([[0. , 0.6, 0.8]])
        """
        return frame_named(frame).to_target(self.direction)

    def to_map(self, height: int) -> EnvMap:
        """Map of the lights as discs in a black sky, for training labels or renderers.

        Pixels on the rim of a disc are as bright as their covered fraction. A surface that faces
        all of a disc receives exactly its irradiance, up to single precision. A point becomes a
        disc with a radius of one pixel, the smallest from which `detect` recovers irradiance and
        direction.

        Parameters
        ----------
        height : int
            Rows; the map is twice as wide.

        Returns
        -------
        EnvMap

        Examples
        --------
        >>> sun = Lights([[0.6, 0.8, 0]], [[3, 2, 1]])
        >>> sun.to_map(64).probe([[0.6, 0.8, 0]]).round(6)
        array([[3., 2., 1.]])
        """
        discs = self.discs()
        drawn = disc_map(height, discs.direction, discs.irradiance, discs.angular_radius)
        if drawn.max(initial=0) > LARGEST_LIGHT:
            raise EnvLightsError(
                f"a light is too bright for a map of single precision (up to {LARGEST_LIGHT:.3g});"
                " scale the lights"
            )
        return EnvMap(drawn, units=self.units)

    def spherical_gaussians(self) -> SphericalGaussians:
        r"""Convert the lights to spherical Gaussians, for engines that use them.

        Returns
        -------
        SphericalGaussians
            Lobes with the irradiance of each light at normal incidence. The spread of a lobe, its
            mean of 1 - cos, is that of the disc; points become as narrow as the sun.

        Notes
        -----
        The lobe :math:`A e^{k (l \cdot \omega - 1)}` (Wang et al. 2009, "All-frequency rendering of
        dynamic, spatially-varying reflectance", equation 3) is the density of von Mises and Fisher,
        whose mean of the cosine is :math:`\coth k - 1/k` (Mardia and Jupp 2000, equation 9.3.9).
        That of a disc is :math:`(1 + \cos a) / 2`. The hemisphere around the axis receives

        .. math:: E = 2 \pi A \int_0^1 e^{k (c - 1)} c \, dc
                    = 2 \pi A \, \frac{k - 1 + e^{-k}}{k^2} .

        Examples
        --------
        >>> window = Lights([[0, 1, 0]], [[3, 3, 3]], [0.5])
        >>> lobes = window.spherical_gaussians()
        >>> lobes.sharpness.round(2), lobes.amplitude.round(2)
        (array([16.34]), array([[8.31, 8.31, 8.31]]))
        """
        discs = self.discs()
        return lobes(discs.direction, discs.irradiance, discs.angular_radius)


# Register as a sequence, although `count` and `index` are missing.
Sequence.register(Lights)


def origins(origin: Sequence[int] | NDArray[Any], order: NDArray[np.intp]) -> tuple[int, ...]:
    """Original numbers of the lights, in their present order."""
    numbers = np.asarray(origin)
    if numbers.shape != order.shape or (numbers.size and numbers.dtype.kind not in "iu"):
        raise EnvLightsError(
            f"origin must hold a number for each of {len(order)} lights; got {origin}"
        )
    return tuple(numbers[order].tolist())


def hidden_lights(fraction: NDArray[np.float64]) -> str:
    """Summary of the lights omitted from a table, or a text if there are no lights."""
    if not len(fraction):
        return "no directional light"
    hidden = fraction[MOST_ROWS:]
    more = quantity(len(hidden), "more light")
    return f"{more}, {percent(hidden.sum(), 2)} together" if len(hidden) else ""


def place_cells(lights: Lights, row: int) -> list[str]:
    """Number, azimuth, elevation and flux fraction of a light, as text."""
    fraction = f"{100 * lights.fraction[row]:.1f} %"
    return [f"{row + 1}", *angle_cells(lights.direction[row]), fraction]


def rgb_heading(units: str) -> str:
    """Column heading for `rgb_cell`."""
    return f"irradiance{in_lux(units)} (R, G, B)"


def rgb_cell(irradiance: NDArray[np.float64]) -> str:
    """Red, green and blue as aligned text."""
    return "  ".join(f"{value:>9.4g}" for value in irradiance)


def lights_of(data: dict[str, Any]) -> Lights:
    """Lights from the dictionary that `Lights.to_dict` returned."""
    # Give an empty list its second axis.
    direction = np.reshape(data["direction"], (-1, 3))
    irradiance = np.reshape(data["irradiance"], (-1, 3))
    radius: Any = data.get("angular_radius")
    # Version 1 had no units.
    scale, notes = data.get("scale", OWN_SCALE), data.get("notes", ())
    origin = data.get("origin")
    return Lights(direction, irradiance, radius, units=scale, notes=notes, origin=origin)


def lights_of_table(table: CsvTable) -> Lights:
    """Lights of a CSV file."""
    arrays = table.direction, table.irradiance, table.angular_radius
    return Lights(*arrays, units=table.units)
