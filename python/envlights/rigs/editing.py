"""Edits of single lights; each edit returns new lights, and the original stays unchanged."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import amount, colour, unit_vector
from envlights._native import EnvLightsError
from envlights.kernels.angles import azimuths, direction_at, elevations
from envlights.kernels.image import LUMINANCE
from envlights.rigs.light_arrays import row_of
from envlights.rigs.planck import planck_gains

#: Lights without measurements.
Plain = TypeVar("Plain")

#: Elevation of the zenith.
_POLE = np.pi / 2


def _radius(value: float) -> float:
    return amount("angular_radius", value, most=np.pi / 2)


class Editable(ABC, Generic[Plain]):
    """Editing methods of `Lights`.

    Numbers of lights are those in the lights that are changed, from 0; a change of brightness may
    give them another order. `Lights.origin` tells which light is which.
    """

    direction: NDArray[np.float64]
    irradiance: NDArray[np.float64]
    angular_radius: NDArray[np.float64]

    def moved(
        self,
        which: int,
        direction: ArrayLike | None = None,
        *,
        azimuth: float | None = None,
        elevation: float | None = None,
    ) -> Plain:
        """Lights with one light moved to another direction.

        Parameters
        ----------
        which : int
            Number of the light.
        direction : array_like, shape (3,), optional
            New direction, of any length above 0.
        azimuth, elevation : float, optional
            New angles in radians, as `Lights.azimuth` and `Lights.elevation` have them, in place of
            `direction`; the one that is not given stays.

        Raises
        ------
        IndexError
            If there is no such light, as for `lights[which]`.
        EnvLightsError
            If neither or both a direction and an angle are given.

        Examples
        --------
        >>> from envlights import Lights
        >>> sun = Lights([[1, 0, 0]], [[3, 2, 1]])
        >>> sun.moved(0, [0, 2, 0]).direction
        array([[0., 1., 0.]])
        >>> sun.moved(0, elevation=0.25).elevation
        array([0.25])
        """
        row = row_of(which, len(self.direction))
        if (direction is None) == (azimuth is None and elevation is None):
            raise EnvLightsError("give a direction, or an azimuth or an elevation in radians")
        if direction is not None:
            return self._with_row("direction", row, unit_vector("direction", direction))
        old = self.direction[[row]]
        angles = (
            azimuths(old)[0] if azimuth is None else amount("azimuth", azimuth, -np.inf),
            elevations(old)[0]
            if elevation is None
            else amount("elevation", elevation, -_POLE, _POLE),
        )
        return self._with_row("direction", row, direction_at(*angles))

    def dimmed(self, which: int, factor: float) -> Plain:
        """Lights with the irradiance of one light multiplied by a non-negative factor.

        Examples
        --------
        >>> from envlights import Lights
        >>> Lights([[0, 1, 0]], [[4, 2, 1]]).dimmed(0, 0.5).irradiance
        array([[2. , 1. , 0.5]])
        """
        row = row_of(which, len(self.direction))
        return self._with_row("irradiance", row, self.irradiance[row] * amount("factor", factor))

    def coloured(
        self, which: int, rgb: ArrayLike | None = None, *, kelvin: float | None = None
    ) -> Plain:
        """Lights with one light in another colour of the same luminance.

        Parameters
        ----------
        which : int
            Number of the light.
        rgb : array_like, shape (3,), optional
            Linear RGB of any luminance above 0.
        kelvin : float, optional
            Colour temperature from 2000 to 15000 in place of `rgb`; white has 6504.

        Examples
        --------
        >>> from envlights import Lights
        >>> lights = Lights([[0, 1, 0]], [[1, 1, 1]])
        >>> lights.coloured(0, [2, 1, 0]).irradiance.round(3)
        array([[1.754, 0.877, 0.   ]])
        """
        row = row_of(which, len(self.direction))
        if (rgb is None) == (kelvin is None):
            raise EnvLightsError("give rgb or kelvin")
        if rgb is None:
            channels = np.array(planck_gains(amount("kelvin", kelvin, 2000.0, 15000.0)))
        else:
            channels = np.array(colour("rgb", rgb))
        if not channels.any():
            raise EnvLightsError("rgb must not be black; dim the light, or leave it out")
        luminance = self.irradiance[row] @ LUMINANCE
        return self._with_row("irradiance", row, channels * (luminance / (channels @ LUMINANCE)))

    def resized(self, which: int, angular_radius: float) -> Plain:
        """Lights with another angular radius, in radians, of one light, and unchanged irradiance.

        Examples
        --------
        >>> from envlights import Lights
        >>> Lights([[0, 1, 0]], [[1, 1, 1]]).resized(0, 0.1).angular_radius
        array([0.1])
        """
        row = row_of(which, len(self.direction))
        return self._with_row("angular_radius", row, _radius(angular_radius))

    def without(self, which: int) -> Plain:
        """Lights without the given one.

        Examples
        --------
        >>> from envlights import Lights
        >>> len(Lights([[0, 1, 0], [1, 0, 0]], [[2, 2, 2], [1, 1, 1]]).without(0))
        1
        """
        row = row_of(which, len(self.direction))
        arrays = self._arrays()
        return self._edited(
            **{name: np.delete(array, row, axis=0) for name, array in arrays.items()}
        )

    def with_light(
        self, direction: ArrayLike, irradiance: ArrayLike, angular_radius: float = 0.0
    ) -> Plain:
        """Lights with an additional one.

        Parameters
        ----------
        direction : array_like, shape (3,)
            Direction towards the light, of any length above 0.
        irradiance : array_like, shape (3,)
            Linear RGB at normal incidence.
        angular_radius : float
            Radius of the disc in radians; 0 is a point.

        Examples
        --------
        >>> from envlights import Lights
        >>> lights = Lights([[0, 1, 0]], [[1, 1, 1]]).with_light([0, 0, 5], [3, 3, 3])
        >>> lights.direction, lights.origin
        (array([[0., 0., 1.],
               [0., 1., 0.]]), (-1, 0))
        """
        row = {
            "direction": unit_vector("direction", direction),
            "irradiance": colour("irradiance", irradiance),
            "angular_radius": _radius(angular_radius),
            "origin": -1,
        }
        arrays = self._arrays()
        return self._edited(
            **{name: np.concatenate([array, [row[name]]]) for name, array in arrays.items()}
        )

    def _with_row(self, name: str, row: int, value: Any) -> Plain:
        """Lights with a value replaced in one row of an array field."""
        array = self._arrays()[name].copy()
        array[row] = value
        return self._edited(**{name: array})

    @abstractmethod
    def _arrays(self) -> dict[str, NDArray[Any]]:
        """Array fields of `Lights`, without measurements of a detection."""

    @abstractmethod
    def _edited(self, **changed: NDArray[Any]) -> Plain:
        """Lights with some array fields replaced."""
