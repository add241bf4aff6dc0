"""Maps with exactly known lights: for the demo, the tests and the benchmarks.

Frame and units are those of `EnvMap`; pixels are cell-centred. What a shape adds to the map is
summed from its own pixels, so the lights of a `SyntheticMap` are exact for the map as rendered.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import kernels
from envlights._check import count, reals
from envlights._native import EnvLightsError
from envlights.rig import LUMINANCE, Lights

#: Samples along each side of a pixel by which its coverage is measured.
_SUPERSAMPLING = 4

Coverage = Callable[[NDArray[np.float64]], NDArray[np.float64]]


class Shape(Protocol):
    """A light with an outline on the sphere and one radiance."""

    @property
    def radiance(self) -> ArrayLike:
        """RGB."""

    def coverage(self, height: int) -> NDArray[np.float64]:
        """Share of each pixel that the shape covers, (height, 2 * height)."""


@dataclass(frozen=True)
class Disc:
    """A round light."""

    direction: ArrayLike
    """Unit vector towards the centre."""

    angular_radius_deg: float
    """From the centre to the rim, in degrees."""

    radiance: ArrayLike
    """RGB."""

    def coverage(self, height: int) -> NDArray[np.float64]:
        """Share of each pixel inside the rim."""
        centre = _unit(self.direction)
        rim = np.cos(np.deg2rad(self.angular_radius_deg))
        rows = _rows_near(height, centre, np.deg2rad(self.angular_radius_deg))
        return _supersampled(height, rows, lambda directions: directions @ centre >= rim)


@dataclass(frozen=True)
class Rectangle:
    """A window: a flat rectangle seen head-on, upright."""

    direction: ArrayLike
    """Unit vector towards the centre."""

    width_deg: float
    """Opening angle from side to side, in degrees, below 180."""

    height_deg: float
    """Opening angle from top to bottom, in degrees, below 180."""

    radiance: ArrayLike
    """RGB."""

    def coverage(self, height: int) -> NDArray[np.float64]:
        """Share of each pixel inside the frame."""
        centre = _unit(self.direction)
        upright = [0.0, 1.0, 0.0] if abs(centre[1]) < 0.999 else [0.0, 0.0, 1.0]
        right = np.cross(upright, centre)
        right /= np.linalg.norm(right)
        up = np.cross(centre, right)
        half = np.tan(np.deg2rad([self.width_deg, self.height_deg]) / 2)

        def inside(directions: NDArray[np.float64]) -> NDArray[np.bool_]:
            depth = directions @ centre
            across, along = np.abs(directions @ right), np.abs(directions @ up)
            within: NDArray[np.bool_] = (across <= half[0] * depth) & (along <= half[1] * depth)
            return within & (depth > 0)

        rows = _rows_near(height, centre, np.arctan(np.hypot(*half)))
        return _supersampled(height, rows, inside)


@dataclass(frozen=True)
class PixelSun:
    """A sun of one pixel, as in most maps."""

    direction: ArrayLike
    """Unit vector into the pixel."""

    radiance: ArrayLike
    """RGB of the pixel."""

    def coverage(self, height: int) -> NDArray[np.float64]:
        """1 at the pixel, 0 elsewhere."""
        ((u, v),) = kernels.direction_to_uv([_unit(self.direction)])
        covered = np.zeros((height, 2 * height))
        covered[min(int(v * height), height - 1), int(u * 2 * height) % (2 * height)] = 1
        return covered


@dataclass(frozen=True, eq=False)
class SyntheticMap:
    """A map and the lights in it."""

    radiance: NDArray[np.float32]
    """Linear RGB, (height, 2 * height, 3)."""

    lights: Lights
    """Direction of each light's flux, and its irradiance above the background; brightest first."""

    solid_angle: NDArray[np.float64]
    """Of each light in steradians, in the order of `lights`."""


