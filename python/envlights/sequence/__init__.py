"""Rigs for a sequence of maps.

| step                                                          | file               |
|---------------------------------------------------------------|--------------------|
| files, videos and arrays as frames                            | `frames.py`, `video.py` |
| fits that continue the last frame, and full searches          | `continuation.py`  |
| identities of the lights                                      | `identity.py`      |
| steps of the light                                            | `steps.py`         |
| window, and mean of the rigs in it                            | `steadiness.py`, `window.py` |
| rig of a frame                                                | `frame_rig.py`     |
| rigs of all frames, and measurements                          | `rig_sequence.py`  |
| the function that does it                                     | `follow.py`        |
| curves of the lights, for files with keyframes                | `light_tracks.py`  |
| - OpenUSD                                                     | `usd_samples.py`   |
| - glTF 2.0                                                    | `gltf_animation.py` |
| - Blender                                                     | `blender_keyframes.py` |
| a table, JSON lines, and the file of each suffix              | `formats.py`       |
"""

from envlights.sequence.blender_keyframes import blender
from envlights.sequence.follow import RigStream, follow
from envlights.sequence.formats import csv, json_lines
from envlights.sequence.frame_rig import FrameRig
from envlights.sequence.gltf_animation import gltf
from envlights.sequence.rig_sequence import RigSequence
from envlights.sequence.usd_samples import usd

__all__ = [
    "FrameRig",
    "RigSequence",
    "RigStream",
    "blender",
    "csv",
    "follow",
    "gltf",
    "json_lines",
    "usd",
]
