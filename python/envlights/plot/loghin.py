"""Picture of the steps of Loghin (2021), with an image per step."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from envlights.environment.envmap import EnvMap
from envlights.environment.reading import AnyMap, as_envmap
from envlights.kernels import sphere
from envlights.papers.loghin import Detection, detect_with_steps
from envlights.papers.loghin_steps import Steps
from envlights.plot.globe import draw_globe, on_page
from envlights.plot.ground import degrees, draw_ground, expose, working
from envlights.plot.markers import RIM, draw_discs, draw_numbers, sizes_for
from envlights.plot.page import AnyAxes, Size, grid, open_page
from envlights.plot.steps import LEFT, draw_bright, draw_links, draw_survivors
from envlights.plot.wording import entitle

#: Width in degrees above which links cross the seam.
_SEAM = 180.0
#: View direction of the sphere.
_EYE = np.array([0.48, 0.36, 0.8])


def loghin_picture(
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

    Returns
    -------
    matplotlib.figure.Figure

    Examples
    --------
    >>> import envlights as el
    >>> figure = loghin_picture(el.synthetic.hall(128).radiance)
    >>> [axes.get_title().split(":")[0] for axes in figure.axes]
    ['1. samples', '2. bright samples', '3. survivors', '4. lights']
    """
    env = as_envmap(env)
    page = open_page(
        {"ax": ax, "figsize": figsize, "dpi": dpi, "transparent": transparent}, grid(2, 2), (13, 8)
    )
    found = detect_with_steps(env, **options)
    steps, samples = found.steps, found.steps.samples
    globe, bright, survivors, merged = page.panels
    _draw_samples(globe, env, steps)
    ground = expose(working(env))
    for axes in (bright, survivors, merged):
        draw_ground(axes, ground.codes)
        axes.set(xlabel="", ylabel="")
    at, maxima = (_degrees(steps.uv(pixel)) for pixel in (samples.pixel, samples.maximum))
    draw_bright(bright, at, maxima, _SEAM)
    draw_survivors(survivors, at, at, steps.merged.survivor, _SEAM)
    _draw_lights(merged, found, at)
    page.entitle(f"the steps of Loghin (2021): threshold {found.lights.report.threshold:.3g}")
    return page.figure


def _degrees(uv: NDArray[np.float64]) -> NDArray[np.float64]:
    """Azimuth and elevation of points of the unit square, (n, 2)."""
    return degrees(sphere.uv_to_direction(uv))


def _draw_samples(axes: Axes, env: EnvMap, steps: Steps) -> None:
    eye = _EYE / np.linalg.norm(_EYE)
    draw_globe(axes, env, eye)
    at, is_near = on_page(sphere.uv_to_direction(steps.points), eye)
    axes.plot(*at[is_near].T, ".", ms=2, color=LEFT)
    entitle(axes, f"1. samples: {len(steps.points)}")


def _draw_lights(axes: Axes, found: Detection, samples: NDArray[np.float64]) -> None:
    lights = found.lights
    at = degrees(lights.direction)
    areas = sizes_for(axes, lights.fraction, 0.5).area(lights.fraction)
    kept = np.unique(found.steps.merged.survivor)
    kept = kept[found.light[kept] < len(lights)]
    draw_links(axes, samples[kept], at[found.light[kept]], RIM, _SEAM)
    draw_discs(axes, at, areas, lights.irradiance)
    draw_numbers(axes, at, areas)
    entitle(axes, f"4. lights: {len(lights)}")
