"""Directional lights with their sizes, and the order in which they stand."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._arrays import sealed
from envlights._check import reals, shown
from envlights._native import EnvLightsError
from envlights._result import Result
from envlights.envmap import EnvMap
from envlights.export.targets import save
from envlights.kernels import sphere
from envlights.kernels.image import LUMINANCE
from envlights.kernels.probe import disc_map

#: Angular radius of the sun, in radians: 0.267 degrees at its mean distance.
SUN_RADIUS = 0.00465
#: Steps that find the sharpness of a lobe; from the start taken, 4 suffice for any disc.
_NEWTON_STEPS = 6


def brightest_first(irradiance: NDArray[np.float64]) -> NDArray[np.intp]:
    """Rows of `irradiance`, shape (n, 3), from the highest luminance down; equals keep their order.

    Everything that is told light by light is put in this order, all at once: directions, standard
    errors, which lights are fixed. Sorted rows stay as they are when they are sorted again. That is
    why luminance is not a matrix product here, which may round a row by the place it has.
    """
    red, green, blue = LUMINANCE[:, None] * irradiance.T
    luminance = red + green + blue
    # Luminances that differ by rounding alone are equal.
    unit = max(luminance.max(initial=0.0), np.finfo(float).tiny)
    return np.argsort(-np.round(luminance / unit, 9), kind="stable")


class SphericalGaussians(NamedTuple):
    """Lobes of radiance ``amplitude * exp(sharpness * (axis . w - 1))`` in each direction w."""

    axis: NDArray[np.float64]
    """Unit vectors, (n, 3)."""

    sharpness: NDArray[np.float64]
    """Greater for a narrower lobe, (n,)."""

    amplitude: NDArray[np.float64]
    """Radiance along the axis, linear RGB, (n, 3)."""


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
    angular_radius : array_like, shape (n,), optional
        In radians, from 0 to pi / 2: the light is a disc of one radiance, which is its irradiance
        over :math:`\pi \sin^2 a`. 0 is a point. All are points when left out.

    Examples
    --------
    >>> lights = Lights([[0, 1, 0], [1, 0, 0]], [[1, 1, 1], [5, 4, 3]], [0.5, 0.0])
    >>> lights.direction[0], lights.angular_radius
    (array([1., 0., 0.]), array([0. , 0.5]))
    >>> len(lights), len(lights[:1])
    (2, 1)
    """

    direction: NDArray[np.float64]
    irradiance: NDArray[np.float64]
    # Once it is made, every light has a radius.
    angular_radius: NDArray[np.float64] = None  # type: ignore[assignment]

    def __post_init__(self) -> None:
        direction, irradiance = light_arrays(self.direction, self.irradiance)
        radius = _radii(self.angular_radius, len(direction))
        order = brightest_first(irradiance)
        object.__setattr__(self, "direction", sealed(direction[order]))
        object.__setattr__(self, "irradiance", sealed(irradiance[order]))
        object.__setattr__(self, "angular_radius", sealed(radius[order]))

    def __len__(self) -> int:
        return len(self.direction)

    def __getitem__(self, which: slice) -> Lights:
        check_slice(which)
        return Lights(self.direction[which], self.irradiance[which], self.angular_radius[which])

    def in_short(self) -> str:
        """How many there are."""
        return f"{len(self)} light{'' if len(self) == 1 else 's'}"

    def __str__(self) -> str:
        return _table(self)

    def to_dict(self) -> dict[str, Any]:
        """Lists of numbers, for JSON and the like."""
        return {
            "direction": self.direction.tolist(),
            "irradiance": self.irradiance.tolist(),
            "angular_radius": self.angular_radius.tolist(),
        }

    def save(
        self, path: str | os.PathLike[str], environment: EnvMap | ArrayLike | None = None
    ) -> None:
        """Write the lights in the format that the suffix names, whole or not at all.

        Parameters
        ----------
        path : path-like
            `el.export.TARGETS` lists the suffixes, and what each format keeps and loses.
        environment : EnvMap or array_like, optional
            A map around the lights, such as the rest of a split map, for targets that take one.
        """
        save(self, path, environment)

    def discs(self) -> Lights:
        """The lights as discs of one radiance: they are."""
        return self

    def to_map(self, height: int) -> EnvMap:
        """The lights as discs before a black sky: labels to learn from, and a way to any renderer.

        Pixels on the rim of a disc are as bright as the share of them that it covers. Surfaces that
        have all of a disc before them receive exactly its irradiance, up to single precision.
        A point becomes a disc with a radius of one pixel, the smallest that keeps its irradiance
        and its direction wherever it stands, and in which `detect` finds them again.

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
        arrays = discs.direction, discs.irradiance, discs.angular_radius
        return EnvMap(disc_map(height, *arrays))

    def spherical_gaussians(self) -> SphericalGaussians:
        r"""The lights as lobes for engines that take those.

        Returns
        -------
        SphericalGaussians
            With the irradiance of each light at normal incidence. The spread of a lobe, its mean of
            1 - cos, is that of the disc; points become as narrow as the disc of the sun.

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
        sharpness = _sharpness(np.sin(np.maximum(discs.angular_radius, SUN_RADIUS) / 2) ** 2)
        at_normal = 2 * np.pi * (sharpness - 1 + np.exp(-sharpness)) / sharpness**2
        amplitude = discs.irradiance / at_normal[:, None]
        return SphericalGaussians(discs.direction, sealed(sharpness), sealed(amplitude))


