"""three.js: the JSON that its ObjectLoader reads."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights.environment.envmap import EnvMap
from envlights.environment.reading import AnyMap
from envlights.export.files import AnyPath, json_text, save_scene
from envlights.export.formats import three_cards
from envlights.export.formats.three_things import colour_of, image_of, texture_of, thing_of
from envlights.export.scene import Exportable, Scene, scene_of
from envlights.export.targets import AXES
from envlights.kernels.ambient import turned_ambient

#: Distance of lights from the origin, for their shadow cameras; it does not change their light.
_DISTANCE = 10.0
#: Constants of three.js: EquirectangularReflectionMapping, and wrapping: repeated along a row,
#: clamped at the poles.
_TEXTURE = {"mapping": 303, "wrap": [1000, 1001]}
#: Columns of the largest map: as text, it has 20 MB; one of 4096 columns has 16 times as many.
_COLUMNS = 1024
_VERSION = {"version": 4.7, "type": "Object", "generator": "envlights"}


def three(rig: Exportable, environment: AnyMap | None = None) -> dict[str, Any]:
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
    rig : Rig, Lights or Cards
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
    root = thing_of("Scene", "envlights", children=children, userData={"units": scene.statement})
    written: dict[str, Any] = {"metadata": _VERSION}
    if scene.panels:
        written |= three_cards.tables(scene.panels)
        children += three_cards.things(scene.panels)
    if scene.has_map and scene.environment is not None:
        image, texture = _map(_at_most(scene.environment))
        for name, each in {"images": image, "textures": texture}.items():
            written[name] = [*written.get(name, []), each]
        root |= {"environment": texture["uuid"], "background": texture["uuid"]}
    elif scene.ambient is not None or scene.environment is not None:
        children.append(_ambient(scene))
    return {**written, "object": root}


def save_three(rig: Exportable, path: AnyPath, environment: AnyMap | None = None) -> None:
    """Write `three` at `path`."""
    save_scene(path, json_text(three(rig, environment), indent=None))


def _light(
    j: int, direction: NDArray[np.float64], irradiance: NDArray[np.float64], radius: float
) -> dict[str, Any]:
    place = _DISTANCE * AXES["three"].to_target(direction)
    matrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, *place.tolist(), 1]
    size = {"angular_radius": float(radius)}
    shone = colour_of(irradiance)
    return thing_of("DirectionalLight", f"light_{j}", matrix=matrix, userData=size, **shone)


def _ambient(scene: Scene) -> dict[str, Any]:
    """Light of three.js with the irradiance of an ambient term."""
    if scene.term.ndim == 2:
        # three.js has our order, signs and lengths of harmonics.
        harmonics = turned_ambient(scene.term, AXES["three"].matrix)
        # Releases up to 181 have no default for the intensity of a file.
        return thing_of("LightProbe", "ambient", sh=harmonics.ravel().tolist(), intensity=1.0)
    lit = colour_of(np.pi * scene.term)
    if scene.floor:
        return thing_of("HemisphereLight", "ambient", groundColor=0, **lit)
    return thing_of("AmbientLight", "ambient", **lit)


def _at_most(env: EnvMap) -> EnvMap:
    return env if env.width <= _COLUMNS else env.resized(_COLUMNS)


def _map(env: EnvMap) -> tuple[dict[str, Any], dict[str, Any]]:
    """Image and texture of the environment."""
    image = image_of("image", env.radiance)
    return image, texture_of("texture", "environment", image, **_TEXTURE)
