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
from envlights.rig import Rig

#: Pixels across the probe.
_PROBE_SIZE = 160


def draw_probes(figure: Figure, axes: Sequence[Axes], env: EnvMap, rig: Rig) -> tuple[float, float]:
    """Draw the probe under the map, under the rig, and the difference, each on its axes.

    Returns
    -------
    azimuth, elevation : float
        Where the probe is looked at from, in degrees.
    """
    eye = viewpoint(rig)
    normals, inside = _visible_normals(eye)
    # A floor hides the same from both.
    world = above_horizon(env) if rig.floor else env
    under_map, under_rig = world.probe(normals), rig.probe(normals)
    white = max(float((under_map @ LUMINANCE).max()), np.finfo(float).tiny)
    for axis, name, irradiance in zip(axes, ("map", "rig"), (under_map, under_rig), strict=False):
        axis.imshow(_image(inside, encode_srgb(irradiance / white), background=1.0))
        axis.set_title(f"white probe under the {name}")
        axis.axis("off")
    _draw_difference(figure, axes[2], inside, under_map, under_rig)
    ((u, v),) = sphere.direction_to_uv([eye])
    return 360 * u, 90 - 180 * v


def _draw_difference(
    figure: Figure,
    axes: Axes,
    inside: NDArray[np.bool_],
    under_map: NDArray[np.float64],
    under_rig: NDArray[np.float64],
) -> None:
    wanted = under_map @ LUMINANCE
    percent = 100 * (under_rig @ LUMINANCE - wanted) / max(wanted.mean(), np.finfo(float).tiny)
    limit = max(float(np.abs(percent).max()), 0.1)
    drawn = np.full(inside.shape, np.nan)
    drawn[inside] = percent
    image = axes.imshow(drawn, cmap="RdBu_r", vmin=-limit, vmax=limit)
    axes.set_title("rig minus map")
    axes.axis("off")
    figure.colorbar(image, ax=axes, label="% of the mean", shrink=0.85)


def viewpoint(rig: Rig) -> NDArray[np.float64]:
    """Direction from the probe to the eye: level with it, 60 degrees aside of the main light."""
    if not len(rig.lights):
        return np.array([0.0, 0.0, -1.0])
    ((u, _),) = sphere.direction_to_uv(rig.lights.direction[:1])
    ((x, y, z),) = sphere.uv_to_direction([[u + 1 / 6, 0.47]])
    return np.array([x, y, z])


def _visible_normals(eye: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Normals of a sphere as seen from `eye`, one for each pixel inside its outline."""
    right = np.cross([0.0, 1.0, 0.0], eye)
    right /= np.linalg.norm(right)
    up = np.cross(eye, right)
    at = (2 * np.arange(_PROBE_SIZE) + 1) / _PROBE_SIZE - 1
    across, down = np.meshgrid(at, at)
    inside = across**2 + down**2 < 1
    across, down = across[inside], down[inside]
    towards = np.sqrt(1 - across**2 - down**2)
    normals = across[:, None] * right - down[:, None] * up + towards[:, None] * eye
    return normals, inside


def _image(
    inside: NDArray[np.bool_], colours: NDArray[np.floating], background: float
) -> NDArray[np.float64]:
    image = np.full((*inside.shape, 3), background)
    image[inside] = colours
    return image
