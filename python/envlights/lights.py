"""Directional lights, and the order in which they stand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._arrays import sealed
from envlights._check import reals, shown
from envlights._native import EnvLightsError
from envlights._result import Result
from envlights.kernels import sphere
from envlights.kernels.image import LUMINANCE


def brightest_first(irradiance: NDArray[np.float64]) -> NDArray[np.intp]:
    """Rows of `irradiance`, shape (n, 3), from the highest luminance down; equals keep their order.

    Everything that is told light by light is put in this order, all at once: directions, standard
    errors, which lights are fixed. Sorted rows stay as they are when they are sorted again. That is
    why luminance is not a matrix product here, which may round a row by the place it has.
    """
    red, green, blue = LUMINANCE[:, None] * irradiance.T
    return np.argsort(-(red + green + blue), kind="stable")


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
        direction, irradiance = light_arrays(self.direction, self.irradiance)
        order = brightest_first(irradiance)
        object.__setattr__(self, "direction", sealed(direction[order]))
        object.__setattr__(self, "irradiance", sealed(irradiance[order]))

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
    """One line for each light."""
    if not len(lights):
        return "no directional light"
    flux = lights.irradiance @ LUMINANCE
    total = flux.sum() or 1.0  # black lights have no share
    uv = sphere.direction_to_uv(lights.direction)
    lines = ["light  azimuth  elevation   share      irradiance (R, G, B)"]
    for i, ((u, v), power) in enumerate(zip(uv, flux, strict=True), start=1):
        rgb = "".join(f"{value:>11.4g}" for value in lights.irradiance[i - 1])
        share = 100 * power / total
        lines.append(f"{i:>5}  {360 * u:>6.1f}°  {90 - 180 * v:>+8.1f}°  {share:>4.1f} %{rgb}")
    return "\n".join(lines)


def light_arrays(
    direction: ArrayLike, irradiance: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Directions and irradiances as arrays, or a refusal where no renderer could use them."""
    direction = reals("direction", direction, 2)
    irradiance = reals("irradiance", irradiance, 2)
    sphere.direction_to_uv(direction)  # refuses a vector that is not of length 1
    if irradiance.shape != direction.shape:
        raise EnvLightsError(
            f"irradiance must have the shape {direction.shape}; got {irradiance.shape}"
        )
    if not np.isfinite(irradiance).all() or (irradiance < 0).any():
        raise EnvLightsError("irradiance must be finite and not negative")
    return direction, irradiance


def check_slice(which: object) -> None:
    """Refuse an index that is not a slice: a single light is not a `Lights`."""
    if not isinstance(which, slice):
        raise EnvLightsError(
            "lights are taken by slices, such as lights[:4], and one by the arrays, such as"
            f" lights.direction[0]; got {shown(which)}"
        )
