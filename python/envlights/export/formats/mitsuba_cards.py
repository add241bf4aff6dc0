"""Cards in Mitsuba: rectangles with a bitmap, disks that emit to one side, and spheres."""

from __future__ import annotations

import importlib
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from envlights.export.panels import Panel

_Emitters = dict[str, dict[str, Any]]


def shapes(panels: tuple[Panel, ...]) -> _Emitters:
    """Shapes with area emitters for `load_dict`; they hide the map, so they show it too."""
    if not panels:
        return {}
    mi = importlib.import_module("mitsuba")
    return {
        panel.name: {
            "type": _kind(panel),
            "to_world": mi.ScalarTransform4f(to_world(panel)),
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}},
            "emitter": {"type": "area", "radiance": _radiance(panel, mi)},
        }
        for panel in panels
    }


def add_shapes(root: ElementTree.Element, panels: tuple[Panel, ...], names: list[str]) -> None:
    """Add shapes to a scene."""
    for panel, name in zip(panels, names, strict=True):
        _add_shape(root, panel, name)


def to_world(panel: Panel) -> NDArray[np.float64]:
    """Matrix of a rectangle, disk or sphere of Mitsuba, whose x and y go from -1 to 1."""
    u, v, facing, centre = panel.axes("mitsuba")
    matrix = np.eye(4)
    sides = panel.radius * np.eye(3) if panel.shape == "sphere" else [u / 2, -v / 2, facing]
    matrix[:3] = np.stack([*sides, centre], axis=1)
    return matrix


def texture_of(panel: Panel) -> NDArray[np.float32]:
    """Texture with its last row first, because Mitsuba has row 0 at v = 0, the lower edge."""
    return np.ascontiguousarray(panel.opaque_texture[::-1])


def _kind(panel: Panel) -> str:
    return {"disc": "disk", "sphere": "sphere"}.get(panel.shape, "rectangle")


def _radiance(panel: Panel, mi: Any) -> dict[str, Any]:
    if _kind(panel) != "rectangle":
        return {"type": "rgb", "value": panel.opaque_radiance.tolist()}
    bitmap = mi.Bitmap(texture_of(panel))
    return {"type": "bitmap", "bitmap": bitmap, "wrap_mode": "clamp", "raw": True}


def _add_shape(root: ElementTree.Element, panel: Panel, name: str) -> None:
    shape = ElementTree.SubElement(root, "shape", type=_kind(panel), id=panel.name)
    place = ElementTree.SubElement(shape, "transform", name="to_world")
    numbers = " ".join(map(repr, to_world(panel).ravel().tolist()))
    ElementTree.SubElement(place, "matrix", value=numbers)
    surface = ElementTree.SubElement(shape, "bsdf", type="diffuse")
    ElementTree.SubElement(surface, "rgb", name="reflectance", value="0")
    emitter = ElementTree.SubElement(shape, "emitter", type="area")
    if _kind(panel) != "rectangle":
        value = " ".join(map(repr, panel.opaque_radiance.tolist()))
        ElementTree.SubElement(emitter, "rgb", name="radiance", value=value)
    else:
        texture = ElementTree.SubElement(emitter, "texture", type="bitmap", name="radiance")
        ElementTree.SubElement(texture, "string", name="filename", value=name)
        ElementTree.SubElement(texture, "string", name="wrap_mode", value="clamp")
        ElementTree.SubElement(texture, "boolean", name="raw", value="true")
