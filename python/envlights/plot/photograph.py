"""The lights of a photograph with their samples, and the steps that lead to them."""

from __future__ import annotations

from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from envlights._check import flag
from envlights._native import EnvLightsError
from envlights.detection.photograph import detect_photograph
from envlights.detection.photograph_lights import PhotographLights
from envlights.detection.photograph_pixels import AnyPhotograph
from envlights.plot.figure import Picture
from envlights.plot.markers import RIM, area, draw_discs, draw_legend, draw_numbers
from envlights.plot.steps import draw_bright, draw_links, draw_survivors

#: Width of the figure, and largest height of its picture, in inches.
_WIDTH, _HEIGHT = 12.0, 12.0
#: Room for title and legend in inches.
_MARGIN = 1.0
#: Points of an inch.
_POINTS = 72
#: Colour of maxima.
_MAXIMUM = "deepskyblue"
#: Letters in a line of a title.
_LETTERS = 110


def photograph(
    image: AnyPhotograph | PhotographLights, *, steps: bool = False, **options: Any
) -> Picture:
    """Draw a photograph with its detected lights, as in Loghin (2021).

    Discs mark the lights, in their colours, with areas for their shares. Dots are the samples, each
    with a link to the light that it was merged into; crosses are the maxima.

    Parameters
    ----------
    image : PhotographLights, path-like, bytes, file object or array_like
        The result of `detect_photograph`, or a photograph, in which lights are detected.
    steps : bool
        True: three more panels, one for each earlier step: samples near bright pixels and the
        brightest pixel in the window of each, and survivors with the samples that they suppress.
    **options
        Options of `detect_photograph` for a photograph.

    Returns
    -------
    matplotlib.figure.Figure

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
    figure = Picture(figsize=_size(lights))
    panels = figure.subplots(across, across, squeeze=False).ravel()
    for axes in panels:
        _draw_photograph(axes, lights)
    if steps:
        _draw_steps(panels, lights)
    _draw_lights(panels[-1], lights, _WIDTH / across)
    report = lights.report
    title = f"{lights.in_short()}; threshold {report.threshold:.3g} ({report.reason})"
    figure.suptitle(fill(title, _LETTERS))
    return figure


def _size(lights: PhotographLights) -> tuple[float, float]:
    """Width and height of the figure in inches."""
    height, width = lights.size
    return _WIDTH, min(_WIDTH * height / width, _HEIGHT) + _MARGIN


def _draw_photograph(axes: Axes, lights: PhotographLights) -> None:
    """Draw the photograph in its own pixels, with row 0 at the top."""
    height, width = lights.size
    axes.imshow(lights.picture, extent=(0, width, height, 0), interpolation="antialiased")
    axes.set(xlim=(0, width), ylim=(height, 0), xlabel="x (pixels)", ylabel="y (pixels)")


def _draw_steps(panels: NDArray[Any], lights: PhotographLights) -> None:
    """Draw the panels before the last."""
    samples = lights.samples
    height, width = lights.report.working_size
    panels[0].set_title(f"1. the photograph, searched in {width}x{height} pixels")
    at, first = _places(samples.pixel, lights), _places(samples.first, lights)
    draw_bright(panels[1], first, _places(samples.maximum, lights))
    draw_survivors(panels[2], at, first, samples.survivor)
    for axes in panels:
        axes.set(xlabel="", ylabel="")
    panels[3].set_title(f"4. lights: {len(lights)}, merged along bright lines")


def _draw_lights(axes: Axes, lights: PhotographLights, inches: float) -> None:
    """Draw samples, links, maxima and discs; the picture is `inches` wide."""
    height, width = lights.size
    samples, at = lights.samples, lights.position
    first = _places(samples.first, lights)
    maxima = _places(samples.pixel[np.unique(samples.survivor)], lights)
    draw_links(axes, first, at[samples.light], RIM)
    axes.plot(*first.T, ".", ms=2, color=RIM)
    areas = area(lights.share) / 2
    draw_discs(axes, at, areas, lights.pixel_flux)
    axes.plot(*maxima.T, "+", ms=5, mew=1, color=_MAXIMUM, zorder=5)
    draw_numbers(axes, at, areas, _POINTS * inches / max(width, height), (0, width, 0, height))
    draw_legend(axes, _legend())


def _places(pixel: NDArray[np.int64], lights: PhotographLights) -> NDArray[np.float64]:
    """Places (x, y) in the photograph of pixels of its working image."""
    scale = np.array(lights.size) / lights.report.working_size
    places: NDArray[np.float64] = ((pixel + 0.5) * scale)[:, ::-1]
    return places


def _legend() -> list[Line2D]:
    sample = Line2D([], [], color=RIM, lw=0.7, marker=".", label="samples, linked to their light")
    maximum = Line2D([], [], ls="", marker="+", color=_MAXIMUM, label="maxima")
    return [sample, maximum]