def scene(
    height: int, *, background: ArrayLike = (0.0, 0.0, 0.0), shapes: Sequence[Shape] = ()
) -> SyntheticMap:
    """Shapes before a background.

    Parameters
    ----------
    height : int
        Rows; the map is twice as wide.
    background : array_like, shape (3,) or (height, 2 * height, 3)
        Radiance behind the shapes.
    shapes : sequence of Disc, Rectangle or PixelSun
        Lights. Where they overlap, the last one is in front.

    Returns
    -------
    SyntheticMap

    Examples
    --------
    A disc of 5 degrees has the solid angle 2 pi (1 - cos 5 deg):

    >>> lamp = scene(256, shapes=[Disc((1, 0, 0), 5.0, (2, 2, 2))])
    >>> float(lamp.solid_angle[0].round(3)), float((2 * np.pi * (1 - np.cos(np.pi / 36))).round(3))
    (0.024, 0.024)
    """
    height = count("height", height, least=2)
    map_shape = (height, 2 * height, 3)
    backdrop = _radiance("background", background, map_shape)
    # Share of every pixel that shows each shape, after those in front of it.
    shown: list[NDArray[np.float64]] = []
    for shape in shapes:
        covered = shape.coverage(height)[..., None]
        shown = [other * (1 - covered) for other in shown] + [covered]
    radiance = backdrop.copy()
    for shape, share in zip(shapes, shown, strict=True):
        radiance += share * (_radiance("radiance", shape.radiance, (3,)) - backdrop)
    return _measured(radiance, backdrop, shapes, shown)


def _measured(
    radiance: NDArray[np.float64],
    backdrop: NDArray[np.float64],
    shapes: Sequence[Shape],
    shown: list[NDArray[np.float64]],
) -> SyntheticMap:
    """The lights of a map, summed over the pixels that they show in.

    A pixel that shows two shapes is divided between them, so no flux counts twice.
    """
    height, width, _ = radiance.shape
    solid_angles = kernels.pixel_solid_angles(height, width)[..., None]
    directions = kernels.pixel_directions(height, width)
    stored = radiance.astype(np.float32)
    direction, irradiance, solid_angle = np.zeros((3, len(shown), 3))
    for i, (shape, share) in enumerate(zip(shapes, shown, strict=True)):
        # A shape wholly behind another keeps a rounding error of its coverage.
        lit = (share[..., 0] > 1e-9).nonzero()
        added = share[lit] * (_radiance("radiance", shape.radiance, (3,)) - backdrop[lit])
        whole = radiance[lit] - backdrop[lit]
        part = np.divide(added, whole, out=np.zeros_like(whole), where=whole != 0)
        flux = (stored[lit] - backdrop[lit]) * part * solid_angles[lit]
        if not flux.any():
            raise EnvLightsError(
                f"shape {i} adds no light to the map; it must be in front, brighter than the"
                f" background, and large enough for maps {height} pixels high"
            )
        centroid = (flux.sum(axis=1, keepdims=True) * directions[lit]).sum(axis=0)
        direction[i] = centroid / np.linalg.norm(centroid)
        irradiance[i] = flux.sum(axis=0)
        solid_angle[i] = (share[lit] * solid_angles[lit]).sum()
    # The order of `Lights`: shapes may share a direction, so it cannot be found by looking.
    order = np.argsort(-(irradiance @ LUMINANCE), kind="stable")
    return SyntheticMap(stored, Lights(direction, irradiance), solid_angle[order, 0])


# A hall like that of Madsen et al. (2003), in metres, seen from the origin.
_HALL = {"left": -7.0, "right": 7.0, "floor": -1.6, "ceiling": 6.0, "windows": 6.0, "wall": -9.0}
_COLOURS = {
    "left": (0.10, 0.09, 0.075),
    "right": (0.10, 0.09, 0.075),
    "ceiling": (0.10, 0.095, 0.085),
    "floor": (0.16, 0.10, 0.07),
    "windows": (0.08, 0.072, 0.06),
    "wall": (3.0, 2.85, 2.6),
}
_WINDOW_CENTRES = (-4.4, 0.0, 4.4)
_WINDOW_HALF_WIDTH, _WINDOW_BOTTOM, _WINDOW_TOP = 0.7, 2.4, 4.4
_WINDOW_RADIANCE = np.array([[52.0, 58.0, 66.0], [66.0, 70.0, 74.0], [48.0, 53.0, 60.0]])


def hall(height: int = 512) -> SyntheticMap:
    """A hall with three bright windows, a white wall opposite and a reddish floor.

    Stands in for the hall of Madsen, Sørensen and Vittrup (2003), figure 4.

    Parameters
    ----------
    height : int
        Rows; the map is twice as wide.

    Returns
    -------
    SyntheticMap
        With the three windows as its lights.

    Examples
    --------
    >>> hall(64).lights.direction[:, 1].round(1)  # the windows are high up
    array([0.5, 0.4, 0.4])
    """
    height = count("height", height, least=2)
    fine = _room(kernels.pixel_directions(2 * height, 4 * height))
    room = fine.reshape(height, 2, 2 * height, 2, 3).mean(axis=(1, 3))
    windows = [
        _Window(x, radiance) for x, radiance in zip(_WINDOW_CENTRES, _WINDOW_RADIANCE, strict=True)
    ]
    return scene(height, background=room, shapes=windows)


