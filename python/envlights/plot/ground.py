"""Map as the background of a picture, exposed so that its lamps are visible."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from numpy.typing import NDArray

from envlights._common.words import percent
from envlights.environment.envmap import EnvMap
from envlights.kernels import sphere, thumbnails
from envlights.kernels.image import LUMINANCE
from envlights.plot.wording import LETTER, font_size, is_narrow, points_per_unit

#: Columns of the picture of a map.
_COLUMNS = 1024
#: Extent of a map on its axes, in degrees.
EXTENT = (0.0, 360.0, -90.0, 90.0)
#: Range of the luminance scale in stops, below and above white.
_BELOW, _ABOVE = 8, 6
#: Quantile of the pixels of a rendering that is displayed as white.
WHITE = 0.99
#: Distance of the ticks of the scale, in stops.
_STEP = 2
#: Width of an azimuth tick label in letters, with its gap.
_MARK = 4.5


def working(env: EnvMap) -> NDArray[np.float32]:
    """Radiance of a map, averaged to fewer than 2048 columns."""
    # Skip pixels of a very large map before averaging.
    step = max(env.width // (4 * _COLUMNS), 1)
    return thumbnails.shrink(env.radiance[::step, ::step], _COLUMNS).astype(np.float32)


class Ground(NamedTuple):
    """Map as a picture, with its exposure."""

    codes: NDArray[np.uint8]
    """8-bit colours of the picture, (height, width, 3)."""

    white: float
    """Luminance displayed as white."""

    exposure: str
    """Sentence that states the exposure."""


def expose(radiance: NDArray[np.float32]) -> Ground:
    """Expose a map, in the form of `working`, so that its lamps are visible."""
    white, darker = thumbnails.white_of(radiance)
    words = f"white is luminance {white:.3g}; {percent(darker)} of the sphere is darker"
    return Ground(thumbnails.expose(radiance, white), white, words)


def white_of(image: NDArray[np.float64]) -> float:
    """Luminance of a rendering, (height, width, 3), that is displayed as white."""
    return max(float(np.quantile(image @ LUMINANCE, WHITE)), np.finfo(float).tiny)


def draw_ground(axes: Axes, codes: NDArray[np.uint8]) -> None:
    """Draw the colours of a map."""
    axes.imshow(codes, extent=EXTENT, interpolation="antialiased")
    draw_frame(axes)


def draw_small_ground(axes: Axes, codes: NDArray[np.uint8]) -> None:
    """Draw the colours of a map without ticks and labels."""
    axes.set(xticks=[], yticks=[])
    axes.imshow(codes, extent=EXTENT, interpolation="antialiased")
    axes.set(xlim=EXTENT[:2], ylim=EXTENT[2:])


def draw_map(axes: Axes, env: EnvMap) -> str:
    """Draw a map, and return a sentence that states its exposure."""
    ground = expose(working(env))
    draw_ground(axes, ground.codes)
    return ground.exposure


def draw_luminance(axes: Axes, env: EnvMap) -> str:
    """Draw luminance in stops relative to white in `draw_map`; return a sentence on it."""
    radiance = working(env)
    white, _ = thumbnails.white_of(radiance)
    # Black is below every stop.
    ratio = np.maximum(radiance @ LUMINANCE / white, np.finfo(float).tiny)
    image = axes.imshow(
        np.log2(ratio),
        extent=EXTENT,
        cmap=colormaps["inferno"],
        norm=Normalize(-_BELOW, _ABOVE),
        interpolation="antialiased",
    )
    draw_frame(axes)
    bar = axes.figure.colorbar(image, ax=axes, extend="both", shrink=0.7)
    bar.set_label("stops")
    bar.set_ticks(range(-_BELOW, _ABOVE + 1, _STEP))
    return f"luminance in stops from {white:.3g}"


def draw_frame(axes: Axes) -> None:
    """Label azimuth and elevation, with as many ticks as their labels have room for."""
    points, mark = points_per_unit(axes, EXTENT), _MARK * LETTER * font_size("xtick.labelsize")
    step = next((each for each in (45, 90) if points * each > mark), 180)
    if not is_narrow(axes):
        axes.set(xlabel="azimuth (°)", ylabel="elevation (°)")
    axes.set(xticks=range(0, 361, step), yticks=range(-90, 91, min(step, 90)))
    axes.set(xlim=EXTENT[:2], ylim=EXTENT[2:])


def degrees(directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Azimuth and elevation of `directions`, shape (n, 2)."""
    found: NDArray[np.float64] = sphere.direction_to_uv(directions) * (360, -180) + (0, 90)
    return found
