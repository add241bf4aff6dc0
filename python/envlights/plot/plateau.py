"""Picture of a clipped map: clipped regions, their depth, and the lights in them."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from envlights import _native
from envlights._common.words import percent
from envlights._native import EnvLightsError
from envlights.detection.lights import DetectedLights
from envlights.environment.envmap import EnvMap
from envlights.environment.reading import AnyMap, as_envmap
from envlights.environment.repair import PLATEAU_COLUMNS, PLATEAU_GAP
from envlights.plot.figure import check_is
from envlights.plot.ground import EXTENT, degrees, draw_frame, draw_map
from envlights.plot.markers import (
    RIM,
    draw_discs,
    draw_legend,
    draw_numbers,
    draw_rims,
    number_colours,
    sizes_for,
)
from envlights.plot.page import Placement, Unpack, grid, open_page, placed_picture
from envlights.plot.wording import entitle

#: RGBA colour of clipped pixels.
_CLIPPED = (0.0, 0.75, 1.0, 0.5)


@placed_picture
def plateau_picture(env: AnyMap, lights: DetectedLights, **where: Unpack[Placement]) -> Figure:
    """Draw a clipped map, its clipped regions, and the lights in them.

    Above: the map, with clipped pixels in blue. Below: the depth of the clipped regions, which is
    the angle to their rim and separates the lights. Discs mark the directions of the lights, with
    areas in proportion to their estimated weights. A circle around each shows the uncertainty of
    its direction.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        Map with a clip level: of 8 or 16 bits, or made with `clip_level`.
    lights : DetectedLights
        The result of `detect` on it.
    **where
        `ax`: two axes; `figsize`, `dpi`, `transparent`: see `envlights.plot`.

    Raises
    ------
    EnvLightsError
        If the map has no clip level, or the lights are those of a map that is not clipped.

    Examples
    --------
    >>> import envlights as el
    >>> lamp = el.synthetic.Disc((1, 0.5, 0), 8.0, (9, 9, 9))
    >>> scene = el.synthetic.scene(128, background=[0.1] * 3, shapes=[lamp])
    >>> env = el.EnvMap(np.minimum(scene.radiance, 1), clip_level=1.0)
    >>> figure = plateau_picture(env, el.detect(env))
    >>> len(figure.axes)
    3
    """
    check_is("lights", lights, DetectedLights)
    env = as_envmap(env)
    if env.clip_level is None:
        raise EnvLightsError(
            "the map has no clip level; give one of 8 or 16 bits, or `EnvMap(..., clip_level=...)`"
        )
    weight, uncertainty = lights.weight, lights.direction_uncertainty
    if weight is None or uncertainty is None:
        if len(lights):
            raise EnvLightsError(
                "the lights are those of a map that is not clipped; give those of a clipped map"
            )
        weight = uncertainty = np.zeros(0)
    page = open_page(where, grid(2, 1), (10, 10.8))
    above, below = page.panels
    exposure = draw_map(above, env)
    above.imshow(_tint(env, env.clip_level), extent=EXTENT)
    entitle(above, exposure, "small")
    depth = _draw_depth(below, env, env.clip_level)
    page.figure.colorbar(depth, ax=page.panels, label="depth of clipped regions (°)", shrink=0.6)
    fraction = weight / (weight.sum() or 1.0)
    for axes in page.panels:
        draw_rims(axes, lights.direction, uncertainty)
        # Draw discs half as large as for a rig, because lamps may be close together.
        at, areas = degrees(lights.direction), sizes_for(axes, fraction, 0.5).area(fraction)
        draw_discs(axes, at, areas, lights.irradiance)
        draw_numbers(axes, at, areas, colours=number_colours(uncertainty))
    clipped = Patch(color=_CLIPPED, label="clipped")
    circle = Line2D([], [], color=RIM, lw=1.4, label="uncertainty of the direction")
    draw_legend(below, [clipped, circle])
    sphere, flux = (percent(part, 2) for part in (env.clipped_fraction, env.clipped_flux_fraction))
    page.entitle(
        f"{lights.in_short()} in clipped regions\n"
        f"{sphere} of the sphere is clipped, with {flux} of the light"
    )
    return page.figure


def _tint(env: EnvMap, clip_level: float) -> NDArray[np.uint8]:
    """RGBA overlay that marks the clipped pixels."""
    rows, columns = max(env.height // 512, 1), max(env.width // 1024, 1)
    largest: NDArray[np.float32] = env.radiance[::rows, ::columns].max(axis=2, keepdims=True)
    colour = np.round(255 * np.array(_CLIPPED)).astype(np.uint8)
    return np.where(largest >= _native.LEAST_WHITE * clip_level, colour, np.uint8(0))


def _draw_depth(axes: Axes, env: EnvMap, clip_level: float) -> AxesImage:
    """Draw the depth of the clipped regions in degrees."""
    how = (clip_level, PLATEAU_COLUMNS, PLATEAU_GAP)
    depth = np.rad2deg(_native.clipped_depth(env.radiance, env.is_border_sampled, *how))
    image = axes.imshow(np.where(depth > 0, depth, np.nan), cmap="viridis", vmin=0, extent=EXTENT)
    # Use a dark background, as in most maps, so that all markers are visible.
    axes.set(facecolor="0.15")
    draw_frame(axes)
    return image
