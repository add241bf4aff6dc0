"""One page that shows a ball and a box in a map, under a rig."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from html import escape
from importlib.resources import files
from typing import Any

import numpy as np

from envlights._native import EnvLightsError
from envlights._unseen import Unseen
from envlights.envmap import AnyMap, as_envmap
from envlights.export.files import save_scene
from envlights.io.source import is_source, name_of
from envlights.rig import Rig
from envlights.view import data, model_textures, widget
from envlights.view.model import Model

#: Rows of the map that is drawn for a rig without a map.
_ROWS = 512


@dataclass(frozen=True)
class View:
    """A page that shows things in a map; in Jupyter it is drawn in a frame."""

    data: Mapping[str, Any]
    """What the page draws, as JSON has it: rigs, the encoded map, the start of the camera."""

    @property
    def html(self) -> str:
        """The page: one file that needs no other."""
        parts = {
            "TITLE": escape(self.data["title"]),
            "STYLE": _text("view.css"),
            "SCRIPT": script(),
            "DATA": _json({**self.data, "shaders": shaders(bool(self.data["model"]))}),
        }
        page = _text("page.html")
        for name, text in parts.items():
            before, _, after = page.partition(name)
            page = before + text + after
        return page

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the page; a failure leaves no file."""
        save_scene(path, self.html)

    def _repr_html_(self) -> str:
        style = "width: 100%; height: 560px; border: 0"
        return f'<iframe style="{style}" srcdoc="{escape(self.html)}"></iframe>'

    @cached_property
    def widget(self) -> Any:
        """The page as a widget of Jupyter, whose traits follow it; needs the extra `widget`.

        Traits: `exposure` in stops, `count` of lights, `sizes`, `off` (rows of the lights that are
        switched off) and `eye`, (3,) in metres.
        """
        content = {**self.data, "shaders": shaders(bool(self.data["model"]))}
        return widget.widget(content, script() + _text("widget.js"), _text("view.css"))

    def _ipython_display_(self) -> None:
        from IPython.display import display

        if widget.is_available():
            display(self.widget)
        else:
            display({"text/html": self._repr_html_(), "text/plain": repr(self)}, raw=True)

    def __repr__(self) -> str:
        return f"<View: {self.data['title']}, {len(self.html) / 1024:.0f} kB>"


def view(
    env: AnyMap | Rig,
    rig: Rig | None = None,
    *,
    title: str | None = None,
    unseen: Unseen = None,
    model: Any = None,
) -> View:
    """Page that shows a ball and a box in a map, lit by a few lights, with their shadows."""
    if isinstance(env, Rig):
        if rig is not None:
            raise EnvLightsError("view takes a map and a rig, or one of them; got two rigs")
        env, rig = env.to_map(_ROWS), env
        title = "A rig" if title is None else title
    if rig is not None and not isinstance(rig, Rig):
        raise EnvLightsError(f"rig must be an envlights.Rig; got {type(rig).__name__}")
    if title is None:
        title = os.path.basename(name_of(env)) if is_source(env) else "A map"
    world = as_envmap(env).filled(unseen)
    rigs = data.fitted_rigs(world) if rig is None else data.rigs_of(rig)
    floor, notes = data.floor_albedo(world)
    shown = model if model is None or isinstance(model, Model) else Model.open(model)
    return View({
        "title": title,
        **data.picture(world),
        "irradiance": {name: data.irradiance_table(world, name == "floor") for name in ("floor", "whole")},
        "floor": floor.tolist(),
        "rigs": {name: [data.rig_data(each) for each in some] for name, some in rigs.items()},
        "notes": notes,
        "model": None if shown is None else model_textures.textures(shown),
        "state": {"azimuth": data.azimuth(rigs), "ambient": next(iter(rigs)).split()[0], **start_of(shown)},
    })


def script() -> str:
    """Module of the page, whose entry is ``render({model, el})``."""
    return _text("scene.js") + _text("view.js")


def shaders(has_model: bool) -> dict[str, str]:
    """Text of the shaders; those of a model only if there is one."""
    names = ("light", "scene", *(("model", "paths") if has_model else ()))
    return {name: _text(f"{name}.glsl") for name in names}


def start_of(model: Model | None) -> dict[str, Any]:
    """Start of the camera: all of a model is in the picture, which stands alone."""
    if model is None:
        return {}
    radius = float(np.linalg.norm(model.size)) / 2
    distance = max(3.6 * radius, 0.05)
    return {"only": 3, "look": [0.0, 0.45 * float(model.size[1]), 0.0], "distance": distance}


@cache
def _text(name: str) -> str:
    return files("envlights.view").joinpath(name).read_text(encoding="utf-8")


def _json(content: object) -> str:
    """JSON that can stand in a script: no ``<`` begins a tag or a comment."""
    return json.dumps(content, allow_nan=False).replace("<", "\\u003c")
