"""Table of the targets: suffixes, writer, and the parts of a rig that each can show."""

from __future__ import annotations

from envlights.export.blender import save_blender
from envlights.export.csv import save_csv
from envlights.export.engine import save_unity, save_unreal
from envlights.export.gltf import save_gltf
from envlights.export.godot import DIRECTIONAL_LIGHTS, save_godot
from envlights.export.mitsuba import TEXTURE as MITSUBA_TEXTURE
from envlights.export.mitsuba import save_mitsuba
from envlights.export.mujoco import LAMPS, save_mujoco
from envlights.export.own_json import save_json
from envlights.export.panels import CROPS
from envlights.export.pbrt import TEXTURE as PBRT_TEXTURE
from envlights.export.pbrt import save_pbrt
from envlights.export.radiance import TEXTURE as RADIANCE_TEXTURE
from envlights.export.radiance import save_radiance
from envlights.export.scene import CASTERS, PANELS
from envlights.export.three import save_three
from envlights.export.units import UNITS
from envlights.export.usd import save_usd
from envlights.rigs.capabilities import Capabilities
from envlights.rigs.targets import PANORAMA, Target, register

_TARGETS = (
    Target(
        "json",
        "envlights itself",
        (".json",),
        save_json,
        Capabilities(environment=False, remark="lossless"),
    ),
    Target(
        "csv",
        "a table of numbers",
        (".csv",),
        save_csv,
        Capabilities(environment=False, remark="without report and notes"),
    ),
    Target(
        "gltf",
        "glTF 2.0",
        (".gltf",),
        save_gltf,
        Capabilities(
            sizes="none",
            harmonics="none",
            remark="set ambient light or map of `extras` by hand; sizes are there too",
            source="Khronos, KHR_lights_punctual: a directional light has no size",
        ),
        PANORAMA,
    ),
    Target(
        "three",
        "three.js",
        (".three.json",),
        save_three,
        Capabilities(
            sizes="none",
            remark="sizes are in `userData`",
            source="three.js, src/lights: DirectionalLight, HemisphereLight, LightProbe",
        ),
    ),
    Target(
        "usd",
        "OpenUSD",
        (".usda", ".usdc", ".usd"),
        save_usd,
        Capabilities(
            harmonics="map",
            remark="Storm, the viewer of usdview, ignores `angle`",
            source="OpenUSD, UsdLux: DistantLight, inputs:angle",
        ),
        PANORAMA,
    ),
    Target(
        "mitsuba",
        "Mitsuba 3",
        (".xml",),
        save_mitsuba,
        Capabilities(
            harmonics="map", remark="sizes are in a map", source="Mitsuba 3, plugins: envmap"
        ),
        MITSUBA_TEXTURE,
    ),
    Target(
        "blender",
        "Blender, a script",
        (".py",),
        save_blender,
        Capabilities(
            harmonics="map",
            remark="for Cycles; a map has no shadows in EEVEE",
            source="Blender manual, Cycles: Sun Light, Angle",
        ),
        PANORAMA,
    ),
    Target(
        "radiance",
        "Radiance",
        (".rad",),
        save_radiance,
        Capabilities(harmonics="map", source="Radiance, The RADIANCE Lighting Simulation: source"),
        RADIANCE_TEXTURE,
    ),
    Target(
        "pbrt",
        "pbrt-v4",
        (".pbrt",),
        save_pbrt,
        Capabilities(
            harmonics="map",
            remark="sizes below 0.7 degrees are points, others are in a map",
            source="pbrt-v4 file format: infinite and distant lights",
        ),
        PBRT_TEXTURE,
    ),
    Target(
        "mujoco",
        "MuJoCo",
        (".mujoco.xml",),
        save_mujoco,
        Capabilities(
            sizes="none",
            harmonics="none",
            floor=False,
            lights=LAMPS,
            casters=CASTERS,
            remark="of a map, the mean alone; for the classic renderer",
            source="MuJoCo 3.12, src/render/classic/render_gl3.c: eight lights of OpenGL",
        ),
    ),
    Target(
        "godot",
        "Godot 4",
        (".tscn",),
        save_godot,
        Capabilities(
            sizes="soften",
            harmonics="map",
            lights=DIRECTIONAL_LIGHTS,
            casters=CASTERS,
            remark="sizes above 1.5 degrees are points; a map needs Forward+ or Mobile",
            source="Godot 4, scene_forward_lights_inc.glsl, light_storage.cpp",
        ),
        PANORAMA,
    ),
    Target(
        "unity",
        "Unity",
        (".unity.json",),
        save_unity,
        Capabilities(
            sizes="soften",
            remark="other pipelines than HDRP use `intensity_without_pi`",
            source="Unity manual, HDRP: Light, Angular Diameter",
        ),
        PANORAMA,
    ),
    Target(
        "unreal",
        "Unreal Engine",
        (".unreal.json",),
        save_unreal,
        Capabilities(
            sizes="soften",
            harmonics="map",
            remark="set the rotation of the map by hand",
            source="Unreal Engine documentation: Directional Light, Source Angle",
        ),
        PANORAMA,
    ),
)


def _complete(target: Target) -> Target:
    """`target` with its units and cards; our own files keep the units of the map."""
    if target.name not in UNITS:
        return target
    has_cards = target.name in PANELS
    shows = target.shows._replace(units=UNITS[target.name].in_short(), cards=has_cards)
    return target._replace(shows=shows, crop=CROPS.get(target.name))


#: Targets in the order of the help.
TARGETS = tuple(map(_complete, _TARGETS))

register(TARGETS)

#: Suffixes of all targets.
SUFFIXES = tuple(suffix for target in TARGETS for suffix in target.suffixes)
