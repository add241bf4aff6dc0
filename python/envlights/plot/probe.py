"""The white probe under a map and under a rig, and their difference."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from envlights._srgb import encode_srgb
from envlights.envmap import EnvMap
from envlights.fitting.asked import above_horizon
from envlights.kernels import sphere
from envlights.kernels.image import LUMINANCE
from envlights.kernels.probe import working_irradiance
from envlights.plot.ball import Ball, ball
from envlights.rig import Rig


def draw_probes(figure: Figure, axes: Sequence[Axes], env: EnvMap, rig: Rig) -> tuple[float, float]:
    """Draw the probe under the map, under the rig, and the difference, each on its axes.

    Returns
    -------
    azimuth, elevation : float
        Where the probe is looked at from, in degrees.
    """
    eye = viewpoint(rig)
    seen = ball(eye)
    # A floor hides the same from both.
    world = above_horizon(env) if rig.floor else env
    under_map, under_rig = under(world, seen.normals), rig.probe(seen.normals)
    white = max(float((under_map @ LUMINANCE).max()), np.finfo(float).tiny)
    for axis, name, irradiance in zip(axes, ("map", "rig"), (under_map, under_rig), strict=False):
        axis.imshow(seen.image(encode_srgb(irradiance / white)), interpolation="antialiased")
        axis.set_title(f"probe under the {name}")
        axis.axis("off")
    _draw_difference(figure, axes[2], seen, under_map, under_rig)
    ((u, v),) = sphere.direction_to_uv([eye])
    return 360 * u, 90 - 180 * v


def _draw_difference(
    figure: Figure,
    axes: Axes,
    seen: Ball,
    under_map: NDArray[np.float64],
    under_rig: NDArray[np.float64],
) -> None:
    wanted = under_map @ LUMINANCE
    percent = 100 * (under_rig @ LUMINANCE - wanted) / max(wanted.mean(), np.finfo(float).tiny)
    limit = max(float(np.abs(percent).max()), 0.1)
    values, cover = seen.values(percent), seen.values(seen.cover)
    image = axes.imshow(values, cmap="RdBu_r", vmin=-limit, vmax=limit, alpha=np.nan_to_num(cover))
    axes.set_title("rig minus map")
    axes.axis("off")
    figure.colorbar(image, ax=axes, label="% of the mean", shrink=0.85)


def under(env: EnvMap, normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Irradiance under a map, as exact as a picture needs: `EnvMap.probe` takes seconds for it."""
    border_sampled = env.registration == "border-sampled"
    return working_irradiance(env.radiance, normals, border_sampled=border_sampled)[0]


def viewpoint(rig: Rig) -> NDArray[np.float64]:
    """Direction from the probe to the eye: level with it, 60 degrees aside of the main light."""
    if not len(rig.lights):
        return np.array([0.0, 0.0, -1.0])
    ((u, _),) = sphere.direction_to_uv(rig.lights.direction[:1])
    ((x, y, z),) = sphere.uv_to_direction([[u + 1 / 6, 0.47]])
    return np.array([x, y, z])
