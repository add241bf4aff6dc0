"""Pictures: the map with its lights, and the probe under either."""

from __future__ import annotations

import io
import os
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from envlights import kernels
from envlights._native import EnvLightsError
from envlights._srgb import encode_srgb
from envlights.detected import DetectedLights
from envlights.envmap import EnvMap, as_envmap
from envlights.files import PICTURES, as_path, write_atomically
from envlights.rig import LUMINANCE, Rig, error_line

#: Pixels across the probe.
_PROBE_SIZE = 160


class Picture(Figure):
    """A figure that any notebook shows, whether or not it has set Matplotlib up."""

    def __init__(self, **options: Any) -> None:
        super().__init__(layout="constrained", **options)
        FigureCanvasAgg(self)

    def _repr_png_(self) -> bytes:
        return _drawn(self, "png")


def picture(env: EnvMap | ArrayLike, rig: Rig) -> Picture:
    """Draw the map with the lights on it, the probe under map and rig, and their difference.

    The probe is seen from beside the brightest light, so that its lit and its dark side show. Both
    probes have one exposure; the difference is that of luminance, in percent of the mean.

    Parameters
    ----------
    env : EnvMap or array_like, shape (height, 2 * height, 3)
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
    eye = _viewpoint(rig)
    normals, inside = _visible_normals(eye)
    under_map, under_rig = env.probe(normals), rig.probe(normals)
    white = max(float((under_map @ LUMINANCE).max()), np.finfo(float).tiny)
    for column, (title, seen) in enumerate(
        [("under the map", under_map), ("under the rig", under_rig)]
    ):
        axes = figure.add_subplot(grid[1, column])
        axes.imshow(_image(inside, encode_srgb(seen / white), background=1.0))
        axes.set_title(f"white probe {title}")
        axes.axis("off")
    _draw_difference(figure, figure.add_subplot(grid[1, 2]), inside, under_map, under_rig)
    ((u, v),) = kernels.direction_to_uv([eye])
    figure.suptitle(
        f"ambient + {rig.lights.in_short()}: {error_line(rig)}\n"
        f"probe seen from azimuth {360 * u:.0f}°, elevation {90 - 180 * v:.0f}°"
    )
    return figure


def detection_picture(env: EnvMap | ArrayLike, lights: DetectedLights) -> Picture:
    """Draw the map with the lights that were seen in it, as in Loghin (2021).

    Red: what each light is made of, the outline of its pixels or its samples with a line to each.
    Blue: the brightest place of each light. Cyan: its position, with its number.

    Parameters
    ----------
    env : EnvMap or array_like, shape (height, 2 * height, 3)
        The map.
    lights : DetectedLights
        What `detect` saw in it.

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


def save(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a picture as PNG, PDF or SVG, whole or not at all."""
    suffix = as_path(path).suffix.lower()
    if suffix not in PICTURES:
        raise EnvLightsError(f"cannot draw {path}; the suffix must be {', '.join(PICTURES)}")
    # Drawn in memory: on a full disk, matplotlib breaks while it closes a PDF.
    drawn = _drawn(figure, suffix[1:])
    write_atomically(path, lambda beside: beside.write_bytes(drawn))


def _drawn(figure: Figure, form: str) -> bytes:
    drawn = io.BytesIO()
    figure.savefig(drawn, format=form, dpi=100, bbox_inches="tight")
    return drawn.getvalue()


def _draw_members(axes: Axes, lights: DetectedLights) -> None:
    """Outlines of pixels, or samples and their links."""
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
    degrees: NDArray[np.float64] = kernels.direction_to_uv(directions) * (360, -180) + (0, 90)
    return degrees


def _draw_map(axes: Axes, env: EnvMap, rig: Rig) -> None:
    """The map, exposed for its middle, and a numbered ring at each light."""
    _draw_exposed(axes, env)
    for number, at in enumerate(_degrees(rig.lights.direction), start=1):
        # A ring, so that the lamp inside it shows; whole also on the seam.
        axes.plot(*at, "o", ms=22, mew=2, mec="crimson", mfc="none", clip_on=False)
        axes.annotate(
            str(number), at, (0, 12), textcoords="offset points", ha="center", color="crimson"
        )


def _draw_exposed(axes: Axes, env: EnvMap) -> None:
    radiance = env.radiance[:: max(env.height // 512, 1), :: max(env.width // 1024, 1)]
    luminance = radiance @ LUMINANCE
    lit = luminance[luminance > 0]
    exposure = 0.35 / np.median(lit) if lit.size else 1.0
    axes.imshow(encode_srgb(radiance * exposure), extent=(0, 360, -90, 90))
    axes.set(xlabel="azimuth (degrees)", ylabel="elevation (degrees)")
    axes.set(xticks=range(0, 361, 45), yticks=range(-90, 91, 45))


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


def _viewpoint(rig: Rig) -> NDArray[np.float64]:
    """Direction from the probe to the eye: level with it, 60 degrees aside of the main light."""
    if not len(rig.lights):
        return np.array([0.0, 0.0, -1.0])
    ((u, _),) = kernels.direction_to_uv(rig.lights.direction[:1])
    ((x, y, z),) = kernels.uv_to_direction([[u + 1 / 6, 0.47]])
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
