"""A scene under a map and under rigs, rendered by Mitsuba."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from envlights._check import count
from envlights._srgb import encode_srgb
from envlights.envmap import AnyMap, as_envmap
from envlights.kernels import sphere
from envlights.kernels.image import LUMINANCE
from envlights.plot.figure import Picture, check_are_rigs, hide_frame
from envlights.plot.probe import viewpoint
from envlights.rig import Rig, parts_line
from envlights.scene.path_traced import Still
from envlights.scene.still_life import still_life

#: Fraction of the pixels that are not brighter than white.
_WHITE = 0.99


def scene(env: AnyMap, *rigs: Rig, samples: int = 128, seed: int = 0) -> Picture:
    """Draw a ball and a box on a floor under the map and under rigs, and their differences.

    All images have the same exposure; a difference is of luminance, in percent of the mean. The
    titles hold relative RMS differences of the images, corrected for noise, and the noise of the
    images. Unlike the error of a probe they include shadows and light between surfaces. The view
    is from beside the brightest light of the first rig. Needs
    Mitsuba.

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

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    EnvLightsError
        If Mitsuba is not installed, the map is not cell-centred, or there is no rig.

    Examples
    --------
    >>> import envlights as el
    >>> env = el.EnvMap(el.synthetic.hall(32).radiance)
    >>> figure = scene(env, el.fit(env, lights=1), samples=1)
    >>> figure.axes[1].get_title().splitlines()[0]
    'ambient + 1 light with sizes'
    """
    env = as_envmap(env)
    check_are_rigs(rigs)
    samples, seed = count("samples", samples, least=1), count("seed", seed)
    # Render all from the same position, each with its own paths.
    ((u, _),) = sphere.direction_to_uv([viewpoint(rigs[0])])
    azimuth = 2 * np.pi * u
    truth = still_life(env, azimuth, samples, seed)
    stills = [still_life(rig, azimuth, samples, seed + k) for k, rig in enumerate(rigs, start=1)]
    # Draw the images above the differences.
    figure = Picture(figsize=(4 * (1 + len(rigs)), 6.2))
    axes = figure.subplots(2, 1 + len(rigs), squeeze=False)
    white = max(float(np.quantile(truth.image @ LUMINANCE, _WHITE)), np.finfo(float).tiny)
    titles = [f"the map\nnoise {_percent(truth.noise)}"]
    for rig, still in zip(rigs, stills, strict=True):
        figures = f"error {_percent(still.error(truth))}, noise {_percent(still.noise)}"
        titles.append(f"{_parts(rig)}\n{figures}")
    for axis, still, title in zip(axes[0], (truth, *stills), titles, strict=True):
        axis.imshow(encode_srgb(still.image / white))
        axis.set_title(title)
    _draw_differences(figure, axes[1, 1:].tolist(), truth, stills)
    for axis in axes.flat:
        hide_frame(axis)
    return figure


def _draw_differences(figure: Picture, axes: list[Axes], truth: Still, stills: list[Still]) -> None:
    """Draw all with the same colours, so that they can be compared."""
    wanted = truth.image @ LUMINANCE
    scale = 100 / max(float(wanted.mean()), np.finfo(float).tiny)
    differences = [scale * (still.image @ LUMINANCE - wanted) for still in stills]
    limit = max(float(np.quantile(np.abs(differences), _WHITE)), 0.1)
    for axis, difference in zip(axes, differences, strict=True):
        image = axis.imshow(difference, cmap="RdBu_r", vmin=-limit, vmax=limit)
        axis.set_title("rig minus map")
    figure.colorbar(image, ax=axes, label="% of the mean", shrink=0.8)


def _parts(rig: Rig) -> str:
    sizes = " with sizes" if rig.lights.angular_radius.any() else ""
    return f"{parts_line(rig)}{sizes}"


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %"
