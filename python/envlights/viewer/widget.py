"""The page as a widget of Jupyter, by anywidget."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from envlights._native import EnvLightsError

#: Range of the slider for the exposure, in stops.
_STOPS = 4.0
#: Largest coordinate of the eye in metres.
_FAR = 1e4


def is_available() -> bool:
    """True if anywidget is installed."""
    return find_spec("anywidget") is not None


def widget(data: Mapping[str, Any], module: str, style: str) -> Any:
    """Widget that draws the data of a page, by its module of JavaScript and its style sheet.

    Its traits are `exposure` in stops, `count`, `sizes`, `off` (the lights that are switched off)
    and `eye`, (3,) in metres; they follow the page, and the page follows them.
    """
    if not is_available():
        raise EnvLightsError(
            "a widget needs the library anywidget; install envlights[widget], or show the page"
            " itself, which Jupyter draws in a frame"
        )
    most = max(len(rigs) for rigs in data["rigs"].values())
    lights = max(len(rig["lights"]) for rigs in data["rigs"].values() for rig in rigs)
    return _class(module, style, most, lights)(data=dict(data), count=min(4, most))


@cache
def _class(module: str, style: str, most: int, lights: int) -> Any:
    """Class of a widget with up to `most` rigs of up to that many lights."""
    traitlets = import_module("traitlets")
    number = traitlets.CFloat
    traits = {
        "data": traitlets.Dict(),
        "exposure": number(0.0, min=-_STOPS, max=_STOPS),
        "count": traitlets.Int(1, min=1, max=most),
        "sizes": traitlets.Bool(True),
        "off": traitlets.List(traitlets.Int(min=0, max=max(lights - 1, 0))),
        "eye": traitlets.Tuple(
            *(number(min=-_FAR, max=_FAR) for _ in range(3)), allow_none=True, default_value=None
        ),
    }
    synced = {name: trait.tag(sync=True) for name, trait in traits.items()}
    base = import_module("anywidget").AnyWidget
    body = {"__module__": __name__, "__doc__": "A page in Jupyter.", "_esm": module, "_css": style}
    return type("ViewWidget", (base,), {**body, **synced})
