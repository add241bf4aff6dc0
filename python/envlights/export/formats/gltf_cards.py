"""Cards in glTF: emissive planes, with textures of 8 bits relative to their brightest sample."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.html import png
from envlights._common.srgb import encode_srgb
from envlights.export.panels import Panel

_STRENGTH = "KHR_materials_emissive_strength"
#: Constants of OpenGL: FLOAT, UNSIGNED_SHORT, CLAMP_TO_EDGE, ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER.
_FLOAT, _SHORT, _CLAMP, _VERTICES, _INDICES = 5126, 5123, 33071, 34962, 34963


def add(asset: dict[str, Any], panels: tuple[Panel, ...]) -> None:
    """Add a plane for each panel to an asset."""
    nodes = asset.setdefault("nodes", [])
    first = len(nodes)
    nodes += [{"name": panel.name, "mesh": j} for j, panel in enumerate(panels)]
    roots = asset["scenes"][0].setdefault("nodes", [])
    roots += range(first, len(nodes))
    used = asset.setdefault("extensionsUsed", [])
    used.append(_STRENGTH)
    asset["images"] = [{"uri": _uri("image/png", _picture(panel))} for panel in panels]
    asset["samplers"] = [{"wrapS": _CLAMP, "wrapT": _CLAMP}]
    asset["textures"] = [{"sampler": 0, "source": j} for j in range(len(panels))]
    asset["materials"] = [_material(j, panel) for j, panel in enumerate(panels)]
    asset["meshes"] = [_mesh(j, panel) for j, panel in enumerate(panels)]
    asset |= _buffers(panels)


def _brightest(panel: Panel) -> float:
    return float(panel.opaque_texture.max()) or 1.0


def _picture(panel: Panel) -> bytes:
    """Texture as a picture of sRGB codes."""
    relative = panel.opaque_texture / np.float32(_brightest(panel))
    return png(np.round(255 * encode_srgb(relative)).astype(np.uint8))


def _material(j: int, panel: Panel) -> dict[str, Any]:
    """A black surface that emits."""
    black = {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0, "roughnessFactor": 1}
    return {
        "name": panel.name,
        "pbrMetallicRoughness": black,
        "emissiveFactor": [1, 1, 1],
        "emissiveTexture": {"index": j},
        "extensions": {_STRENGTH: {"emissiveStrength": _brightest(panel)}},
    }


def _mesh(j: int, panel: Panel) -> dict[str, Any]:
    first = 3 * j
    primitive = {
        "attributes": {"POSITION": first, "TEXCOORD_0": first + 1},
        "indices": first + 2,
        "material": j,
    }
    return {"name": panel.name, "primitives": [primitive]}


def _buffers(panels: tuple[Panel, ...]) -> dict[str, Any]:
    """Buffer, its views, and accessors: points, texture coordinates and triangles of each panel."""
    data, views, accessors = b"", [], []
    for panel in panels:
        for values, kind, which in _arrays(panel):
            view = {"buffer": 0, "byteOffset": len(data), "byteLength": values.nbytes}
            views.append({**view, "target": which})
            accessors.append(_accessor(len(views) - 1, values, kind))
            data += values.tobytes() + bytes(-values.nbytes % 4)
    buffer = {"byteLength": len(data), "uri": _uri("application/octet-stream", data)}
    return {"buffers": [buffer], "bufferViews": views, "accessors": accessors}


def _arrays(panel: Panel) -> list[tuple[NDArray[Any], str, int]]:
    """Vertices, texture coordinates from the upper left, as in glTF, and a fan of triangles."""
    points, places = panel.outline("gltf")
    fan = [index for k in range(1, len(points) - 1) for index in (0, k, k + 1)]
    return [
        (points.astype("<f4"), "VEC3", _VERTICES),
        (places.astype("<f4"), "VEC2", _VERTICES),
        (np.array(fan, "<u2"), "SCALAR", _INDICES),
    ]


def _accessor(view: int, values: NDArray[Any], kind: str) -> dict[str, Any]:
    rows = values.reshape(len(values), -1)
    return {
        "bufferView": view,
        "componentType": _SHORT if kind == "SCALAR" else _FLOAT,
        "count": len(values),
        "type": kind,
        "min": rows.min(axis=0).tolist(),
        "max": rows.max(axis=0).tolist(),
    }


def _uri(kind: str, data: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"
