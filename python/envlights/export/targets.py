"""Table of the targets: suffixes, writer, and the parts of a rig that each keeps and loses."""

from __future__ import annotations

from envlights._targets import PANORAMA, Target, register
from envlights.export.blender import save_blender
from envlights.export.csv import save_csv
from envlights.export.engine import save_unity, save_unreal
from envlights.export.gltf import save_gltf
from envlights.export.mitsuba import TEXTURE as MITSUBA_TEXTURE
from envlights.export.mitsuba import save_mitsuba
from envlights.export.own_json import save_json
from envlights.export.pbrt import TEXTURE as PBRT_TEXTURE
from envlights.export.pbrt import save_pbrt
from envlights.export.radiance import TEXTURE as RADIANCE_TEXTURE
from envlights.export.radiance import save_radiance
from envlights.export.three import save_three
from envlights.export.usd import save_usd

#: Targets in the order of the help.
TARGETS = (
    Target(
        "json",
        "envlights itself",
        (".json",),
        save_json,
        False,
        "everything",
        "nothing",
    ),
    Target(
        "csv",
        "a table of numbers",
        (".csv",),
        save_csv,
        False,
        "lights, sizes, ambient, harmonics, error, floor",
        "report, notes",
    ),
    Target(
        "gltf",
        "glTF 2.0",
        (".gltf",),
        save_gltf,
        True,
        "lights",
        "sizes, the ambient term and a map (they are in the extras)",
        PANORAMA,
    ),
    Target(
        "three",
        "three.js",
        (".three.json",),
        save_three,
        True,
        "lights, ambient, harmonics, floor, map",
        "sizes (they are in userData)",
    ),
    Target(
        "usd",
        "OpenUSD",
        (".usda", ".usdc", ".usd"),
        save_usd,
        True,
        "lights, sizes, ambient, harmonics (as a map), floor, map",
        "negative parts of harmonics",
        PANORAMA,
    ),
    Target(
        "mitsuba",
        "Mitsuba 3",
        (".xml",),
        save_mitsuba,
        True,
        "lights, sizes (in a map), ambient, harmonics (as a map), floor, map",
        "negative parts of harmonics",
        MITSUBA_TEXTURE,
    ),
    Target(
        "blender",
        "Blender, a script",
        (".py",),
        save_blender,
        True,
        "lights, sizes, ambient, harmonics, floor, map",
        "negative parts of harmonics",
        PANORAMA,
    ),
    Target(
        "radiance",
        "Radiance",
        (".rad",),
        save_radiance,
        True,
        "lights, sizes, ambient, harmonics, floor, map",
        "negative parts of harmonics",
        RADIANCE_TEXTURE,
    ),
    Target(
        "pbrt",
        "pbrt-v4",
        (".pbrt",),
        save_pbrt,
        True,
        "lights, sizes from 0.7 degrees, ambient, harmonics, floor, map",
        "smaller sizes, negative parts of harmonics",
        PBRT_TEXTURE,
    ),
    Target(
        "unity",
        "Unity",
        (".unity.json",),
        save_unity,
        True,
        "lights, sizes, ambient, harmonics, floor (as a map), map",
        "nothing that Unity has",
        PANORAMA,
    ),
    Target(
        "unreal",
        "Unreal Engine",
        (".unreal.json",),
        save_unreal,
        True,
        "lights, sizes, ambient, harmonics, floor (as a map), map",
        "rotation of the map (set it by hand)",
        PANORAMA,
    ),
)

register(TARGETS)

#: Suffixes of all targets.
SUFFIXES = tuple(suffix for target in TARGETS for suffix in target.suffixes)
