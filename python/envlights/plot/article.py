"""The steps of Loghin (2021), one image for each."""

from __future__ import annotations

import inspect
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from envlights.detection.lights import DetectedLights
from envlights.environment.envmap import AnyMap, EnvMap, as_envmap
from envlights.kernels import image as images
from envlights.kernels import loghin, sampling, sphere
from envlights.papers.loghin import detect
from envlights.papers.loghin_steps import square_points
from envlights.plot.globe import draw_globe, on_page
from envlights.plot.ground import degrees, draw_ground, expose, working
from envlights.plot.markers import RIM, draw_discs, draw_numbers, sizes_for
from envlights.plot.page import AnyAxes, Size, grid, open_page
from envlights.plot.steps import LEFT, draw_bright, draw_links, draw_survivors
from envlights.plot.wording import entitle

#: Width in degrees of links that cross the seam.
_SEAM = 180.0
#: View direction of the sphere.
_EYE = np.array([0.48, 0.36, 0.8])


class _Steps(NamedTuple):
    """Directions at each step; a map's working image is that of the lights."""

    samples: NDArray[np.float64]
    """All samples, (n, 3)."""

    bright: NDArray[np.float64]
    """Samples near a bright pixel, brightest first, (k, 3)."""

    maxima: NDArray[np.float64]
    """Brightest pixel in the window of each bright sample, (k, 3)."""

    survivor: NDArray[np.int64]
    """Index of the sample that suppresses each, or its own, (k,)."""

    light: NDArray[np.int64]
    """Light of each bright sample, (k,)."""


def article_picture(
    env: AnyMap,
    *,
    ax: AnyAxes | None = None,
    figsize: Size | None = None,
    dpi: float | None = None,
    transparent: bool | None = None,
    **options: Any,
) -> Figure:
    """Draw the steps of Loghin (2021) on a map.

    First the samples on the sphere; then those near a bright pixel, with the brightest pixel in the
    window of each; the samples that survive beside brighter ones; and the lights, each with links
    to the survivors that were merged into it.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map.
    ax : Axes or sequence of Axes, optional
        Axes to draw in, one for each panel; see `envlights.plot`.
    figsize, dpi, transparent
        Size, resolution and ground of a new figure; see `envlights.plot`.
    **options
        Options of `papers.loghin.detect`.

    Examples
    --------
    >>> import envlights as el
    >>> figure = article_picture(el.synthetic.hall(128).radiance)
    >>> [axes.get_title().split(":")[0] for axes in figure.axes]
    ['1. samples', '2. bright samples', '3. survivors', '4. lights']
    """
    env = as_envmap(env)
    page = open_page(
        {"ax": ax, "figsize": figsize, "dpi": dpi, "transparent": transparent}, grid(2, 2), (13, 8)
    )
    lights = detect(env, **options)
    defaults = {name: each.default for name, each in _parameters().items()}
    steps = _steps(env, lights, {**defaults, **options})
    globe, bright, survivors, merged = page.panels
    _draw_samples(globe, env, steps)
    ground = expose(working(env))
    for axes in (bright, survivors, merged):
        draw_ground(axes, ground.codes)
        axes.set(xlabel="", ylabel="")
    at = degrees(steps.bright)
    draw_bright(bright, at, degrees(steps.maxima), _SEAM)
    draw_survivors(survivors, at, at, steps.survivor, _SEAM)
    _draw_lights(merged, lights, steps)
    page.entitle(f"the steps of Loghin (2021): threshold {lights.report.threshold:.3g}")
    return page.figure


def _parameters() -> dict[str, inspect.Parameter]:
    _, *options = inspect.signature(detect).parameters.values()
    return {option.name: option for option in options}


def _steps(env: EnvMap, lights: DetectedLights, options: dict[str, Any]) -> _Steps:
    """Recompute the intermediate directions of `papers.loghin.detect`."""
    height, width = lights.report.working_size
    luminance = images.resize_bilinear(images.luminance(env.radiance), height, width, wrap=True)
    points = square_points(options["sampling"], luminance, options["samples_per_pixel"])
    # The members are the bright samples; find the brightest pixel around each.
    pixel = lights.members.pixel
    reach = int(options["window_px"] * width / 1024) // 2
    _, maxima = loghin.neighbour_maximum(luminance, pixel, reach, sphere=options["sphere"])
    order = np.argsort(-luminance[pixel[:, 0], pixel[:, 1]], kind="stable")
    bright = _directions(pixel[order], height, width)
    apart = 2 * np.sin(np.deg2rad(options["suppression_deg"]) / 2)
    return _Steps(
        sampling.uniform_sphere(points),
        bright,
        _directions(maxima[order], height, width),
        loghin.suppress(bright, apart),
        lights.members.light[order],
    )


def _directions(pixel: NDArray[np.int64], height: int, width: int) -> NDArray[np.float64]:
    return sphere.uv_to_direction((pixel[:, ::-1] + 0.5) / (width, height))


def _draw_samples(axes: Axes, env: EnvMap, steps: _Steps) -> None:
    eye = _EYE / np.linalg.norm(_EYE)
    draw_globe(axes, env, eye)
    at, is_near = on_page(steps.samples, eye)
    axes.plot(*at[is_near].T, ".", ms=2, color=LEFT)
    entitle(axes, f"1. samples: {len(steps.samples)}")


def _draw_lights(axes: Axes, lights: DetectedLights, steps: _Steps) -> None:
    at = degrees(lights.direction)
    areas = sizes_for(axes, lights.fraction, 0.5).area(lights.fraction)
    kept = np.unique(steps.survivor)
    draw_links(axes, degrees(steps.bright[kept]), at[steps.light[kept]], RIM, _SEAM)
    draw_discs(axes, at, areas, lights.irradiance)
    draw_numbers(axes, at, areas)
    entitle(axes, f"4. lights: {len(lights)}")
