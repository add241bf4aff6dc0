"""Orthographic image of a ball: normals, and a smooth rim."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from numpy.typing import NDArray

from envlights.plot.figure import hide_frame

#: Pixels across a ball.
_SIZE = 192


class Ball(NamedTuple):
    """Pixels of a ball seen from one direction."""

    normals: NDArray[np.float64]
    """Unit normal of each pixel of `inside`, (n, 3)."""

    inside: NDArray[np.bool_]
    """Pixels that the ball covers, even in part, (size, size)."""

    cover: NDArray[np.float64]
    """Covered fraction of each of these pixels, (n,)."""

    def image(self, colours: NDArray[np.floating]) -> NDArray[np.float64]:
        """RGBA image of the colours of its pixels, (n, 3), clear around the ball."""
        drawn = np.zeros((*self.inside.shape, 4))
        drawn[self.inside] = np.column_stack([colours, self.cover])
        return drawn

    def values(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Image of one value for each pixel, NaN around the ball."""
        drawn = np.full(self.inside.shape, np.nan)
        drawn[self.inside] = values
        return drawn


def draw_rim(axes: Axes, centre: tuple[float, float], radius: float) -> None:
    """Draw a thin line around a ball, which separates white ones from a white page."""
    line = Circle(
        centre, radius, fill=False, lw=0.6, ec=rcParams["axes.edgecolor"], alpha=0.6, clip_on=False
    )
    axes.add_patch(line)


def draw_ball(axes: Axes, image: NDArray[np.floating]) -> None:
    """Draw the image of a ball with its rim."""
    axes.imshow(image, interpolation="antialiased")
    middle, radius = (len(image) - 1) / 2, len(image) / 2
    draw_rim(axes, (middle, middle), radius)
    hide_frame(axes)


def axes_of(eye: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Unit vectors to the right and up, as seen from the direction `eye`."""
    pole = np.array([0.0, 1.0, 0.0]) if abs(eye[1]) < 0.999 else np.array([0.0, 0.0, 1.0])
    right = np.cross(pole, eye)
    right /= np.linalg.norm(right)
    return right, np.cross(eye, right)


def ball(eye: NDArray[np.float64]) -> Ball:
    """The ball from the direction `eye`."""
    right, up = axes_of(eye)
    at = (2 * np.arange(_SIZE) + 1) / _SIZE - 1
    across, down = np.meshgrid(at, at)
    radius = np.hypot(across, down)
    # The rim runs through a pixel where its centre is within half a pixel of it.
    cover = np.clip((1 - radius) * _SIZE / 2 + 0.5, 0, 1)
    inside = cover > 0
    # Beyond the rim, the colour is that at the rim.
    scale = np.minimum(1 / radius[inside], 1)
    across, down = scale * across[inside], scale * down[inside]
    towards = np.sqrt(np.maximum(1 - across**2 - down**2, 0))
    normals = across[:, None] * right - down[:, None] * up + towards[:, None] * eye
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Ball(normals, inside, cover[inside])
