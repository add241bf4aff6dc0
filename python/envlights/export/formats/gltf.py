"""glTF 2.0: directional lights and points of KHR_lights_punctual."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights.environment.reading import AnyMap
from envlights.export.files import AnyPath, check_link, json_text
from envlights.export.formats import gltf_cards
from envlights.export.panels import Panel
from envlights.export.scene import Exportable, Scene, scene_of
from envlights.export.targets import AXES
from envlights.export.textures import Beside, save_beside

_EXTENSION = "KHR_lights_punctual"
#: Direction in which a light of glTF shines if its node has no rotation.
SHINES = np.array([0.0, 0.0, -1.0])
_NOTE = (
    "glTF has no ambient light: set one of this radiance (irradiance: times pi), or an environment"
    " map in its place. Nine rows are real spherical harmonics up to order 2, multiples of"
    " 1, y, z, x, xy, yz, 3zz-1, xz, xx-yy."
)

_MAP_NOTE = (
    "glTF has no environment map: load the file of `environment`, whose name is relative to this"
    " one. It is an equirectangular map of radiance; its centre is along +z, its left quarter along"
    " +x."
)


def gltf(
    rig: Exportable, environment: AnyMap | None = None, *, texture: str = "ambient.exr"
) -> dict[str, Any]:
    """A glTF 2.0 asset: a node for each light.

    Axes: +y up and front +z, as in envlights. A directional light shines along the local -z of its
    node.

    Units: `intensity` times `color` is irradiance at normal incidence, in lux after
    `EnvMap.calibrated`; the numbers of other maps have the scale of the map. The extras of `asset`
    say which. Blender's importer divides by 683 lm/W unless its lighting mode is "Unitless";
    three.js uses the numbers unchanged.

    Kept: directions, irradiances. Lost: glTF has neither sizes nor an ambient light. The `extras`
    hold them for programs that read them: `angular_radius` in radians, `ambient` in radiance, or
    the name of a map as `environment`.

    Parameters
    ----------
    rig : Rig, Lights or Cards
    environment : EnvMap or array_like, optional
        Map that replaces the ambient term.
    texture : str
        Name of the map's file, if there is a map; `save_gltf` writes it.

    Returns
    -------
    dict
        For `json.dump`.

    Examples
    --------
    >>> import numpy as np
    >>> import envlights as el
    >>> asset = el.export.gltf(el.Lights([[0, 1, 0]], [[4, 2, 1]]))
    >>> np.round(asset["nodes"][0]["rotation"], 3)  # shines down
    array([-0.707,  0.   ,  0.   ,  0.707])
    >>> light = asset["extensions"]["KHR_lights_punctual"]["lights"][0]
    >>> light["color"], light["intensity"]
    ([1.0, 0.5, 0.25], 4.0)
    """
    return _asset(scene_of(rig, environment, target="gltf"), Beside(texture))


def save_gltf(
    rig: Exportable, path: AnyPath, environment: AnyMap | None = None, *, texture: str | None = None
) -> None:
    """Write `gltf` at `path`; a map goes beside it, unless it is the file `texture`."""
    scene = scene_of(rig, environment, target="gltf")
    if not scene.has_map:
        scene = scene._replace(environment=None)  # harmonics are written as numbers
    save_beside(path, scene, "gltf", lambda *parts: json_text(_asset(*parts)), texture)


def _asset(written: Scene, names: Beside) -> dict[str, Any]:
    lights, flat = written.lights, tuple(each for each in written.panels if each.shape != "sphere")
    spheres = [each for each in written.panels if each.shape == "sphere"]
    towards = AXES["gltf"].to_target(lights.direction)
    scene: dict[str, Any] = {"name": "envlights"}
    extras = {"units": written.statement}
    about = {"version": "2.0", "generator": "envlights", "extras": extras}
    asset: dict[str, Any] = {"asset": about, "scene": 0}
    asset["scenes"] = [scene]
    # An empty list is not valid.
    rows = zip(lights.irradiance, lights.angular_radius, strict=True)
    found = [_light(j, *row) for j, row in enumerate(rows)] + [_point(each) for each in spheres]
    if found:
        turns = [{"rotation": rotation_between(SHINES, -each).tolist()} for each in towards]
        places = [{"translation": each.axes("gltf")[3].tolist()} for each in spheres]
        scene["nodes"] = list(range(len(found)))
        asset["nodes"] = [
            {"name": light["name"], **place, "extensions": {_EXTENSION: {"light": j}}}
            for j, (light, place) in enumerate(zip(found, turns + places, strict=True))
        ]
        asset["extensions"] = {_EXTENSION: {"lights": found}}
        asset["extensionsUsed"] = [_EXTENSION]
    if flat:
        gltf_cards.add(asset, flat)
    if written.has_map:
        check_link(names.map, "a reader of JSON")
        scene["extras"] = {"environment": names.map, "note": _MAP_NOTE}
    elif written.term.any():
        term = {"ambient": written.term.tolist(), "floor": written.floor}
        scene["extras"] = {**term, "note": _NOTE}
    return asset


def _light(j: int, irradiance: NDArray[np.float64], radius: float) -> dict[str, Any]:
    size = {"extras": {"angular_radius": float(radius)}}
    return {"name": f"light_{j}", "type": "directional", **_strength(irradiance), **size}


def _point(panel: Panel) -> dict[str, Any]:
    """A point of the intensity of a sphere."""
    size = {"extras": {"radius": panel.radius}}
    return {"name": panel.name, "type": "point", **_strength(panel.intensity), **size}


def _strength(values: NDArray[np.float64]) -> dict[str, Any]:
    """Colour between 0 and 1, as glTF requires, and intensity."""
    most = float(values.max())
    return {"color": (values / (most or 1.0)).tolist(), "intensity": most}


def rotation_between(start: NDArray[np.float64], end: NDArray[np.float64]) -> NDArray[np.float64]:
    """Shortest rotation from one unit vector to another, as a quaternion x, y, z, w."""
    half = start + end
    length = np.linalg.norm(half)
    # For opposite vectors, rotate by 180 degrees about any perpendicular axis.
    if length < 1e-12:
        return np.array([0.0, 1.0, 0.0, 0.0])
    half = half / length
    return np.append(np.cross(start, half), start @ half) + 0.0
