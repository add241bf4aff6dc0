"""Table of the targets: all that other places need to know about each, in one row.

A new target is a row here, a file in `formats/`, and its names in `__init__.py`. The help, the
tables of the documentation and the tests follow from its row.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from importlib import import_module
from inspect import signature
from typing import Any, NamedTuple

from envlights._common.check import check_choice, describe
from envlights._common.files import PICTURES, as_path
from envlights._native import EnvLightsError
from envlights.export.capabilities import Capabilities, common
from envlights.export.files import AnyPath
from envlights.export.units import TargetUnits
from envlights.frames import FRAMES, Axes

#: End of the name of a map that a program reads as a panorama in our axes.
PANORAMA = ".ambient.exr"
#: Lights that cast shadows, the brightest, in renderers that draw the scene again for each of them.
CASTERS = 3

#: Lumens per watt: the maximum of the photopic eye (SI), and that of white light in Radiance.
_SI, _RADIANCE = 683.0, 179.0
#: Units of our own files.
_OURS = TargetUnits("`scale` in the file")
#: Units of programs that clip their pixels.
_WITHOUT_UNITS = TargetUnits(
    "its lights have no units", "lux, times its scale", "cd/m2, times its scale"
)
#: Points and a constant.
_POINTS = Capabilities(sizes="none", harmonics="none", floor=False)


class Crops(NamedTuple):
    """Textures of the cards of a target: files beside the scene."""

    end: str
    """End of their names. Each target has its own, because not all show the map through a card."""

    has_discs: bool = False
    """True if discs have textures too; False if they have one colour."""

    def names(self, prefix: str, shapes: Iterable[str]) -> list[str]:
        """Names for cards of these shapes: ``scene.card_0.usd.exr`` beside ``scene.usda``.

        A card without a texture has an empty name; no sphere has one.
        """
        uniform = ("sphere",) if self.has_discs else ("disc", "sphere")
        return [
            "" if shape in uniform else f"{prefix}card_{j}{self.end}"
            for j, shape in enumerate(shapes)
        ]


class Target(NamedTuple):
    """Program or format that rigs can be exported to."""

    name: str
    """Name of its module and of its public function."""

    title: str
    """Full name."""

    suffixes: tuple[str, ...]
    """Suffixes in lower case, the usual one first."""

    units: TargetUnits
    """Units of the numbers in its files."""

    shows: Capabilities
    """Parts of a rig that it can show."""

    texture: str = ""
    """End of the name of the map beside a file; empty if there is no such map.

    For `PANORAMA` the writer accepts the keyword `texture`, the name of an existing map."""

    crop: Crops | None = None
    """Textures of cards beside a file; None if there are none."""

    file: str = ""
    """Name of its file in `export.formats`, if that is not its own name."""

    versions: str = ""
    """Versions of the program that read its files in a check; empty if none did."""

    @property
    def axes(self) -> Axes:
        """Its axes."""
        return FRAMES.get(self.name, FRAMES["envlights"])

    @property
    def options(self) -> tuple[str, ...]:
        """Names of further arguments of its writer, such as "up" of OpenUSD."""
        parameters = signature(function_named(f"save_{self.name}")).parameters.values()
        named = (each.name for each in parameters if each.kind is each.KEYWORD_ONLY)
        return tuple(name for name in named if name != "texture")

    def save(self, rig: Any, path: AnyPath, *environment: Any, **options: Any) -> None:
        """Write a rig or lights, with an `environment` map if the target shows one."""
        function_named(f"save_{self.name}")(rig, path, *environment, **options)

    def lines(self) -> list[str]:
        """Text for the help."""
        shown = f"shows {self.shows.in_short()}; units: {self.units.in_short()}"
        return [shown, *filter(None, [self.shows.remark])]


def function_named(name: str) -> Callable[..., Any]:
    """Public function of a target, such as "usd" or "save_usd"; its file is imported now."""
    target = name.removeprefix("save_").removeprefix("add_to_")
    files = {each.name: each.file for each in TARGETS}
    module = import_module(f"envlights.export.formats.{files.get(target) or target}")
    function: Callable[..., Any] = getattr(module, name)
    return function


#: Targets in the order of the help.
TARGETS = (
    Target(
        "json",
        "envlights itself",
        (".json",),
        _OURS,
        Capabilities(environment=False, remark="lossless"),
        file="own_json",
    ),
    Target(
        "csv",
        "a table of numbers",
        (".csv",),
        _OURS,
        Capabilities(environment=False, remark="without report and notes"),
    ),
    Target(
        "gltf",
        "glTF 2.0",
        (".gltf",),
        TargetUnits("KHR_lights_punctual: directional lights use illuminance in lux"),
        Capabilities(
            sizes="none",
            harmonics="none",
            cards=True,
            remark="set ambient light or map of `extras` by hand; sizes are there too",
            source="Khronos, KHR_lights_punctual: a directional light has no size",
        ),
        PANORAMA,
        versions="three.js 0.187; validator of Khronos 2.0.0-dev.3.10",
    ),
    Target(
        "three",
        "three.js",
        (".three.json",),
        TargetUnits("three.js from release 155: DirectionalLight.intensity is in lux"),
        Capabilities(
            sizes="none",
            cards=True,
            uniform_cards=("rectangle", "tube", "disc"),
            remark="sizes are in `userData`",
            source="three.js, src/lights: DirectionalLight, HemisphereLight, LightProbe",
        ),
        versions="0.150, 0.160, 0.180, 0.187 (loader and lights, in Node)",
    ),
    Target(
        "usd",
        "OpenUSD",
        (".usda", ".usdc", ".usd"),
        TargetUnits("UsdLuxLightAPI: nits at exposure 0; normalized distant light: lux"),
        Capabilities(
            harmonics="map",
            cards=True,
            uniform_cards=("disc",),
            remark="Storm, the viewer of usdview, ignores `angle`",
            source="OpenUSD, UsdLux: DistantLight, inputs:angle",
        ),
        PANORAMA,
        Crops(".usd.exr"),
        versions="24.11, 26.11 (usd-core)",
    ),
    Target(
        "mitsuba",
        "Mitsuba 3",
        (".xml",),
        TargetUnits("Mitsuba 3 passes the numbers on: pixels of an image are in cd/m2"),
        Capabilities(
            harmonics="map",
            cards=True,
            uniform_cards=("disc",),
            remark="sizes are in a map",
            source="Mitsuba 3, plugins: envmap",
        ),
        ".ambient.mitsuba.exr",  # rows as Mitsuba reads them
        Crops(".mitsuba.exr"),
        versions="3.5.2, 3.9.1",
    ),
    Target(
        "blender",
        "Blender, a script",
        (".py",),
        TargetUnits("as in Blender's glTF importer", "W/m2", "W/(m2 sr)", _SI),
        Capabilities(
            harmonics="map",
            cards=True,
            remark="for Cycles; a map has no shadows in EEVEE",
            source="Blender manual, Cycles: Sun Light, Angle",
        ),
        PANORAMA,
        Crops(".blender.exr", has_discs=True),
        versions="4.2.0, 5.0.1, 5.3.0 (bpy, Cycles)",
    ),
    Target(
        "radiance",
        "Radiance",
        (".rad",),
        TargetUnits("WHTEFFICACY of Radiance", "W/m2", "W/(m2 sr)", _RADIANCE),
        Capabilities(harmonics="map", source="Radiance, The RADIANCE Lighting Simulation: source"),
        ".ambient.hdr",  # mantissas rounded as Radiance reads them
        versions="that of pyradiance 1.3",
    ),
    Target(
        "pbrt",
        "pbrt-v4",
        (".pbrt",),
        TargetUnits("pbrt-v4, lights.cpp: an RGB of 1 is scaled to 1 nit or 1 lux"),
        Capabilities(
            harmonics="map",
            cards=True,
            uniform_cards=("disc",),
            remark="sizes below 0.7 degrees are points, others are in a map",
            source="pbrt-v4 file format: infinite and distant lights",
        ),
        ".ambient.pbrt.exr",  # equal-area map
        Crops(".pbrt.exr"),
    ),
    Target(
        "mujoco",
        "MuJoCo",
        (".mujoco.xml",),
        _WITHOUT_UNITS,
        _POINTS._replace(
            lights=7,  # OpenGL has eight, and the headlight is one of them
            casters=CASTERS,
            remark="of a map, the mean alone; for the classic renderer",
            source="MuJoCo 3.12, src/render/classic/render_gl3.c: eight lights of OpenGL",
        ),
        versions="3.2.0, 3.2.7, 3.3.0, 4.0.0 (classic renderer), Warp 4.0.0",
    ),
    Target(
        "sapien",
        "SAPIEN and ManiSkill, a script",
        (".sapien.py",),
        _WITHOUT_UNITS,
        _POINTS._replace(
            lights=3,  # the others are dropped
            casters=1,
            remark="of a map, the mean alone; for the rasteriser",
            source="SAPIEN 3.0, vulkan_shader/default/deferred.frag: NUM_DIRECTIONAL_LIGHTS",
        ),
        file="simulators",
        versions="3.0.3 (Vulkan)",
    ),
    Target(
        "genesis",
        "Genesis, a script",
        (".genesis.py",),
        _WITHOUT_UNITS,
        _POINTS._replace(
            lights=4,  # more are refused
            remark="of a map, the mean alone; for the rasteriser, whose surfaces have a gloss",
            source="Genesis 1.4, ext/pyrender: constants.py, shaders/mesh.frag",
        ),
        file="simulators",
        versions="1.4.5 (EGL)",
    ),
    Target(
        "godot",
        "Godot 4",
        (".tscn",),
        TargetUnits("Godot 4: energies have no units by default", "lux (energy: over pi)"),
        Capabilities(
            sizes="soften",
            harmonics="map",
            lights=8,  # Godot drops any others
            casters=CASTERS,
            remark="sizes above 1.5 degrees are points; a map needs Forward+ or Mobile",
            source="Godot 4, scene_forward_lights_inc.glsl, light_storage.cpp",
        ),
        PANORAMA,
        versions="4.6 (Compatibility)",
    ),
    Target(
        "unity",
        "Unity",
        (".unity.json",),
        TargetUnits("Unity HDRP, Light component: directional lights are in lux"),
        Capabilities(
            sizes="soften",
            remark="other pipelines than HDRP use `intensity_without_pi`",
            source="Unity manual, HDRP: Light, Angular Diameter",
        ),
        PANORAMA,
        file="engine",
    ),
    Target(
        "unreal",
        "Unreal Engine",
        (".unreal.json",),
        TargetUnits("Unreal Engine, Physical Lighting Units: directional lights are in lux"),
        Capabilities(
            sizes="soften",
            harmonics="map",
            remark="set the rotation of the map by hand",
            source="Unreal Engine documentation: Directional Light, Source Angle",
        ),
        PANORAMA,
        file="engine",
    ),
)

#: Axes by the name of the target.
AXES = {target.name: target.axes for target in TARGETS}

#: Suffixes of all targets.
SUFFIXES = tuple(suffix for target in TARGETS for suffix in target.suffixes)

#: Suffixes that no target has, and advice for each.
_INSTEAD = {
    ".blend": "give .py, a script that Blender runs",
    ".glb": "give .gltf",
    ".usdz": "give .usda",
    **dict.fromkeys(PICTURES, "`plot.save` writes pictures"),
    **dict.fromkeys((".exr", ".hdr"), "`to_map` makes a map, whose `save` writes it"),
}


def target_of(path: AnyPath) -> Target:
    """Target of a file name; the longest matching suffix decides."""
    name = as_path(path).name.lower()[1:]
    fits = [
        (len(suffix), target)
        for target in TARGETS
        for suffix in target.suffixes
        if name.endswith(suffix)
    ]
    if not fits:
        hint = _INSTEAD.get(as_path(path).suffix.lower())
        wanted = ", ".join(SUFFIXES)
        raise EnvLightsError(
            f"cannot write {path}: {f'{hint}; ' if hint else ''}the suffix must be one of {wanted}"
        )
    return max(fits, key=lambda fit: fit[0])[1]


def target_named(name: str) -> Target:
    """Target of a name, such as "three"."""
    named = {target.name: target for target in TARGETS}
    check_choice("target", name, tuple(named))
    return named[name]


def target_names(target: str | Iterable[str] | None) -> tuple[str, ...]:
    """Checked names of one target or of several."""
    names = (target,) if isinstance(target, str) else () if target is None else target
    if not isinstance(names, Iterable):
        raise EnvLightsError(f"target must be a name, such as 'three'; got {describe(target)}")
    return tuple(target_named(name).name for name in names)


def shown_by(names: Iterable[str]) -> Capabilities:
    """Parts of a rig that all of the named targets can show."""
    return common(target_named(name).shows for name in names)


def error_in(rig: Any, target: str) -> float:
    """Relative RMS error of a rig as a target shows it; of lights alone, the change by it."""
    return target_named(target).shows.error(rig)
