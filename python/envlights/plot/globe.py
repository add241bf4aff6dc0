"""Picture of the sphere from outside, with a map, lights and samples on it."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from envlights._common.srgb import encode_srgb
from envlights.environment.envmap import EnvMap
from envlights.environment.reading import AnyMap, as_envmap
from envlights.kernels import sphere, thumbnails
from envlights.plot.ball import axes_of, ball, draw_rim
from envlights.plot.figure import check_is, hide_frame
from envlights.plot.ground import working
from envlights.plot.markers import draw_discs, sizes_for
from envlights.plot.page import Placement, Unpack, grid, open_page, placed_picture
from envlights.rigs.lights import Lights

#: Extent of a map on which a degree has the same size as on the globe.
_AS_MAP = (0.0, 180.0, 0.0, 180.0)
#: Elevation of the viewer, in degrees.
_ELEVATION = 25


@placed_picture
def sphere_picture(env: AnyMap, lights: Lights, **where: Unpack[Placement]) -> Figure:
    """Draw lights on the sphere of directions, with the map on it, from two opposite views.

    The sphere is seen from outside, so the map is mirrored. The left view is from the side of the
    brightest light, the right one from the opposite side. Discs are those of `picture`.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map.
    lights : Lights or DetectedLights
        Lights of a rig, or detected lights.
    **where
        `ax`: two axes; `figsize`, `dpi`, `transparent`: see `envlights.plot`.

    Examples
    --------
    >>> import envlights as el
    >>> env = el.EnvMap(el.synthetic.hall(64).radiance)
    >>> figure = sphere_picture(env, el.detect(env))
    >>> [axes.get_title() for axes in figure.axes]
    ['from azimuth 180°, elevation 25°', 'from azimuth 0°, elevation -25°']
    """
    check_is("lights", lights, Lights)
    env = as_envmap(env)
    azimuth = float(lights.azimuth[0]) if len(lights) else np.pi
    elevation = np.deg2rad(_ELEVATION)
    page = open_page(where, grid(1, 2), (10, 5.5))
    for axes, (phi, up) in zip(
        page.panels, ((azimuth, elevation), (azimuth + np.pi, -elevation)), strict=True
    ):
        eye = np.array([np.sin(phi) * np.cos(up), np.sin(up), -np.cos(phi) * np.cos(up)])
        draw_globe(axes, env, eye)
        _draw_lights(axes, lights, eye)
        degrees = f"azimuth {np.rad2deg(phi) % 360:.0f}°, elevation {np.rad2deg(up):.0f}°"
        axes.set_title(f"from {degrees}")
    page.entitle(lights.in_short())
    return page.figure


def draw_globe(axes: Axes, env: EnvMap, eye: NDArray[np.float64]) -> None:
    """Draw the sphere with the map on it, on axes from -1 to 1."""
    radiance = working(env)
    seen = ball(eye)
    height, width, _ = radiance.shape
    u, v = sphere.direction_to_uv(seen.normals).T
    columns = np.minimum((u * width).astype(int), width - 1)
    rows = np.minimum((v * height).astype(int), height - 1)
    colours = encode_srgb(radiance[rows, columns] / thumbnails.white_of(radiance)[0])
    axes.imshow(seen.image(colours), extent=(-1, 1, -1, 1), interpolation="antialiased")
    draw_rim(axes, (0, 0), 1)
    axes.set(xlim=(-1.08, 1.08), ylim=(-1.08, 1.08))
    hide_frame(axes)


def on_page(
    directions: NDArray[np.float64], eye: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Positions of directions on the axes, (n, 2), and a mask of the visible ones."""
    right, up = axes_of(eye)
    return np.stack([directions @ right, directions @ up], axis=1), directions @ eye > 0


def _draw_lights(axes: Axes, lights: Lights, eye: NDArray[np.float64]) -> None:
    at, is_near = on_page(lights.direction, eye)
    areas = sizes_for(axes, lights.fraction, extent=_AS_MAP).area(lights.fraction)
    draw_discs(axes, at[is_near], areas[is_near], lights.irradiance[is_near])
