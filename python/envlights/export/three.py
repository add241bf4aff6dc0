"""three.js: the JSON that its ObjectLoader reads."""

from __future__ import annotations

import colorsys
import json
import os
import uuid
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._srgb import encode_srgb
from envlights.ambient import turned_ambient
from envlights.envmap import EnvMap
from envlights.export.axes import AXES
from envlights.export.files import save_scene
from envlights.export.scene import scene_of
from envlights.lights import Lights
from envlights.rig import Rig

#: Distance of lights from the origin, for their shadow cameras; it does not change their light.
_DISTANCE = 10.0
#: Constants of three.js: EquirectangularReflectionMapping, FloatType, RGBAFormat, LinearFilter,
#: and wrapping: repeated along a row, clamped at the poles.
_TEXTURE = {
    "mapping": 303,
    "type": 1015,
    "format": 1023,
    "minFilter": 1006,
    "magFilter": 1006,
    "wrap": [1000, 1001],
    "colorSpace": "srgb-linear",
    "flipY": True,
    "generateMipmaps": False,
}
#: Columns of the largest map: as text, it has 20 MB; one of 4096 columns has 16 times as many.
_COLUMNS = 1024
_VERSION = {"version": 4.7, "type": "Object", "generator": "envlights"}


def three(rig: Rig | Lights, environment: EnvMap | ArrayLike | None = None) -> dict[str, Any]:
    """A scene of lights, for ``new THREE.ObjectLoader().parse(json)``.

    Axes: our +x, +y, +z are -z, +y, +x in three.js, so the lights fit the panorama as an
    equirectangular background without rotation. A glTF of the same rig has other axes: rotate one
    of them.

    Units: colour times intensity of a directional light is irradiance at normal incidence.
    `AmbientLight` and `HemisphereLight` have irradiance too, pi times our radiance; `LightProbe`
    and environments have radiance. Since release 155 this needs no setting. After
    `EnvMap.calibrated` the numbers are lux and cd/m². The renderer's ``toneMappingExposure`` sets
    the exposure.

    Kept: directions, irradiances; a constant ambient term as `AmbientLight`, harmonics as
    `LightProbe`, an ambient term over a floor as `HemisphereLight`; a map as the scene's
    environment and background. Lost: sizes; `userData.angular_radius` has them, in radians.

    Parameters
    ----------
    rig : Rig or Lights
    environment : EnvMap or array_like, optional
        Map that replaces the ambient term. It is written as text, with up to 1024 columns.

    Returns
    -------
    dict
        For `json.dump`.

    Examples
    --------
    >>> import envlights as el
    >>> scene = el.export.three(el.Lights([[0, 0, 1]], [[3, 3, 3]]))
    >>> light = scene["object"]["children"][0]
    >>> light["type"], light["intensity"], light["matrix"][12:15]
    ('DirectionalLight', 3.0, [10.0, 0.0, 0.0])
    """
    scene = scene_of(rig, environment, target="three")
    lights = scene.lights
    rows = zip(lights.direction, lights.irradiance, lights.angular_radius, strict=True)
    children = [_light(j, *row) for j, row in enumerate(rows)]
    root = _thing("Scene", "envlights", children=children, userData={"units": scene.statement})
    written: dict[str, Any] = {"metadata": _VERSION}
    if environment is not None and scene.environment is not None:
        image, texture = _map(_at_most(scene.environment))
        written |= {"images": [image], "textures": [texture]}
        root |= {"environment": texture["uuid"], "background": texture["uuid"]}
    elif scene.ambient is not None or scene.environment is not None:
        children.append(_ambient(rig))
    return {**written, "object": root}


def save_three(
    rig: Rig | Lights,
    path: str | os.PathLike[str],
    environment: EnvMap | ArrayLike | None = None,
) -> None:
    """Write `three` at `path`."""
    save_scene(path, json.dumps(three(rig, environment), allow_nan=False) + "\n")


def _light(
    j: int, direction: NDArray[np.float64], irradiance: NDArray[np.float64], radius: float
) -> dict[str, Any]:
    place = _DISTANCE * AXES["three"].to_target(direction)
    matrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, *place.tolist(), 1]
    size = {"angular_radius": float(radius)}
    shone = _colour(irradiance)
    return _thing("DirectionalLight", f"light_{j}", matrix=matrix, userData=size, **shone)


def _ambient(rig: Any) -> dict[str, Any]:
    """Light of three.js with the irradiance of an ambient term."""
    if rig.ambient.ndim == 2:
        # three.js has our order, signs and lengths of harmonics.
        harmonics = turned_ambient(rig.ambient, AXES["three"].matrix)
        return _thing("LightProbe", "ambient", sh=harmonics.ravel().tolist())
    lit = _colour(np.pi * rig.ambient)
    if rig.floor:
        return _thing("HemisphereLight", "ambient", groundColor=0, **lit)
    return _thing("AmbientLight", "ambient", **lit)


def _colour(values: NDArray[np.float64]) -> dict[str, Any]:
    """Colour and intensity with the product `values`.

    A hexadecimal colour has only 8 bits, so the colour is given as hue, saturation and lightness.
    three.js decodes it from sRGB.
    """
    most = float(values.max())
    codes = encode_srgb(values / (most or 1.0))
    hue, lightness, saturation = colorsys.rgb_to_hls(*codes.tolist())
    colour = f"hsl({360 * hue:.12f},{100 * saturation:.12f}%,{100 * lightness:.12f}%)"
    return {"color": colour, "intensity": most}


def _at_most(env: EnvMap) -> EnvMap:
    return env if env.width <= _COLUMNS else env.resized(_COLUMNS)


def _map(env: EnvMap) -> tuple[dict[str, Any], dict[str, Any]]:
    """Image and texture in the form of `DataTexture`."""
    opaque = np.ones((env.height, env.width, 1), np.float32)
    samples = np.concatenate([env.radiance, opaque], axis=2)
    data = [float(f"{sample:.7g}") for sample in samples.ravel().tolist()]
    content = {"data": data, "width": env.width, "height": env.height, "type": "Float32Array"}
    image = {"uuid": _uuid("image"), "url": content}
    texture = {"uuid": _uuid("texture"), "name": "environment", "image": image["uuid"], **_TEXTURE}
    return image, texture


def _thing(kind: str, name: str, **parts: Any) -> dict[str, Any]:
    return {"uuid": _uuid(name), "type": kind, "name": name, **parts}


def _uuid(name: str) -> str:
    """Identifier that depends on the name alone, so that files can be compared."""
    return str(uuid.uuid5(uuid.NAMESPACE_URL, f"envlights/{name}"))
