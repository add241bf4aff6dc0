"""A map with its lights: those of a rig, with the probe, or those that were detected."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from numpy.typing import NDArray

from envlights._srgb import encode_srgb
from envlights.detection.lights import DetectedLights
from envlights.envmap import AnyMap, EnvMap, as_envmap
from envlights.kernels import sphere
from envlights.kernels.image import LUMINANCE
from envlights.plot.figure import Picture
from envlights.plot.probe import draw_probes
from envlights.rig import Rig, error_line
from envlights.scene.surface import tangent_frames


def picture(env: AnyMap, rig: Rig) -> Picture:
    """Draw the map with the lights on it, the probe under map and rig, and their difference.

    The probe is viewed from beside the brightest light, so that its lit and its dark side show.
    Both probes have the same exposure; the difference is of luminance, in percent of the mean.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map.
    rig : Rig
        Its lights.

    Returns
    -------
    matplotlib.figure.Figure
        Shown by Jupyter as it is; `save` and `savefig` write it.

    Examples
    --------
    >>> import envlights as el
    >>> env = el.EnvMap(el.synthetic.hall(32).radiance)
    >>> figure = picture(env, el.fit(env, lights=1))
    >>> len(figure.axes)
    5
    """
    env = as_envmap(env)
    figure = Picture(figsize=(10, 8.2))
    grid = figure.add_gridspec(2, 3, height_ratios=(1.55, 1))
    _draw_map(figure.add_subplot(grid[0, :]), env, rig)
    axes = [figure.add_subplot(grid[1, column]) for column in range(3)]
    azimuth, elevation = draw_probes(figure, axes, env, rig)
    figure.suptitle(
        f"ambient + {rig.lights.in_short()}: {error_line(rig)}\n"
        f"probe seen from azimuth {azimuth:.0f}°, elevation {elevation:.0f}°"
    )
    return figure


def detection_picture(env: AnyMap, lights: DetectedLights) -> Picture:
    """Draw the map with the lights that were detected in it, as in Loghin (2021).

    Red: the outline of the pixels of each light, or its samples with a line to each. Blue: the peak
    of each light. Cyan: its direction, with its number.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map.
    lights : DetectedLights
        The result of `detect` on it.

    Returns
    -------
    matplotlib.figure.Figure

    Examples
    --------
    >>> import envlights as el
    >>> env = el.EnvMap(el.synthetic.hall(128).radiance)
    >>> figure = detection_picture(env, el.detect(env))
    >>> len(figure.axes)
    1
    """
    env = as_envmap(env)
    figure = Picture(figsize=(12, 6.6))
    axes = figure.add_subplot()
    _draw_exposed(axes, env)
    _draw_members(axes, lights)
    peaks = _degrees(lights.peak_direction)
    axes.plot(*peaks.T, "o", ms=5, mec="white", mew=0.5, mfc="blue", clip_on=False)
    for number, at in enumerate(_degrees(lights.direction), start=1):
        axes.plot(*at, "o", ms=9, mew=1.5, mec="cyan", mfc="none", clip_on=False)
        axes.annotate(
            str(number), at, (7, 4), textcoords="offset points", color="cyan", annotation_clip=False
        )
    report = lights.report
    figure.suptitle(
        f"{lights.in_short()}: brighter than {report.threshold:.3g}, {report.reason}", wrap=True
    )
    return figure


def _draw_map(axes: Axes, env: EnvMap, rig: Rig) -> None:
    """Draw the map, exposed for its median, and each light with its number: its rim, or a ring."""
    _draw_exposed(axes, env)
    lights = rig.lights
    for number, at in enumerate(_degrees(lights.direction), start=1):
        direction, radius = lights.direction[number - 1], lights.angular_radius[number - 1]
        if radius:
            axes.plot(*_rim(direction, radius).T, color="crimson", lw=2)
        else:
            # A ring, so that the lamp inside it shows; whole also on the seam.
            axes.plot(*at, "o", ms=22, mew=2, mec="crimson", mfc="none", clip_on=False)
        axes.annotate(
            str(number), at, (0, 12), textcoords="offset points", ha="center", color="crimson"
        )


def _rim(direction: NDArray[np.float64], radius: float) -> NDArray[np.float64]:
    """Azimuth and elevation along the rim of a disc, with gaps where it crosses the seam."""
    angle = np.linspace(0, 2 * np.pi, 361)
    circle = np.sin(radius) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    (frame,) = tangent_frames(direction[None])
    rim = _degrees(circle @ frame[:2] + np.cos(radius) * direction)
    rim[1:][np.abs(np.diff(rim[:, 0])) > 180] = np.nan
    return rim


def _draw_exposed(axes: Axes, env: EnvMap) -> None:
    radiance = env.radiance[:: max(env.height // 512, 1), :: max(env.width // 1024, 1)]
    luminance = radiance @ LUMINANCE
    shining = luminance[luminance > 0]
    exposure = 0.35 / np.median(shining) if shining.size else 1.0
    axes.imshow(encode_srgb(radiance * exposure), extent=(0, 360, -90, 90))
    axes.set(xlabel="azimuth (degrees)", ylabel="elevation (degrees)")
    axes.set(xticks=range(0, 361, 45), yticks=range(-90, 91, 45))


def _draw_members(axes: Axes, lights: DetectedLights) -> None:
    """Draw outlines of pixels, or samples and their links."""
    height, width = lights.report.working_size
    rows, columns = lights.members.pixel.T
    if lights.report.method == "article":
        at = np.stack([360 * (columns + 0.5) / width, 90 - 180 * (rows + 0.5) / height], axis=1)
        homes = _degrees(lights.direction)[lights.members.light]
        is_near = np.abs(homes[:, 0] - at[:, 0]) < 180  # no line right across the seam
        links = LineCollection(np.stack([at, homes], axis=1)[is_near], colors="red", lw=0.4)
        axes.add_collection(links)
        axes.plot(*at.T, ".", ms=3, color="red")
        return
    number = np.zeros((height, width))
    number[rows, columns] = 1 + lights.members.light
    for light in range(1, len(lights) + 1):
        axes.contour(
            number == light,
            levels=[0.5],
            colors="red",
            linewidths=0.8,
            origin="upper",
            extent=(0, 360, -90, 90),
        )


def _degrees(directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Azimuth and elevation of `directions`, shape (n, 2)."""
    degrees: NDArray[np.float64] = sphere.direction_to_uv(directions) * (360, -180) + (0, 90)
    return degrees
