"""Picture of a white probe under a map and under a rig, and of their difference."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import AsinhNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.ticker import StrMethodFormatter
from numpy.typing import NDArray

from envlights._common.srgb import encode_srgb
from envlights.environment.envmap import EnvMap
from envlights.environment.fill import ENOUGH_SEEN
from envlights.fitting.reduction import above_horizon
from envlights.kernels import sphere
from envlights.kernels.image import LUMINANCE
from envlights.kernels.probe import working_irradiance
from envlights.plot.ball import Ball, ball, draw_ball, draw_rim
from envlights.plot.figure import hide_frame
from envlights.plot.wording import entitle, fits_upright
from envlights.rigs.rig import Rig

#: Ratio of largest differences above which a common linear scale would hide the smaller one.
_APART = 5.0
#: Unit of differences; a short bar has only its first letter.
_LABEL = "% of the mean"


class ShadedBall(NamedTuple):
    """Pixels of a ball with their irradiance under a map."""

    ball: Ball
    irradiance: NDArray[np.float64]
    """Irradiance at each pixel of the probe, (n, 3)."""


def shaded_ball(env: EnvMap, eye: NDArray[np.float64], floor: bool) -> ShadedBall:
    """Probe under a map, seen from the direction `eye`; `floor` hides light from below."""
    seen = ball(eye)
    # Fill automatically; a map that was filled by the caller is not changed.
    env = env.filled(None if env.coverage_fraction >= ENOUGH_SEEN else "black")
    return ShadedBall(seen, under(above_horizon(env) if floor else env, seen.normals))


def white_for(irradiance: NDArray[np.float64]) -> float:
    """Luminance of a probe that is displayed as white."""
    return max(float((irradiance @ LUMINANCE).max()), np.finfo(float).tiny)


def draw_probe(axes: Axes, seen: Ball, irradiance: NDArray[np.float64], white: float) -> None:
    """Draw a probe as sRGB codes, with the irradiance `white` displayed as white."""
    draw_ball(axes, seen.image(encode_srgb(irradiance / white)))


def draw_probes(axes: Sequence[Axes], shaded: ShadedBall, rig: Rig, scale: Normalize) -> AxesImage:
    """Draw the probe under the map, under the rig, and the difference; return the last image."""
    under_rig = rig.probe(shaded.ball.normals)
    white = white_for(shaded.irradiance)
    for axis, name, light in zip(
        axes, ("map", "rig"), (shaded.irradiance, under_rig), strict=False
    ):
        draw_probe(axis, shaded.ball, light, white)
        entitle(axis, f"under the {name}", "small")
    entitle(axes[2], "rig minus map", "small")
    return draw_difference(axes[2], shaded, rig, scale)


def percent_of_mean(shaded: ShadedBall, rig: Rig) -> NDArray[np.float64]:
    """Difference of the luminance of a probe under a rig and under the map, in % of the mean."""
    wanted = shaded.irradiance @ LUMINANCE
    difference = rig.probe(shaded.ball.normals) @ LUMINANCE - wanted
    percent: NDArray[np.float64] = 100 * difference / max(wanted.mean(), np.finfo(float).tiny)
    return percent


def error_limit(shaded: ShadedBall, rig: Rig) -> float:
    """Largest luminance difference of a probe in percent, for the colour scale."""
    return max(float(np.abs(percent_of_mean(shaded, rig)).max()), 0.1)


def scale_for(limits: Sequence[float]) -> Normalize:
    """Common colour scale of differences for several probes, in which the smallest are visible."""
    largest, least = max(limits), min(limits)
    if largest < _APART * least:
        return Normalize(-largest, largest)
    return AsinhNorm(max(least / 2, largest / 1e3), -largest, largest)


def draw_difference(axes: Axes, shaded: ShadedBall, rig: Rig, scale: Normalize) -> AxesImage:
    """Draw the difference of a probe in colours of `scale`."""
    percent = percent_of_mean(shaded, rig)
    values, cover = shaded.ball.values(percent), shaded.ball.values(shaded.ball.cover)
    image = axes.imshow(values, cmap="RdBu_r", norm=scale, alpha=np.nan_to_num(cover))
    draw_rim(axes, ((len(values) - 1) / 2,) * 2, len(values) / 2)
    hide_frame(axes)
    return image


def draw_difference_bar(figure: Figure, axes: Sequence[Axes], drawn: AxesImage) -> None:
    """Add a colour bar for the differences in these axes."""
    label = _LABEL if fits_upright(axes[0], _LABEL) else _LABEL[0]
    bar = figure.colorbar(drawn, ax=list(axes), label=label, shrink=0.85)
    if isinstance(drawn.norm, AsinhNorm):
        largest = float(drawn.norm.vmax or 1.0)
        low = np.ceil(np.log10(2 * drawn.norm.linear_width))
        powers = 10.0 ** np.arange(low, np.log10(largest))
        bar.set_ticks([*-powers[::-1], 0.0, *powers], minor=False)
        bar.formatter = StrMethodFormatter("{x:g}")
        bar.minorticks_off()


def under(env: EnvMap, normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Irradiance under a map, accurate enough for a picture, and faster than `EnvMap.probe`."""
    return working_irradiance(env.radiance, normals, border_sampled=env.is_border_sampled)[0]


def viewpoint(rig: Rig) -> NDArray[np.float64]:
    """Horizontal direction from the probe to the viewer, 60 degrees beside the main light."""
    if not len(rig.lights):
        return np.array([0.0, 0.0, -1.0])
    ((u, _),) = sphere.direction_to_uv(rig.lights.direction[:1])
    ((x, y, z),) = sphere.uv_to_direction([[u + 1 / 6, 0.47]])
    return np.array([x, y, z])
