"""Pictures of the lights of a photograph with samples, and of the detection steps."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from envlights._common.check import flag
from envlights._native import EnvLightsError
from envlights.papers.photograph import detect_photograph
from envlights.papers.photograph_lights import PhotographLights
from envlights.papers.photograph_pixels import AnyPhotograph
from envlights.plot.markers import RIM, draw_discs, draw_legend, draw_numbers, sizes_for
from envlights.plot.page import AnyAxes, Size, grid, open_page
from envlights.plot.steps import draw_bright, draw_links, draw_survivors
from envlights.plot.wording import entitle

#: Width of the figure, and largest height of the picture, in inches.
_WIDTH, _HEIGHT = 12.0, 12.0
#: Room for title and legend in inches.
_MARGIN = 1.0
#: Colour of maxima.
_MAXIMUM = "deepskyblue"


def photograph(
    image: AnyPhotograph | PhotographLights,
    *,
    steps: bool = False,
    ax: AnyAxes | None = None,
    figsize: Size | None = None,
    dpi: float | None = None,
    transparent: bool | None = None,
    **options: Any,
) -> Figure:
    """Draw a photograph with its detected lights, as in Loghin (2021).

    Discs mark the lights, in their colours, with areas in proportion to their flux. Dots are the
    samples, each with a link to the light that it was merged into; crosses are the maxima.

    Parameters
    ----------
    image : PhotographLights, path-like, bytes, file object or array_like
        The result of `detect_photograph`, or a photograph, in which lights are detected.
    steps : bool
        True: three more panels, one for each earlier step: samples near bright pixels and the
        brightest pixel in the window of each, and survivors with the samples that they suppress.
    ax, figsize, dpi, transparent
        `ax`: one, or four with `steps`; the others: see `envlights.plot`.
    **options
        Options of `detect_photograph` for a photograph.

    Examples
    --------
    >>> night = np.full((60, 80, 3), 0.01)
    >>> night[20:24, 30:50] = 1.0
    >>> figure = photograph(night, fov=60)
    >>> len(figure.axes)
    1
    """
    lights = image
    if not isinstance(lights, PhotographLights):
        lights = detect_photograph(lights, **options)
    elif options:
        raise EnvLightsError(
            "a result of `detect_photograph` takes no options; give the photograph itself"
        )
    across = 2 if flag("steps", steps) else 1
    page = open_page(
        {"ax": ax, "figsize": figsize, "dpi": dpi, "transparent": transparent},
        grid(across, across),
        _size(lights),
    )
    panels = page.panels
    for axes in panels:
        _draw_photograph(axes, lights)
    if steps:
        _draw_steps(panels, lights)
    _draw_lights(panels[-1], lights)
    report = lights.report
    title = f"{lights.in_short()}; threshold {report.threshold:.3g} ({report.reason})"
    page.entitle(title)
    return page.figure


def _size(lights: PhotographLights) -> tuple[float, float]:
    """Width and height of the figure in inches."""
    height, width = lights.size
    return _WIDTH, min(_WIDTH * height / width, _HEIGHT) + _MARGIN


def _draw_photograph(axes: Axes, lights: PhotographLights) -> None:
    """Draw the photograph with axes in its pixels, and row 0 at the top."""
    height, width = lights.size
    axes.imshow(lights.picture, extent=(0, width, height, 0), interpolation="antialiased")
    axes.set(xlim=(0, width), ylim=(height, 0), xlabel="x (pixels)", ylabel="y (pixels)")


def _draw_steps(panels: list[Axes], lights: PhotographLights) -> None:
    """Draw all panels except the last."""
    samples = lights.samples
    height, width = lights.report.working_size
    entitle(panels[0], f"1. the photograph, searched in {width}x{height} pixels")
    at, first = _places(samples.pixel, lights), _places(samples.first, lights)
    draw_bright(panels[1], first, _places(samples.maximum, lights))
    draw_survivors(panels[2], at, first, samples.survivor)
    for axes in panels:
        axes.set(xlabel="", ylabel="")
    entitle(panels[3], f"4. lights: {len(lights)}")


def _draw_lights(axes: Axes, lights: PhotographLights) -> None:
    """Draw samples, links, maxima and discs."""
    height, width = lights.size
    samples, at = lights.samples, lights.position
    first = _places(samples.first, lights)
    maxima = _places(samples.pixel[np.unique(samples.survivor)], lights)
    draw_links(axes, first, at[samples.light], RIM)
    axes.plot(*first.T, ".", ms=2, color=RIM)
    as_map = 0.0, 360.0, 0.0, 360.0 * height / width
    areas = sizes_for(axes, lights.fraction, 0.5, as_map).area(lights.fraction)
    draw_discs(axes, at, areas, lights.pixel_flux)
    axes.plot(*maxima.T, "+", ms=5, mew=1, color=_MAXIMUM, zorder=5)
    draw_numbers(axes, at, areas, (0, width, 0, height))
    draw_legend(axes, _legend())


def _places(pixel: NDArray[np.int64], lights: PhotographLights) -> NDArray[np.float64]:
    """Positions (x, y) in the photograph for pixels of the working image."""
    scale = np.array(lights.size) / lights.report.working_size
    places: NDArray[np.float64] = ((pixel + 0.5) * scale)[:, ::-1]
    return places


def _legend() -> list[Line2D]:
    sample = Line2D([], [], color=RIM, lw=0.7, marker=".", label="samples, linked to their light")
    maximum = Line2D([], [], ls="", marker="+", color=_MAXIMUM, label="maxima")
    return [sample, maximum]
