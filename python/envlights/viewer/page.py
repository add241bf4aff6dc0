"""One page that shows a ball and a box in a map, under a rig."""

from __future__ import annotations

import json
import os
import re
from dataclasses import dataclass
from functools import cache, cached_property
from html import escape
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from envlights._common.check import describe, flag, named_arguments
from envlights._common.files import as_path
from envlights._common.words import fill_template
from envlights._native import EnvLightsError
from envlights.environment.decoders.source import is_source, name_of
from envlights.environment.envmap import EnvMap
from envlights.environment.fill import Fill
from envlights.environment.reading import AnyMap, as_envmap
from envlights.export.files import save_scene
from envlights.rigs.rig import Rig
from envlights.viewer import data, model_textures, widget
from envlights.viewer.model import Model
from envlights.viewer.truth import check_renderer, with_truth

#: Distance of the camera over the diagonal of a model.
_AWAY = 1.8
#: Endings of a page.
SUFFIXES = (".html", ".htm")
#: Note of a page whose rig was fitted without a floor.
_WITHOUT_FLOOR = (
    "These lights were fitted without a floor, so they hold the light of the ground as well: it"
    " stays where the things hide it. Fit with floor=True for a better picture."
)


@dataclass(frozen=True)
class View:
    """A page that shows things in a map.

    Jupyter draws it as a widget if the library anywidget is installed, else in a frame.

    Attributes
    ----------
    data : dict
        What the page draws, as JSON has it: rigs, the encoded map, the start of the camera.
    """

    data: dict[str, Any]

    @property
    def html(self) -> str:
        """Text of the page, which needs no other file and no network."""
        return fill_template(
            _text("page.html"),
            title=escape(self.data["title"]),
            style=self._style(),
            script=self._script(),
            data=_json(self._content()),
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the page as one file; a failure leaves no file."""
        if as_path(path).suffix.lower() not in SUFFIXES:
            raise EnvLightsError(f"cannot write {path}: the suffix of a page must be .html")
        save_scene(path, self.html)

    def _repr_html_(self) -> str:
        style = "width: 100%; height: 560px; border: 0"
        return f'<iframe style="{style}" srcdoc="{escape(self.html)}"></iframe>'

    @cached_property
    def widget(self) -> Any:
        """The page as a widget of Jupyter; needs the extra `widget`.

        Its traits follow the page, and the page follows them: ``exposure`` in stops, ``count`` of
        lights, ``sizes``, ``off`` (rows of the lights that are switched off) and ``eye``, (3,) in
        metres.
        """
        module = self._script() + _compact("widget.js")
        return widget.widget(self._content(), module, self._style())

    def _script(self) -> str:
        """Module of the page, whose entry is ``render({model, el})``."""
        return "".join(
            _compact(f"{name}.js") for name in ("scene", "view", "lights", *self._more())
        )

    def _style(self) -> str:
        return _text("view.css") + (_text("truth.css") if "truth" in self.data else "")

    def _more(self) -> list[str]:
        """Parts that few pages have."""
        return [name for name in ("model", "truth") if name in self.data]

    def _content(self) -> dict[str, Any]:
        return {**self.data, "shaders": shaders("model" in self.data)}

    def _ipython_display_(self) -> None:
        display = import_module("IPython.display").display
        if widget.is_available():
            display(self.widget)
        else:
            display({"text/html": self._repr_html_(), "text/plain": repr(self)}, raw=True)

    def __repr__(self) -> str:
        return f"<View: {self.data['title']}, {len(self.html) / 1000:.0f} kB>"


@named_arguments()
def view(
    env: AnyMap | Rig,
    rig: Rig | None = None,
    *,
    title: str | None = None,
    fill: Fill = None,
    model: Any = None,
    truth: bool = False,
) -> View:
    """Page that shows a ball and a box in a map, lit by a few lights, with their shadows.

    The page is one file for any browser with WebGL 2. It shows the map with its ground, and things
    that can be moved. Light that a disc or the ambient term sends past them is computed in closed
    form, and one model adds all reflections between floor and things. Switches show points in place
    of discs, harmonics, and the overlays of the paper. Each light has a row (on, brightness,
    colour) and a handle on the map. Buttons save the lights that are on: ``lights.json`` is a rig
    for `Rig.load`, and ``map.hdr`` its ambient term and discs, at the size of the page's map.

    Parameters
    ----------
    env : EnvMap, path-like, array_like, shape (height, 2 * height, 3), or Rig
        The map. A rig alone is shown in the map of its own lights.
    rig : Rig, optional
        Lights of the page. Fit it with ``floor=True``: other rigs hold the light of the map's
        ground as well, which no thing on it can hide. Default: 1 to 8 lights, as discs and as
        points, fitted over a floor, and without a floor with harmonics.
    title : str, optional
        Text above the controls; the name of the file when left out.
    fill : {"black", "harmonic", "ground"}, float or array_like, shape (3,), optional
        Radiance where the map shows nothing; see `EnvMap.filled`.
    model : Model, path-like, trimesh.Trimesh or trimesh.Scene, optional
        A thing of your own in place of ball and box, which a switch adds: see `Model`. Its shadows
        are rays; the picture is refined while nothing moves.
    truth : bool
        Add a picture of the start, path-traced under the map by Mitsuba (extra `bake`): 480x270
        pixels of 200 paths, which take up to a minute on two cores. A slider divides truth from
        page until camera, things or ground change.

    Returns
    -------
    View
        ``html`` is the text of the page, and ``save(path)`` writes it.

    Raises
    ------
    EnvLightsError
        If `env` is no map and no rig, `rig` is no rig or has more than 8 lights, `filled` refuses
        `fill`, `model` is no model or has more than 200 000 triangles, or Mitsuba
        is missing or a model given for `truth`.

    References
    ----------
    C. B. Madsen, M. K. D. Sørensen, M. Vittrup: "Estimating Positions and Radiances of a Small
    Number of Light Sources for Real-Time Image-Based Lighting", Eurographics 2003; section 4.

    Examples
    --------
    >>> import envlights as el
    >>> page = el.view(el.Rig([0.2, 0.2, 0.3], el.Lights([[0, 1, 0]], [[2, 2, 1.5]]), 0.0))
    >>> page.html[:15]
    '<!doctype html>'
    """
    _check_truth(truth, model)
    if isinstance(env, Rig):
        if rig is not None:
            raise EnvLightsError("view takes a map and a rig, or one of them; got two rigs")
        title = "A rig" if title is None else title
        return view(data.map_of(env), env, fill=fill, title=title, model=model, truth=truth)
    _check_rig(rig)
    world = as_envmap(env).filled(fill)
    rigs = data.fitted_rigs(world) if rig is None else data.rigs_of(rig)
    shown = model if model is None or isinstance(model, Model) else Model.open(model)
    content = _data(world, rigs, _title(env, title))
    content = with_truth(content, world) if truth else content
    return View(content if shown is None else _with_model(content, shown))


def _with_model(content: dict[str, Any], model: Model) -> dict[str, Any]:
    """Data of a page with a model, which is seen as a whole at first."""
    start = {
        "only": 3,
        "look": [0.0, 0.45 * float(model.size[1]), 0.0],
        "distance": _AWAY * float(np.linalg.norm(model.size)),
    }
    state = {**content["state"], **start}
    return {**content, "model": model_textures.textures(model), "state": state}


def _check_truth(truth: object, model: object) -> None:
    """Refuse a truth that cannot be rendered, before anything is fitted."""
    if not flag("truth", truth):
        return
    if model is not None:
        raise EnvLightsError("the truth shows a ball and a box; leave out truth or model")
    check_renderer()


def _check_rig(rig: object) -> None:
    """Refuse what is no rig, and more lights than the shader takes."""
    if rig is not None and not isinstance(rig, Rig):
        raise EnvLightsError(f"rig must be an envlights.Rig; got {describe(rig)}")
    if rig is not None and len(rig.lights) > data.MOST_LIGHTS:
        raise EnvLightsError(
            f"a page shows at most {data.MOST_LIGHTS} lights; the rig has {len(rig.lights)}: fit"
            f" it with lights={data.MOST_LIGHTS}"
        )


def _title(env: AnyMap, title: object) -> str:
    if title is not None and not isinstance(title, str):
        raise EnvLightsError(f"title must be text; got {describe(title)}")
    return title or (Path(name_of(env)).stem if is_source(env) else "A map")


def _data(world: EnvMap, rigs: dict[str, list[Rig]], title: str) -> dict[str, Any]:
    floor, notes = data.floor_of(world)
    picture = data.picture(world)
    if not any(rig.floor for some in rigs.values() for rig in some):
        notes.append(_WITHOUT_FLOOR)
    return {
        "title": title,
        **picture,
        **data.rig_file(next(iter(rigs.values()))[0]),
        "irradiance": {
            "floor": data.irradiance_table(world, picture["white"], over_floor=True),
            "whole": data.irradiance_table(world, picture["white"], over_floor=False),
        },
        "floor": floor.tolist(),
        "rigs": {name: [data.rig_data(each) for each in some] for name, some in rigs.items()},
        "notes": notes,
        "state": {"azimuth": data.azimuth(rigs), "ambient": next(iter(rigs)).split()[0]},
    }


def shaders(has_model: bool) -> dict[str, str]:
    """Text of the shaders; those of a model only if there is one."""
    names = ("light", "scene", *(("model", "paths") if has_model else ()))
    return {name: _dense(_compact(f"{name}.glsl")) for name in names}


def _dense(shader: str) -> str:
    """Text of a shader without comments behind code and without spaces around brackets."""
    code = re.sub(r"(?m)[ ]+// .*$", "", shader)
    return re.sub(r"(?m)^(?!#).*$", lambda line: re.sub(r" *([=,;(){}]) *", r"\1", line[0]), code)


def _compact(name: str) -> str:
    """Text of a file of the package without comment lines and indentation."""
    lines = map(str.strip, _text(name).splitlines())
    comments = ("// ", "/** ")
    return "".join(f"{line}\n" for line in lines if line and not line.startswith(comments))


@cache
def _text(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def _json(content: object) -> str:
    """JSON that can stand in a script: no ``<`` begins a tag or a comment."""
    text = json.dumps(content, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c")