@dataclass(frozen=True)
class _Window:
    """A window of the hall, with a cross of bars."""

    x: float
    radiance: ArrayLike

    def coverage(self, height: int) -> NDArray[np.float64]:
        middle = np.array([self.x, 0.5 * (_WINDOW_BOTTOM + _WINDOW_TOP), _HALL["windows"]])
        half = np.hypot(_WINDOW_HALF_WIDTH, 0.5 * (_WINDOW_TOP - _WINDOW_BOTTOM))
        distance = float(np.linalg.norm(middle))
        rows = _rows_near(height, middle / distance, np.arcsin(half / distance))
        return _supersampled(height, rows, self._glass)

    def _glass(self, directions: NDArray[np.float64]) -> NDArray[np.bool_]:
        depth = np.maximum(directions[..., 2], 1e-9)
        across = _HALL["windows"] * directions[..., 0] / depth - self.x
        up = _HALL["windows"] * directions[..., 1] / depth
        inside = (np.abs(across) < _WINDOW_HALF_WIDTH) & (up > _WINDOW_BOTTOM) & (up < _WINDOW_TOP)
        bar = (np.abs(across) < 0.04) | (np.abs(up - 0.5 * (_WINDOW_BOTTOM + _WINDOW_TOP)) < 0.04)
        return (directions[..., 2] > 0) & inside & ~bar


def _room(directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Radiance of the hall's surfaces, as if lit from the windows, without the windows."""
    x, y, z = np.moveaxis(directions, -1, 0)
    nearest = np.full(x.shape, np.inf)
    components = {"left": x, "right": x, "floor": y, "ceiling": y, "windows": z, "wall": z}
    colour = np.zeros(directions.shape)
    for name, component in components.items():
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = _HALL[name] / component
        hit = (distance > 0) & (distance < nearest)
        nearest = np.where(hit, distance, nearest)
        colour[hit] = _COLOURS[name]
    point = directions * nearest[..., None]
    # Light falls off away from the windows' middle, gently, for the bounces fill the room.
    away = point - np.array([0.0, 3.4, _HALL["windows"]])
    falloff = 1.0 / (0.5 + np.einsum("...i,...i->...", away, away) / 90.0)
    shaded: NDArray[np.float64] = colour * falloff[..., None]
    return shaded


def _rows_near(height: int, centre: NDArray[np.float64], radius: float) -> range:
    """Rows that a disc of `radius` radians around `centre` may touch."""
    theta = np.arccos(np.clip(centre[1], -1, 1))
    first = int((theta - radius) / np.pi * height) - 1
    last = int((theta + radius) / np.pi * height) + 1
    return range(max(first, 0), min(last + 1, height))


def _supersampled(
    height: int, rows: range, inside: Callable[[NDArray[np.float64]], NDArray[np.bool_]]
) -> NDArray[np.float64]:
    """Share of each pixel's samples that are inside, by solid angle where rows are thin."""
    n = _SUPERSAMPLING
    covered = np.zeros((height, 2 * height))
    u = (np.arange(2 * height * n) + 0.5) / (2 * height * n)
    for row in rows:
        v = (row * n + np.arange(n) + 0.5) / (height * n)
        uv = np.stack(np.meshgrid(u, v), axis=-1)
        seen = inside(kernels.uv_to_direction(uv.reshape(-1, 2))).reshape(n, 2 * height, n)
        weight = np.sin(np.pi * v) / np.sin(np.pi * v).sum()
        covered[row] = weight @ seen.mean(axis=2)
    return covered


def _radiance(name: str, values: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """`values` as an RGB radiance of `shape`, or a refusal that names it."""
    array = reals(name, values, np.ndim(values))
    if array.shape not in ((3,), shape) or not np.isfinite(array).all() or (array < 0).any():
        raise EnvLightsError(
            f"{name} must be finite RGB, not negative, of the shape {shape};"
            f" got the shape {array.shape}"
        )
    return np.broadcast_to(array, shape)


def _unit(direction: ArrayLike) -> NDArray[np.float64]:
    vector = reals("a direction", direction, 1)
    length = np.linalg.norm(vector)
    if vector.shape != (3,) or not np.isfinite(length) or length == 0:
        raise EnvLightsError(f"a direction must be three numbers, not all 0; got {direction!r}")
    unit: NDArray[np.float64] = vector / length
    return unit
