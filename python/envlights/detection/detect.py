"""`detect`: the lights of a map."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any, Literal, overload

from envlights._check import check_choice
from envlights.detection.component_tree import detect_tree
from envlights.detection.lights import DetectedLights
from envlights.detection.loghin import detect_article
from envlights.envmap import AnyMap

#: Detectors by name.
METHODS: dict[str, Callable[..., DetectedLights]] = {
    "tree": detect_tree,
    "article": detect_article,
}


# Declare the options for type checkers; `detect` itself only passes them on.
@overload
def detect(
    env: AnyMap,
    method: Literal["tree"] = ...,
    *,
    max_lights: int | None = ...,
    min_flux_fraction: float = ...,
    min_worth: float = ...,
    threshold: float | None = ...,
    rise: float = ...,
    prominence: float = ...,
    gap_deg: float = ...,
    extent: float = ...,
    working_width: int = ...,
    white: float | None = ...,
) -> DetectedLights: ...


@overload
def detect(
    env: AnyMap,
    method: Literal["article"],
    *,
    max_lights: int | None = ...,
    working_width: int = ...,
    reduction: str = ...,
    blur_px: float = ...,
    samples_per_pixel: float = ...,
    window_px: int = ...,
    threshold: float = ...,
    suppression_deg: float = ...,
    tolerance: float = ...,
    ceiling: float = ...,
    merge_cap_deg: float | None = ...,
    relative: bool = ...,
    move_to_maximum: bool = ...,
    sphere: bool = ...,
    sampling: str = ...,
) -> DetectedLights: ...


@overload
def detect(env: AnyMap, method: str, **options: Any) -> DetectedLights: ...


def detect(env: AnyMap, method: str = "tree", **options: Any) -> DetectedLights:
    """Lights of a map.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map.
    method : {"tree", "article"}
        "tree": a component tree, with each light measured on the sphere; see `detect_tree`.
        "article": the method of Loghin (2021), on samples; see `detect_article`.
    max_lights : int, optional
        Largest number of lights. The tree merges neighbours; the article drops the dimmest.
    working_width : int
        Largest number of columns of the reduced map in which lights are searched.
    min_flux_fraction, min_worth, rise, prominence, gap_deg, extent, white
        Options of the tree: the limits and the extent of lights; see `detect_tree`.
    threshold : float, optional
        Luminance above which a pixel is bright. By default the tree chooses it from the map, and
        the article has 0.8.
    reduction, blur_px, samples_per_pixel, window_px, suppression_deg, tolerance, \
ceiling, merge_cap_deg, relative, move_to_maximum, sphere, sampling
        Options of the article: samples, levels and merging; see `detect_article`.

    Returns
    -------
    DetectedLights
        Brightest first.

    Raises
    ------
    EnvLightsError
        If `env` is not a map, the method is not known or an option is out of its range.

    Examples
    --------
    >>> import envlights as el
    >>> lamp = el.synthetic.Disc((0, 0, 1), 5.0, (9, 9, 9))
    >>> env = el.EnvMap(el.synthetic.scene(256, background=[0.1] * 3, shapes=[lamp]).radiance)
    >>> lights = detect(env)
    >>> len(lights), round(float(lights.angular_radius[0]) * 57.3, 1)
    (1, 5.0)
    """
    check_choice("method", method, tuple(METHODS))
    return METHODS[method](env, **options)


def _options(method: str) -> dict[str, inspect.Parameter]:
    """Parameters of a detector, without the map."""
    _, *options = inspect.signature(METHODS[method]).parameters.values()
    return {option.name: option for option in options}


def _signature() -> inspect.Signature:
    """Signature for `help` and completion: all options, with the defaults of the first method."""
    *fixed, _ = inspect.signature(detect).parameters.values()
    options: dict[str, inspect.Parameter] = {}
    for method in METHODS:
        options = {**options, **_options(method), **options}
    return inspect.signature(detect).replace(parameters=[*fixed, *options.values()])


detect.__signature__ = _signature()  # type: ignore[attr-defined]
