"""Godot 4: a scene of directional lights and an environment, as text."""

from __future__ import annotations

import json

import numpy as np
from numpy.typing import NDArray

from envlights._common.srgb import encode_srgb
from envlights.environment.reading import AnyMap
from envlights.export.files import CONTROLS, AnyPath, check_link
from envlights.export.scene import Exportable, Scene, at_most, scene_of
from envlights.export.targets import AXES, CASTERS, target_named
from envlights.export.textures import Beside, save_beside

#: Directional lights that Godot draws.
_LIGHTS = target_named("godot").shows.lights
#: Largest angular size that is written, in degrees. Godot adds 1 minus its cosine to the cosine of
#: each surface, which adds 0.07 % to the flux here, and 27 % for a lamp of 30 degrees.
_WIDEST = 1.5

#: Constants of Godot's class Environment: background of one colour or of a sky, and ambient light
#: of one colour or from the sky.
_COLOUR_BACKGROUND, _SKY_BACKGROUND, _COLOUR_LIGHT, _SKY_LIGHT = 1, 2, 2, 3


def godot(rig: Exportable, environment: AnyMap | None = None, texture: str = "ambient.exr") -> str:
    """A scene for Godot 4, with the suffix ``.tscn``, of lights and a `WorldEnvironment`.

    Put it and its map into a project, and add it to your scene as a child. A scene may have only
    one `WorldEnvironment`.

    Axes: the same as ours. So the lights fit the panorama as a sky without rotation, and objects
    from glTF. A camera that is not rotated looks along -z, away from the centre of the map.

    Units: color times energy is irradiance at normal incidence over pi, which is the radiance of
    a white surface; the ambient light is radiance. `tonemap_exposure` of the environment sets the
    exposure.

    Kept: directions, irradiances, sizes of up to 1.5 degrees, which soften shadows in the renderer
    Forward+; a constant ambient term as a color; harmonics, an ambient term over a floor and a map
    as a panorama sky. The three brightest lights cast shadows. Lost: larger sizes; negative
    harmonics. Beyond eight lights, the others become part of the ambient term.

    Parameters
    ----------
    rig : Rig or Lights
    environment : EnvMap or array_like, optional
        Map that replaces the ambient term.
    texture : str
        Name of the map's file beside the scene, if there is a map; `save_godot` writes it.

    Notes
    -----
    A larger angular size would brighten surfaces that face away from the light. The renderer
    Compatibility adds lights with shadows to the others as sRGB codes, which is too dark or too
    bright: disable their shadows there. Source: `light_storage.cpp`,
    `scene_forward_lights_inc.glsl` and `gles3/shaders/scene.glsl` of Godot 4.

    Examples
    --------
    >>> import envlights as el
    >>> scene = el.export.godot(el.Lights([[0, 0, 1]], [[3.141592653589793, 0, 0]]))
    >>> [line for line in scene.splitlines() if line.startswith("light_")]
    ['light_color = Color(1, 0, 0, 1)', 'light_energy = 1.0']
    """
    return _text(at_most(scene_of(rig, environment, target="godot"), _LIGHTS), Beside(texture))


def save_godot(
    rig: Exportable, path: AnyPath, environment: AnyMap | None = None, *, texture: str | None = None
) -> None:
    """Write `godot` at `path`; a map goes beside it, unless it is the file `texture`.

    With more lights than Godot draws, the map holds the others, so it is never that file.
    """
    every = scene_of(rig, environment, target="godot")
    scene = at_most(every, _LIGHTS)
    is_whole = len(scene.lights) == len(every.lights)
    save_beside(path, scene, "godot", _text, texture if is_whole else None)


def _text(scene: Scene, names: Beside) -> str:
    parts = ["[gd_scene format=3]", *_environment(scene, names.map)]
    units = json.dumps(scene.statement, ensure_ascii=False)
    parts.append(f'[node name="envlights" type="Node3D"]\nmetadata/units = {units}')
    parts.append(
        '[node name="environment" type="WorldEnvironment" parent="."]\n'
        'environment = SubResource("environment")'
    )
    lights = scene.lights
    towards = AXES["godot"].to_target(lights.direction)
    rows = zip(towards, lights.irradiance, lights.angular_radius, strict=True)
    parts += [_light(j, *row) for j, row in enumerate(rows)]
    return "\n\n".join(parts) + "\n"


def _environment(scene: Scene, texture: str) -> list[str]:
    """Resources of the environment: a sky of the map, or one colour."""
    if scene.environment is None:
        return [_colour_environment(scene.constant)]
    check_link(texture, "Godot", ("\\", *CONTROLS))
    name = json.dumps(texture, ensure_ascii=False)
    return [
        f'[ext_resource type="Texture2D" path={name} id="map"]',
        '[sub_resource type="PanoramaSkyMaterial" id="material"]\npanorama = ExtResource("map")',
        '[sub_resource type="Sky" id="sky"]\nsky_material = SubResource("material")',
        '[sub_resource type="Environment" id="environment"]\n'
        f"background_mode = {_SKY_BACKGROUND}\n"
        'sky = SubResource("sky")\n'
        f"ambient_light_source = {_SKY_LIGHT}",
    ]


def _colour_environment(radiance: NDArray[np.float64]) -> str:
    colour, energy = _colour(radiance)
    return (
        '[sub_resource type="Environment" id="environment"]\n'
        f"background_mode = {_COLOUR_BACKGROUND}\n"
        f"background_color = {colour}\n"
        f"background_energy_multiplier = {energy}\n"
        f"ambient_light_source = {_COLOUR_LIGHT}\n"
        f"ambient_light_color = {colour}\n"
        f"ambient_light_energy = {energy}"
    )


def _light(
    j: int, towards: NDArray[np.float64], irradiance: NDArray[np.float64], radius: float
) -> str:
    colour, energy = _colour(irradiance / np.pi)
    lines = [
        f'[node name="light_{j}" type="DirectionalLight3D" parent="."]',
        f"transform = Transform3D({_basis(towards)}, 0, 0, 0)",
        f"light_color = {colour}",
        f"light_energy = {energy}",
    ]
    degrees = float(2 * np.rad2deg(radius))
    if 0 < degrees <= _WIDEST:
        lines.append(f"light_angular_distance = {degrees}")
    if j < CASTERS:
        lines.append("shadow_enabled = true")
    return "\n".join(lines)


def _basis(towards: NDArray[np.float64]) -> str:
    """Rows of a rotation that turns +z towards the light; it shines along its own -z."""
    across = np.cross(np.eye(3)[np.argmin(np.abs(towards))], towards)
    across /= np.linalg.norm(across)
    columns = [across, np.cross(towards, across), towards]
    return ", ".join(map(repr, (np.stack(columns, axis=1) + 0.0).ravel().tolist()))


def _colour(values: NDArray[np.float64]) -> tuple[str, float]:
    """Colour in sRGB codes, and energy; the product of energy and linear colour is `values`."""
    most = float(values.max())
    # Godot has colours in 32 bits.
    codes = ", ".join(f"{code:.9g}" for code in encode_srgb(values / (most or 1.0)).tolist())
    return f"Color({codes}, 1)", most
