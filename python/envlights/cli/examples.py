"""Examples for the end of the help of each subcommand."""

from __future__ import annotations

import click

#: Examples of each subcommand, without its name.
EXAMPLES: dict[str, tuple[str, ...]] = {
    "batch": (
        "maps -o rigs --set lights=4 --table lights.parquet",
        "'*.hdr' -o found --what detect",
    ),
    "compare": ("hall.exr rig.json", "truth guess -o errors.csv --protocol exact"),
    "convert": (
        "hall.exr -o cube.exr --to cube --width 256",
        "sky.hdr -o turned.hdr --rotate 90",
        "maps/*.hdr -o same --lux 1000",
    ),
    "demo": ("-o folder", "transfer -o folder"),
    "detect": ("hall.exr -n 3 -o lights.png", "hall.exr --set rise=4", "sky.jpg --json"),
    "error-curve": ("hall.exr -o curve.csv -o curve.png", "sky.hdr --lights 1,2,4,8 --floor"),
    "export": ("rig.json -o usd -o gltf", "rig.json -o hall.py --environment hall.exr"),
    "fit": (
        "hall.exr -n 4 -o rig.json -o rig.png",
        "sky.hdr --error 0.01 --floor",
        "face.exr --projection cube --faces opengl",
        "frame2.hdr -n 4 --start rig1.json --fixed 0,0.6,0.8",
    ),
    "follow": ("frames -o rigs.jsonl -o rigs.usda --fps 24", "video.mp4 --error 0.01 -o rigs.csv"),
    "mcp": ("maps",),
    "merge": ("dark.jpg light.jpg -o merged.exr",),
    "photograph": ("room.jpg --fov 60",),
    "place": (
        "room.exr --depth depth.exr --point 1,0.2,-0.5 -o there.exr -o rig.usda",
        "room.exr --room 6,3,5 -o room.usda --up z",
    ),
    "relight": (
        "hall.exr --turn 1=0,-20 --tint 1=2500K -o new.exr",
        "hall.exr --move 1=,15 --gain 2=0.5 --remove 3 -o new.exr",
    ),
    "repair": ("sky.jpg -o repaired.exr",),
    "show": ("hall.exr -o report.html", "sky.hdr -n 6 --floor"),
    "split": ("hall.exr -n 2 -o rest.exr -o lights.json",),
    "transfer": ("fit room -o room.npz --ridge loo", "apply room.npz direct.exr -o lightmap.exr"),
    "vary": ("hall.json sky.json -n 1000 -o train/rig.usda --up z --mix 0,0.5 --drop 0.1",),
    "view": ("hall.exr -o page.html", "hall.exr --rig rig.json"),
}

_HEADING = "\b\nExamples:"


def with_examples(command: click.Command) -> None:
    """Insert the examples of a subcommand before its epilog; repeated calls change nothing."""
    name, epilog = command.name or "", command.epilog or ""
    if epilog.startswith(_HEADING):
        return
    lines = [f"  envlights {name} {example}" for example in EXAMPLES[name]]
    command.epilog = "\n\n".join(filter(None, ["\n".join([_HEADING, *lines]), epilog]))
