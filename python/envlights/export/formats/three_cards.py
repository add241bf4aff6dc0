"""Cards in three.js: area lights of one radiance, planes that show them, and points for spheres."""

from __future__ import annotations

from typing import Any

import numpy as np

from envlights.export.formats.three_things import colour_of, image_of, texture_of, thing_of, uuid_of
from envlights.export.panels import Panel

#: Constants of three.js: UVMapping, and ClampToEdgeWrapping along both axes.
_CLAMPED = {"mapping": 300, "wrap": [1001, 1001]}
#: Ratio of the sides of a square and the diameter of the disc of its area.
_SIDE = np.sqrt(np.pi) / 2


def tables(panels: tuple[Panel, ...]) -> dict[str, Any]:
    """Images, textures, materials and geometries of the planes."""
    panels = tuple(panel for panel in panels if panel.shape != "sphere")
    images = [image_of(f"{panel.name}.image", panel.opaque_texture) for panel in panels]
    textures = [
        texture_of(f"{panel.name}.texture", panel.name, image, **_CLAMPED)
        for panel, image in zip(panels, images, strict=True)
    ]
    materials = [
        {
            "uuid": uuid_of(f"{panel.name}.material"),
            "type": "MeshBasicMaterial",
            "color": 0xFFFFFF,
            "map": texture["uuid"],
        }
        for panel, texture in zip(panels, textures, strict=True)
    ]
    geometries = [_geometry(panel) for panel in panels]
    return {
        "images": images,
        "textures": textures,
        "materials": materials,
        "geometries": geometries,
    }


def things(panels: tuple[Panel, ...]) -> list[dict[str, Any]]:
    """A light and a plane for each panel, and a point for each sphere."""
    flat = [panel for panel in panels if panel.shape != "sphere"]
    spheres = [_point(panel) for panel in panels if panel.shape == "sphere"]
    return [*(thing for panel in flat for thing in (_light(panel), _plane(panel))), *spheres]


def _point(panel: Panel) -> dict[str, Any]:
    """A point of the intensity of a sphere, without a limit of its reach."""
    *_, centre = panel.axes("three")
    return thing_of(
        "PointLight",
        panel.name,
        matrix=[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, *centre.tolist(), 1],
        userData={"radius": panel.radius},
        distance=0,
        decay=2,
        **colour_of(panel.intensity),
    )


def _light(panel: Panel) -> dict[str, Any]:
    """A rectangle of the area of the panel, which shines along its local -z."""
    u, v, facing, centre = panel.axes("three")
    width = np.linalg.norm(u)
    x = -u / width
    y = np.cross(-facing, x)
    height = abs(y @ v)
    columns = [(*x, 0), (*y, 0), (*-facing, 0), (*centre, 1)]
    side = _SIDE if panel.shape == "disc" else 1.0
    return thing_of(
        "RectAreaLight",
        panel.name,
        matrix=np.ravel(columns).tolist(),
        width=float(side * width),
        height=float(side * height),
        **colour_of(panel.radiance),
    )


def _plane(panel: Panel) -> dict[str, Any]:
    return thing_of(
        "Mesh",
        f"{panel.name}_plane",
        geometry=uuid_of(f"{panel.name}.geometry"),
        material=uuid_of(f"{panel.name}.material"),
    )


def _geometry(panel: Panel) -> dict[str, Any]:
    """A fan of triangles, counter-clockwise as seen from the origin; v runs upwards."""
    points, places = panel.outline("three")
    uv = places * [1, -1] + [0, 1]
    fan = [index for k in range(1, len(points) - 1) for index in (0, k, k + 1)]
    return {
        "uuid": uuid_of(f"{panel.name}.geometry"),
        "type": "BufferGeometry",
        "data": {
            "attributes": {
                "position": _attribute(points, 3),
                "uv": _attribute(uv, 2),
            },
            "index": {"type": "Uint16Array", "array": fan},
        },
    }


def _attribute(values: Any, size: int) -> dict[str, Any]:
    array = np.ravel(values).tolist()
    return {"itemSize": size, "type": "Float32Array", "array": array, "normalized": False}
