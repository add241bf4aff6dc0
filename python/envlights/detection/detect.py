"""`detect`: the bright places of a map."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from envlights._check import check_choice
from envlights.detection.component_tree import detect_tree
from envlights.detection.lights import DetectedLights
from envlights.detection.loghin import detect_article
from envlights.envmap import AnyMap

#: The detectors by name.
METHODS: dict[str, Callable[..., DetectedLights]] = {
    "tree": detect_tree,
    "article": detect_article,
}


def detect(env: AnyMap, method: str = "tree", **options: Any) -> DetectedLights:
    """Bright places of a map, as lights.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map.
    method : {"tree", "article"}
        "tree": the component tree, which follows every bright path and measures each light on the
        sphere; see `detect_tree`. "article": the method of Loghin (2021), on samples; see
        `detect_article`.
    **options
        Those of `detect_tree` or `detect_article`.

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
    (1, 5.1)
    """
    check_choice("method", method, tuple(METHODS))
    return METHODS[method](env, **options)
