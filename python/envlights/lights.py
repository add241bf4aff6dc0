"""Directional lights, brightest first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import kernels
from envlights._arrays import frozen
from envlights._check import reals
from envlights._native import EnvLightsError
from envlights._result import Result
from envlights.kernels.image import LUMINANCE


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
