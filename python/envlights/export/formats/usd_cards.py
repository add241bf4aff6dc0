"""Cards in OpenUSD: rectangle lights with a texture, disk, sphere, and mesh lights if oblique."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights._common.words import fill_template
from envlights.export.formats.usd_text import asset, colour, prim
from envlights.export.panels import Panel, crop_names

#: Surface of a mesh light: black, with the texture as emission.
_MATERIAL = """\
token outputs:surface.connect = <@PATH@/surface.outputs:surface>

        def Shader "surface"
        {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor = (0, 0, 0)
            color3f inputs:emissiveColor.connect = <@PATH@/texture.outputs:rgb>
            float inputs:roughness = 1
            token outputs:surface
        }

        def Shader "texture"
        {
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @FILE@
            token inputs:sourceColorSpace = "raw"
            float2 inputs:st.connect = <@PATH@/st.outputs:result>
            token inputs:wrapS = "clamp"
            token inputs:wrapT = "clamp"
            float3 outputs:rgb
        }

        def Shader "st"
        {
            uniform token info:id = "UsdPrimvarReader_float2"
            string inputs:varname = "st"
            float2 outputs:result
        }"""


def texture(panel: Panel) -> NDArray[np.float32]:
    """Texture of a light; a mesh light hides the map, so it shows it too."""
    return panel.texture if panel.is_rectangle else panel.opaque_texture


def prims(panels: tuple[Panel, ...], prefix: str) -> list[str]:
    """A light for each panel, and the materials of mesh lights."""
    names = crop_names(panels, prefix, "usd")
    return [text for pair in zip(panels, names, strict=True) for text in _light(*pair)]


def _light(panel: Panel, file: str) -> list[str]:
    if panel.shape == "sphere":
        return [_sphere(panel)]
    if panel.shape == "disc":
        return [_disk(panel)]
    return [_rectangle(panel, file)] if panel.is_rectangle else _mesh(panel, file)


def _rectangle(panel: Panel, file: str) -> str:
    """Light along its local -z; its texture begins at +x and +y, the upper left seen from there."""
    width, height = panel.size.tolist()
    light = [
        f"float inputs:width = {width!r}",
        f"float inputs:height = {height!r}",
        "float inputs:intensity = 1.0",
        f"asset inputs:texture:file = {asset(file)}",
    ]
    return prim("RectLight", panel.name, [*light, *_transform(panel, scale=(1.0, 1.0))])


def _disk(panel: Panel) -> str:
    width, height = panel.size.tolist()
    light = ["float inputs:radius = 0.5", *colour(panel.radiance)]
    return prim("DiskLight", panel.name, [*light, *_transform(panel, scale=(width, height))])


def _sphere(panel: Panel) -> str:
    *_, centre = panel.axes("usd")
    light = [f"float inputs:radius = {panel.radius!r}", *colour(panel.radiance)]
    place = [
        f"double3 xformOp:translate = {tuple(centre.tolist())!r}",
        'uniform token[] xformOpOrder = ["xformOp:translate"]',
    ]
    return prim("SphereLight", panel.name, [*light, *place])


def _transform(panel: Panel, scale: tuple[float, float]) -> list[str]:
    """Local x to the left, y up and z away, as seen from the origin."""
    u, v, facing, centre = panel.axes("usd")
    width, height = panel.size / scale
    rows = [(*axis.tolist(), 0.0) for axis in (-u / width, -v / height, -facing)]
    matrix = ", ".join(map(repr, [*rows, (*centre.tolist(), 1.0)]))
    return [
        f"matrix4d xformOp:transform = ( {matrix} )",
        'uniform token[] xformOpOrder = ["xformOp:transform"]',
    ]


def _mesh(panel: Panel, file: str) -> list[str]:
    points, places = panel.outline("usd")
    path = f"/rig/{panel.name}_surface"
    st = [(a, 1 - b) for a, b in places.tolist()]
    low, high = (tuple(of(points, axis=0).tolist()) for of in (np.min, np.max))
    mesh = [
        f"float3[] extent = [{low!r}, {high!r}]",
        "int[] faceVertexCounts = [4]",
        "int[] faceVertexIndices = [0, 1, 2, 3]",
        f"point3f[] points = [{', '.join(map(repr, map(tuple, points.tolist())))}]",
        f"texCoord2f[] primvars:st = [{', '.join(map(repr, st))}] (",
        '    interpolation = "vertex"',
        ")",
        'uniform token subdivisionScheme = "none"',
        'uniform token light:materialSyncMode = "materialGlowTintsLight"',
        "float inputs:intensity = 1.0",
        f"rel material:binding = <{path}>",
    ]
    schemas = '"MaterialBindingAPI", "MeshLightAPI"'
    material = fill_template(_MATERIAL, path=path, file=asset(file))
    return [
        prim("Mesh", panel.name, mesh, schemas),
        prim("Material", f"{panel.name}_surface", [material]),
    ]
