"""The hall of the demo."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import count
from envlights.kernels import sphere
from envlights.synthetic.scene import MOST_ROWS, SyntheticMap, scene
from envlights.synthetic.shapes import supersample, unit

# A hall like that of Madsen et al. (2003), in metres; the camera is at the origin.
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
    """Hall with three bright windows, a white wall opposite and a reddish floor.

    It resembles the hall of Madsen, Sørensen and Vittrup (2003), figure 4.

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
    height = count("height", height, least=2, most=MOST_ROWS)
    # Render the room at twice the size, and reduce it to smooth its edges.

    def mean_radiance(directions: NDArray[np.float64]) -> NDArray[np.float64]:
        means: NDArray[np.float64] = (
            _room(directions).reshape(-1, 2, 2 * height, 2, 3).mean(axis=(1, 3))
        )
        return means

    room = sphere.over_map(height, mean_radiance, finer=2)
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
        reach_deg = float(np.rad2deg(np.arcsin(half / distance)))
        return supersample(height, unit(middle), reach_deg, self._glass)

    def _glass(self, directions: NDArray[np.float64]) -> NDArray[np.bool_]:
        depth = np.maximum(directions[..., 2], 1e-9)
        across = _HALL["windows"] * directions[..., 0] / depth - self.x
        up = _HALL["windows"] * directions[..., 1] / depth
        inside = (np.abs(across) < _WINDOW_HALF_WIDTH) & (up > _WINDOW_BOTTOM) & (up < _WINDOW_TOP)
        bar = (np.abs(across) < 0.04) | (np.abs(up - 0.5 * (_WINDOW_BOTTOM + _WINDOW_TOP)) < 0.04)
        return (directions[..., 2] > 0) & inside & ~bar


def _room(directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Radiance of the hall's surfaces under light from the windows, without the windows."""
    # Find the nearest surface in each direction, and its colour.
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
    # Let the light fall off from the middle window, gently, because bounces fill the room.
    away = point - np.array([0.0, 3.4, _HALL["windows"]])
    falloff = 1.0 / (0.5 + np.einsum("...i,...i->...", away, away) / 90.0)
    shaded: NDArray[np.float64] = colour * falloff[..., None]
    return shaded
