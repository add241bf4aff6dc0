"""Orthographic image of a ball: normals, and an antialiased rim."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from numpy.typing import NDArray

from envlights.plot.figure import hide_frame

#: Diameter of a ball in pixels.
_SIZE = 192


class Ball(NamedTuple):
    """Pixels of a ball for a view direction."""

    normals: NDArray[np.float64]
    """Unit normal of each pixel in `inside`, (n, 3)."""

    inside: NDArray[np.bool_]
    """Mask of pixels that the ball covers at least partly, (size, size)."""

    cover: NDArray[np.float64]
    """Covered fraction of each pixel in `inside`, (n,)."""

    def image(self, colours: NDArray[np.floating]) -> NDArray[np.float64]:
        """RGBA image from colours of the covered pixels, (n, 3), transparent elsewhere."""
        drawn = np.zeros((*self.inside.shape, 4))
        drawn[self.inside] = np.column_stack([colours, self.cover])
        return drawn

    def values(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Image from values of the covered pixels, NaN elsewhere."""
        drawn = np.full(self.inside.shape, np.nan)
        drawn[self.inside] = values
        return drawn


def draw_rim(axes: Axes, centre: tuple[float, float], radius: float) -> None:
    """Draw a thin outline around a ball, which separates white balls from a white page."""
    line = Circle(
        centre, radius, fill=False, lw=0.6, ec=rcParams["axes.edgecolor"], alpha=0.6, clip_on=False
    )
    axes.add_patch(line)


def draw_ball(axes: Axes, image: NDArray[np.floating]) -> None:
    """Draw the image of a ball with its outline."""
    axes.imshow(image, interpolation="antialiased")
    middle, radius = (len(image) - 1) / 2, len(image) / 2
    draw_rim(axes, (middle, middle), radius)
    hide_frame(axes)


def axes_of(eye: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Unit vectors right and up, for a viewer in the direction `eye`."""
    pole = np.array([0.0, 1.0, 0.0]) if abs(eye[1]) < 0.999 else np.array([0.0, 0.0, 1.0])
    right = np.cross(pole, eye)
    right /= np.linalg.norm(right)
    return right, np.cross(eye, right)


def ball(eye: NDArray[np.float64]) -> Ball:
    """Ball seen from the direction `eye`."""
    right, up = axes_of(eye)
    at = (2 * np.arange(_SIZE) + 1) / _SIZE - 1
    across, down = np.meshgrid(at, at)
    radius = np.hypot(across, down)
    # The rim crosses a pixel whose centre is within half a pixel of it.
    cover = np.clip((1 - radius) * _SIZE / 2 + 0.5, 0, 1)
    inside = cover > 0
    # Beyond the rim, use the normal at the rim.
    scale = np.minimum(1 / radius[inside], 1)
    across, down = scale * across[inside], scale * down[inside]
    towards = np.sqrt(np.maximum(1 - across**2 - down**2, 0))
    normals = across[:, None] * right - down[:, None] * up + towards[:, None] * eye
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Ball(normals, inside, cover[inside])