def _table(lights: Lights) -> str:
    """One line for each light."""
    if not len(lights):
        return "no directional light"
    flux = lights.irradiance @ LUMINANCE
    total = flux.sum() or 1.0  # black lights have no share
    uv = sphere.direction_to_uv(lights.direction)
    sizes = [f"  {radius:>5.2f}°" for radius in np.rad2deg(lights.angular_radius)]
    if not lights.angular_radius.any():
        sizes = [""] * len(lights)
    header = "   radius" if any(sizes) else ""
    lines = [f"light  azimuth  elevation   share{header}      irradiance (R, G, B)"]
    for i, ((u, v), power) in enumerate(zip(uv, flux, strict=True)):
        rgb = "".join(f"{value:>11.4g}" for value in lights.irradiance[i])
        place = f"{i + 1:>5}  {360 * u:>6.1f}°  {90 - 180 * v:>+8.1f}°"
        lines.append(f"{place}  {100 * power / total:>4.1f} %{sizes[i]}{rgb}")
    return "\n".join(lines)


def _radii(values: ArrayLike | None, lights: int) -> NDArray[np.float64]:
    """A radius for each light, or a refusal where it is no disc."""
    if values is None:
        return np.zeros(lights)
    radii = reals("angular_radius", values, 1)
    if len(radii) != lights:
        raise EnvLightsError(
            f"angular_radius must have a row for each light ({lights}); got {len(radii)}"
        )
    bad = np.flatnonzero(~((radii >= 0) & (radii <= np.pi / 2)))
    if len(bad):
        raise EnvLightsError(
            "angular_radius must be from 0 to pi / 2 radians;"
            f" row {bad[0]} holds {radii[bad[0]]:.6g}"
        )
    return radii


def _sharpness(spread: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sharpness of lobes whose mean of 1 - cos is `spread`, below 1: 1 + 1/k - coth k, inverted."""
    # Start near the solution (Banerjee et al. 2005, equation 4.4), and take Newton's steps.
    mean = 1 - spread
    k = mean * (3 - mean**2) / (spread * (1 + mean))
    for _ in range(_NEWTON_STEPS):
        # coth k - 1 = 2 / (e^2k - 1), without cancellation and overflow.
        beyond = 2 * np.exp(-2 * k) / -np.expm1(-2 * k)
        slope = 1 / k**2 - beyond * (2 + beyond)
        k = k + (1 / k - beyond - spread) / slope
    return k


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
