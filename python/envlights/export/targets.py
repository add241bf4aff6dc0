"""Table of the targets: suffixes, writer, and the parts of a rig that each keeps and loses."""

from __future__ import annotations

from envlights._targets import Target, register
from envlights.export.blender import save_blender
from envlights.export.csv import save_csv
from envlights.export.engine import save_unity, save_unreal
from envlights.export.gltf import save_gltf
from envlights.export.godot import save_godot
from envlights.export.mitsuba import save_mitsuba
from envlights.export.mujoco import save_mujoco
from envlights.export.own_json import save_json
from envlights.export.pbrt import save_pbrt
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
        False,
        "lights",
        "sizes and the ambient term (they are in the extras)",
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
    ),
    Target(
        "mitsuba",
        "Mitsuba 3",
        (".xml",),
        save_mitsuba,
        True,
        "lights, sizes (in a map), ambient, harmonics (as a map), floor, map",
        "negative parts of harmonics",
    ),
    Target(
        "blender",
        "Blender, a script",
        (".py",),
        save_blender,
        True,
        "lights, sizes, ambient, harmonics, floor, map",
        "negative parts of harmonics",
    ),
    Target(
        "radiance",
        "Radiance",
        (".rad",),
        save_radiance,
        True,
        "lights, sizes, ambient, harmonics, floor, map",
        "negative parts of harmonics",
    ),
    Target(
        "pbrt",
        "pbrt-v4",
        (".pbrt",),
        save_pbrt,
        True,
        "lights, sizes from 0.7 degrees, ambient, harmonics, floor, map",
        "smaller sizes, negative parts of harmonics",
    ),
    Target(
        "mujoco",
        "MuJoCo",
        (".mujoco.xml",),
        save_mujoco,
        True,
        "7 lights, the mean of the ambient term or of a map",
        "sizes; more lights and what an ambient term has beside its mean",
    ),
    Target(
        "godot",
        "Godot 4",
        (".tscn",),
        save_godot,
        True,
        "8 lights, sizes up to 1.5 degrees, ambient, harmonics, floor (as a map), map",
        "larger sizes, negative parts of harmonics",
    ),
    Target(
        "unity",
        "Unity",
        (".unity.json",),
        save_unity,
        True,
        "lights, sizes, ambient, harmonics, floor (as a map), map",
        "nothing that Unity has",
    ),
    Target(
        "unreal",
        "Unreal Engine",
        (".unreal.json",),
        save_unreal,
        True,
        "lights, sizes, ambient, harmonics, floor (as a map), map",
        "rotation of the map (set it by hand)",
    ),
)

register(TARGETS)

#: Suffixes of all targets.
SUFFIXES = tuple(suffix for target in TARGETS for suffix in target.suffixes)
