"""Game engines: JSON in the axes of the engine, with the angles that its editor shows.

An engine is described by its axes for right, up and forward: "+x", "+y" and "+z" for Unity. The
engine's forward is our +z, the centre of the map; its left is our +x. These axes also determine if
it is left-handed.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import describe
from envlights._native import EnvLightsError
from envlights.environment.reading import AnyMap
from envlights.export.files import AnyPath, check_link, json_text
from envlights.export.scene import Exportable, Scene, scene_of
from envlights.export.targets import AXES
from envlights.export.textures import Beside, save_beside
from envlights.frames import Axes, Matrix
from envlights.kernels.ambient import turned_ambient

_FORMAT, _VERSION = "envlights engine", 1
#: Target with the units and textures of any other engine.
_MODEL = "unity"
_UNITS = (
    "irradiance: linear Rec.709 RGB at normal incidence, color times intensity; ambient: radiance;"
    " angles: degrees"
)


def engine(
    rig: Exportable,
    environment: AnyMap | None = None,
    *,
    right: str,
    up: str,
    forward: str,
    texture: str = "ambient.exr",
) -> dict[str, Any]:
    """A rig as numbers, lists and strings, in the axes of an engine.

    Parameters
    ----------
    rig : Rig or Lights
    environment : EnvMap or array_like, optional
        Map that replaces the ambient term.
    right, up, forward : str
        Axes of the engine: "+x", "-x", "+y", "-y", "+z" or "-z", each letter once.
    texture : str
        Name of the map's file, if there is a map.

    Returns
    -------
    dict
        ``lights``: `to_light`, the unit vector towards the light; `forward`, the one in which its
        light travels; `irradiance`; its largest channel as `intensity`, and irradiance over
        intensity as `color`, both linear; `angular_diameter` in degrees. ``ambient``: a radiance,
        nine `harmonics` of it in the engine's axes (`kernels.harmonic_radiance`), or the file of a
        `map`.

    Examples
    --------
    An engine that is right-handed and looks along -z, as OpenGL does:

    >>> import envlights as el
    >>> lamp = el.Lights([[0, 0, 1]], [[3, 2, 1]])
    >>> scene = el.export.engine(lamp, right="+x", up="+y", forward="-z")
    >>> scene["lights"][0]["to_light"], scene["handedness"]
    ([0.0, 0.0, -1.0], 'right')
    """
    scene = scene_of(rig, environment, target=_MODEL)
    return _engine(scene, Beside(texture), right, up, forward)


def unity(
    rig: Exportable, environment: AnyMap | None = None, *, texture: str = "ambient.exr"
) -> dict[str, Any]:
    """`engine` for Unity: left-handed, +x right, +y up, +z forward; our x is mirrored.

    Unity's importers of glTF do the same, so the lights fit imported geometry. Each light has
    `euler_angles`, the rotation in the inspector of a directional light, and `lux`, its intensity
    in the high definition pipeline. The other pipelines do not divide by pi for a white surface:
    use `intensity_without_pi` for them. For a panorama, `skybox_rotation` is the
    Rotation of the material Skybox/Panoramic.

    Examples
    --------
    >>> import envlights as el
    >>> noon = el.export.unity(el.Lights([[0, 1, 0]], [[3, 2, 1]]))
    >>> noon["lights"][0]["euler_angles"]
    [90.0, 0.0, 0.0]
    """
    return _unity(scene_of(rig, environment, target="unity"), Beside(texture))


def _unity(parts: Scene, names: Beside) -> dict[str, Any]:
    scene = _engine(parts, names, "+x", "+y", "+z")
    for light in scene["lights"]:
        x, y, z = light["forward"]
        # Unity rotates about z, then x, then y; the light shines along its own +z.
        pitch, yaw = np.arcsin(np.clip(-y, -1, 1)), np.arctan2(x, z)
        light["euler_angles"] = (np.rad2deg([pitch, yaw, 0.0]) + 0.0).tolist()
        light["lux"] = light["intensity"]
        light["intensity_without_pi"] = light["intensity"] / np.pi
    scene["skybox_rotation"] = _about_y(AXES["unity"].turn_of_map())
    return scene


def unreal(
    rig: Exportable, environment: AnyMap | None = None, *, texture: str = "ambient.exr"
) -> dict[str, Any]:
    """`engine` for Unreal: left-handed, +x forward, +y right, +z up.

    Each light has `rotator`, pitch, yaw and roll as the editor shows them, `lux`, and
    `angular_diameter`, which is its Source Angle. Unreal does not document the direction of
    a panorama's centre: rotate its cubemap until it fits.

    Examples
    --------
    >>> import envlights as el
    >>> noon = el.export.unreal(el.Lights([[0, 1, 0]], [[3, 2, 1]]))
    >>> noon["lights"][0]["rotator"]
    {'pitch': -90.0, 'yaw': 0.0, 'roll': 0.0}
    """
    return _unreal(scene_of(rig, environment, target="unreal"), Beside(texture))


def _unreal(parts: Scene, names: Beside) -> dict[str, Any]:
    scene = _engine(parts, names, "+y", "+z", "+x")
    for light in scene["lights"]:
        x, y, z = light["forward"]
        # The light shines along its own +x; pitch is up, yaw is to the right.
        pitch, yaw = np.rad2deg([np.arcsin(np.clip(z, -1, 1)), np.arctan2(y, x)]) + 0.0
        light["rotator"] = {"pitch": float(pitch), "yaw": float(yaw), "roll": 0.0}
        light["lux"] = light["intensity"]
    return scene


def save_engine(
    rig: Exportable,
    path: AnyPath,
    environment: AnyMap | None = None,
    *,
    right: str,
    up: str,
    forward: str,
    texture: str | None = None,
) -> None:
    """Write `engine` as JSON; a map goes beside it, unless it is the file `texture`."""
    scene = scene_of(rig, environment, target=_MODEL)

    def content(scene: Scene, names: Beside) -> str:
        return json_text(_engine(scene, names, right, up, forward))

    save_beside(path, scene, _MODEL, content, texture)


def save_unity(
    rig: Exportable, path: AnyPath, environment: AnyMap | None = None, *, texture: str | None = None
) -> None:
    """Write `unity` as JSON; a map goes beside it, unless it is the file `texture`."""
    scene = scene_of(rig, environment, target="unity")
    save_beside(path, scene, "unity", lambda *parts: json_text(_unity(*parts)), texture)


def save_unreal(
    rig: Exportable, path: AnyPath, environment: AnyMap | None = None, *, texture: str | None = None
) -> None:
    """Write `unreal` as JSON; a map goes beside it, unless it is the file `texture`."""
    scene = scene_of(rig, environment, target="unreal")
    save_beside(path, scene, "unreal", lambda *parts: json_text(_unreal(*parts)), texture)


def _engine(scene: Scene, names: Beside, right: str, up: str, forward: str) -> dict[str, Any]:
    axes = Axes(matrix_of(right, up, forward))
    return {
        "format": _FORMAT,
        "version": _VERSION,
        "axes": {"right": right, "up": up, "forward": forward},
        "handedness": axes.hand,
        "matrix": [list(row) for row in axes.matrix],
        "units": f"{_UNITS}; {scene.statement}",
        "lights": _lights(scene, axes),
        **_ambient(scene, axes, names.map),
    }


def matrix_of(right: str, up: str, forward: str) -> Matrix:
    """Rows: each axis of an engine in our frame, where right is -x, up is +y and forward is +z."""
    columns = np.zeros((3, 3), int)
    ours = {"right": (right, 0, -1), "up": (up, 1, 1), "forward": (forward, 2, 1)}
    for name, (axis, column, sign) in ours.items():
        if not isinstance(axis, str) or axis not in ("+x", "-x", "+y", "-y", "+z", "-z"):
            raise EnvLightsError(
                f"{name} must be an axis, such as '+x' or '-z'; got {describe(axis)}"
            )
        columns["xyz".index(axis[1]), column] = sign if axis[0] == "+" else -sign
    if (np.abs(columns).sum(axis=1) != 1).any():
        raise EnvLightsError(
            f"right, up and forward must be three different axes; got {right}, {up} and {forward}"
        )
    x, y, z = (tuple(row) for row in columns.tolist())
    return (x, y, z)


def _lights(scene: Scene, axes: Axes) -> list[dict[str, Any]]:
    lights = scene.lights
    rows = zip(
        axes.to_target(lights.direction), lights.irradiance, lights.angular_radius, strict=True
    )
    return [_light(*row) for row in rows]


def _light(
    towards: NDArray[np.float64], irradiance: NDArray[np.float64], radius: float
) -> dict[str, Any]:
    most = float(irradiance.max())
    return {
        "to_light": towards.tolist(),
        "forward": (0.0 - towards).tolist(),
        "irradiance": irradiance.tolist(),
        "color": (irradiance / most if most > 0 else irradiance).tolist(),
        "intensity": most,
        "angular_diameter": float(2 * np.rad2deg(radius)),
    }


def _ambient(scene: Scene, axes: Axes, texture: str) -> dict[str, Any]:
    """Surroundings of the lights; empty if there are none."""
    if scene.ambient is not None:
        return {"ambient": scene.ambient.tolist()}
    if scene.environment is None:
        return {}
    check_link(texture, "a reader of JSON")
    if scene.term.ndim < 2:
        return {"map": texture}
    return {"harmonics": turned_ambient(scene.term, axes.matrix).tolist(), "map": texture}


def _about_y(turn: NDArray[np.float64]) -> float:
    """Degrees of a turn about +y, as Unity's Skybox/Panoramic counts them."""
    return float(np.rad2deg(np.arctan2(turn[2, 0], turn[0, 0])) % 360)
