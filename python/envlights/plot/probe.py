"""The white probe under a map and under a rig, and their difference."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from envlights._srgb import encode_srgb
from envlights._unseen import ENOUGH_SEEN
from envlights.envmap import EnvMap
from envlights.fitting.unseen_part import above_horizon
from envlights.kernels import sphere
from envlights.kernels.image import LUMINANCE
from envlights.kernels.probe import working_irradiance
from envlights.plot.ball import Ball, ball
from envlights.plot.figure import hide_frame
from envlights.rig import Rig


class ShadedBall(NamedTuple):
    """Pixels of a ball, and its irradiance under a map."""

    ball: Ball
    irradiance: NDArray[np.float64]
    """Irradiance at each pixel of the probe, (n, 3)."""


def shaded_ball(env: EnvMap, eye: NDArray[np.float64], floor: bool) -> ShadedBall:
    """Probe under a map, seen from the direction `eye`; over a floor if the rigs are."""
    seen = ball(eye)
    # A picture needs no choice; a map that was filled before is drawn with its fill.
    env = env.filled(None if env.seen_share >= ENOUGH_SEEN else "black")
    return ShadedBall(seen, under(above_horizon(env) if floor else env, seen.normals))


def draw_probes(figure: Figure, axes: Sequence[Axes], shaded: ShadedBall, rig: Rig) -> None:
    """Draw the probe under the map, under the rig, and the difference, each on its axes."""
    under_rig = rig.probe(shaded.ball.normals)
    white = max(float((shaded.irradiance @ LUMINANCE).max()), np.finfo(float).tiny)
    for axis, name, light in zip(
        axes, ("map", "rig"), (shaded.irradiance, under_rig), strict=False
    ):
        axis.imshow(shaded.ball.image(encode_srgb(light / white)), interpolation="antialiased")
        axis.set_title(f"probe under the {name}")
        hide_frame(axis)
    _draw_difference(figure, axes[2], shaded, under_rig)


def _draw_difference(
    figure: Figure, axes: Axes, shaded: ShadedBall, under_rig: NDArray[np.float64]
) -> None:
    wanted = shaded.irradiance @ LUMINANCE
    percent = 100 * (under_rig @ LUMINANCE - wanted) / max(wanted.mean(), np.finfo(float).tiny)
    limit = max(float(np.abs(percent).max()), 0.1)
    values, cover = shaded.ball.values(percent), shaded.ball.values(shaded.ball.cover)
    image = axes.imshow(values, cmap="RdBu_r", vmin=-limit, vmax=limit, alpha=np.nan_to_num(cover))
    axes.set_title("rig minus map")
    hide_frame(axes)
    figure.colorbar(image, ax=axes, label="% of the mean", shrink=0.85)


def under(env: EnvMap, normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Irradiance under a map, accurate enough for a picture; `EnvMap.probe` would take seconds."""
    border_sampled = env.registration == "border-sampled"
    return working_irradiance(env.radiance, normals, border_sampled=border_sampled)[0]


def viewpoint(rig: Rig) -> NDArray[np.float64]:
    """Direction from the probe to the viewer: horizontal, 60 degrees beside the main light."""
    if not len(rig.lights):
        return np.array([0.0, 0.0, -1.0])
    ((u, _),) = sphere.direction_to_uv(rig.lights.direction[:1])
    ((x, y, z),) = sphere.uv_to_direction([[u + 1 / 6, 0.47]])
    return np.array([x, y, z])
