"""Picture of a scene under a map and under rigs, by Mitsuba, or under rigs in closed form."""

from __future__ import annotations

import importlib.util

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from envlights._common.check import check_choice, count
from envlights._common.srgb import encode_srgb
from envlights._common.words import percent
from envlights.environment.reading import AnyMap, as_envmap
from envlights.kernels import sphere
from envlights.kernels.image import LUMINANCE
from envlights.plot.figure import check_are_rigs, hide_frame
from envlights.plot.ground import WHITE, white_of
from envlights.plot.page import Page, Placement, Unpack, grid, open_page, placed_picture
from envlights.plot.probe import viewpoint
from envlights.plot.wording import entitle
from envlights.rigs.rig import Rig, parts_line
from envlights.scene.mitsuba.path_traced import Still
from envlights.scene.still_life import closed_still, still_life

#: Values of `renderer`.
RENDERERS = ("any", "mitsuba", "closed form")
#: Smallest and largest number of columns of an image.
_COLUMNS = 24, 1920


@placed_picture
def scene(
    env: AnyMap,
    *rigs: Rig,
    samples: int = 64,
    seed: int = 0,
    renderer: str = "any",
    width: int = 320,
    **where: Unpack[Placement],
) -> Figure:
    """Draw a ball and a box on a floor under the map and under rigs, and the differences.

    All images have the same exposure; a difference is of luminance, in percent of the mean. The
    titles hold relative RMS differences of the images, corrected for noise, and the noise of the
    images. Unlike the error of a probe they include shadows and light between surfaces. The view
    is from beside the brightest light of the first rig.

    Without Mitsuba, the images of the rigs alone are drawn in closed form: shadows are exact, and
    light between surfaces is a model, which differs from a path tracer by 1 to 3 %.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map.
    *rigs : Rig
        One or more, such as a fit without sizes and one with them. The floor hides what is below
        the horizon: ``el.fit(..., floor=True)`` is made for such a scene.
    samples : int
        Paths through each pixel for each light, rounded up; the map gets four times as many.
    seed : int
        Seed of the paths.
    renderer : {"any", "mitsuba", "closed form"}
        By default Mitsuba, or the closed form if it is not installed.
    width : int
        Columns of each image, 24 to 1920; there are two thirds as many rows.
    **where
        `ax`: of the images, then of the differences; `figsize`, `dpi`, `transparent`: see
        `envlights.plot`.

    Raises
    ------
    EnvLightsError
        If there is no rig. With Mitsuba: if it is requested and not installed, or the map is not
        cell-centred. In closed form: if the ambient term of a rig is harmonics.

    Examples
    --------
    >>> import envlights as el
    >>> env = el.EnvMap(el.synthetic.hall(32).radiance)
    >>> figure = scene(env, el.fit(env, lights=1), samples=1, width=60)
    >>> figure.axes[1].get_title().splitlines()[0]
    'ambient + 1 light with sizes'
    >>> figure = scene(env, el.fit(env, lights=1), renderer="closed form", width=60)
    >>> figure.axes[0].get_title()
    'ambient + 1 light with sizes'
    """
    env = as_envmap(env)
    check_are_rigs(rigs)
    samples, seed = count("samples", samples, least=1), count("seed", seed)
    check_choice("renderer", renderer, RENDERERS)
    width = count("width", width, *_COLUMNS)
    ((u, _),) = sphere.direction_to_uv([viewpoint(rigs[0])])
    azimuth = 2 * np.pi * u
    has_mitsuba = renderer == "mitsuba" or importlib.util.find_spec("mitsuba") is not None
    if renderer == "closed form" or not has_mitsuba:
        return _closed_picture(where, rigs, azimuth, width)
    page = _page_with_differences(where, len(rigs))
    truth = still_life(env, azimuth, samples, seed, width=width)
    stills = [
        still_life(rig, azimuth, samples, seed + k, width=width)
        for k, rig in enumerate(rigs, start=1)
    ]
    _draw_stills(page, rigs, truth, stills)
    return page.figure


def _closed_picture(where: Placement, rigs: tuple[Rig, ...], azimuth: float, width: int) -> Figure:
    """Draw the scene under each rig in closed form."""
    page = open_page(where, grid(1, len(rigs)), (4 * len(rigs), 3.3))
    images = [closed_still(rig, azimuth, width) for rig in rigs]
    white = white_of(images[0])
    for axis, rig, image in zip(page.panels, rigs, images, strict=True):
        axis.imshow(encode_srgb(image / white))
        entitle(axis, _parts(rig))
        hide_frame(axis)
    return page.figure


def _page_with_differences(where: Placement, rigs: int) -> Page:
    """Panels of the map and of the rigs, above those of the differences."""
    below = [-1, *range(1 + rigs, 1 + 2 * rigs)]
    return open_page(where, [list(range(1 + rigs)), below], (4 * (1 + rigs), 6.2))


def _draw_stills(page: Page, rigs: tuple[Rig, ...], truth: Still, stills: list[Still]) -> None:
    """Draw all images at a common exposure with their errors, and the differences."""
    white = white_of(truth.image)
    titles = [f"the map\nnoise {percent(truth.noise, 2)}"]
    for rig, still in zip(rigs, stills, strict=True):
        figures = f"error {percent(still.error(truth), 2)}, noise {percent(still.noise, 2)}"
        titles.append(f"{_parts(rig)}\n{figures}")
    for axis, still, title in zip(page.panels, (truth, *stills), titles, strict=False):
        axis.imshow(encode_srgb(still.image / white))
        entitle(axis, title)
    _draw_differences(page.figure, page.panels[1 + len(rigs) :], truth, stills)
    for axis in page.panels:
        hide_frame(axis)


def _draw_differences(figure: Figure, axes: list[Axes], truth: Still, stills: list[Still]) -> None:
    """Draw all differences with a common colour scale."""
    wanted = truth.image @ LUMINANCE
    scale = 100 / max(float(wanted.mean()), np.finfo(float).tiny)
    differences = [scale * (still.image @ LUMINANCE - wanted) for still in stills]
    limit = max(float(np.quantile(np.abs(differences), WHITE)), 0.1)
    for axis, difference in zip(axes, differences, strict=True):
        image = axis.imshow(difference, cmap="RdBu_r", vmin=-limit, vmax=limit)
        entitle(axis, "rig minus map")
    figure.colorbar(image, ax=axes, label="% of the mean", shrink=0.8)


def _parts(rig: Rig) -> str:
    sizes = " with sizes" if rig.lights.angular_radius.any() else ""
    return f"{parts_line(rig)}{sizes}"
