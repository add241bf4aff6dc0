"""glTF 2.0: directional lights with an animation of rotation, intensity and colour."""

from __future__ import annotations

import base64
from collections.abc import Iterable
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights.export.formats.gltf import SHINES, rotation_between
from envlights.sequence.frame_rig import FrameRig
from envlights.sequence.light_tracks import LightTrack, tracks_of

_LIGHTS, _POINTER = "KHR_lights_punctual", "KHR_animation_pointer"
#: Type of an accessor by the number of its columns; 5126 is the code of float32.
_TYPES, _FLOAT32 = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}, 5126
_NOTE = (
    "glTF has no ambient light: ambient holds the radiance of each frame. A program without"
    f" {_POINTER} turns the lights, but shows each with its mean intensity."
)


def gltf(rigs: Iterable[FrameRig], fps: float | None = None) -> dict[str, Any]:
    """A glTF 2.0 asset with an animated node for each light.

    Rotations are an animation of the core format. Intensity and colour need
    ``KHR_animation_pointer``: programs without it, as most are, show the mean of each light.
    Keyframes are linear in between. Sizes and the ambient term are in `extras`, a value for each
    frame.

    Parameters
    ----------
    rigs : iterable of FrameRig
        Rigs of the frames, such as a `RigSequence`.
    fps : float, optional
        Frames in a second. Default: 24.

    Returns
    -------
    dict
        For `json.dump`; its buffer is inside. Axes and units as in `el.export.gltf`.

    Examples
    --------
    >>> import envlights as el
    >>> lamp = el.Lights([[0, 1, 0]], [[4, 2, 1]])
    >>> frame_rig = el.sequence.FrameRig
    >>> asset = gltf([frame_rig([0, 0, 0], lamp, 0.0, frame=k, ids=(2,)) for k in (0, 1)])
    >>> asset["nodes"][0]["name"], len(asset["animations"][0]["channels"])
    ('light_2', 3)
    """
    tracks = tracks_of(rigs, "gltf", fps)
    extras = {"units": tracks.statement, "ambient": tracks.ambient.tolist(), "note": _NOTE}
    asset: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": "envlights", "extras": extras}
    }
    scene: dict[str, Any] = {"name": "envlights"}
    asset |= {"scene": 0, "scenes": [scene]}
    if not tracks.lights:
        return asset
    lights = tracks.lights
    scene["nodes"] = list(range(len(lights)))
    asset["nodes"] = [_node(row, track) for row, track in enumerate(lights)]
    asset["extensions"] = {_LIGHTS: {"lights": [_light(track) for track in lights]}}
    asset["extensionsUsed"] = [_LIGHTS, _POINTER]
    return asset | _animation(lights, tracks.seconds)


def _node(row: int, track: LightTrack) -> dict[str, Any]:
    rotation = rotation_between(SHINES, -track.direction[0])
    light = {_LIGHTS: {"light": row}}
    return {"name": f"light_{track.id}", "rotation": rotation.tolist(), "extensions": light}


def _light(track: LightTrack) -> dict[str, Any]:
    """Light with its mean irradiance, for programs that animate none."""
    mean = (track.intensity[:, None] * track.colour).mean(axis=0)
    most = float(mean.max())
    return {
        "name": f"light_{track.id}",
        "type": "directional",
        "color": (mean / (most or 1.0)).tolist(),
        "intensity": most,
        "extras": {"id": track.id, "angular_radius": track.radius.tolist()},
    }


def _animation(lights: tuple[LightTrack, ...], seconds: NDArray[np.float64]) -> dict[str, Any]:
    arrays = [seconds[:, None]]
    samplers: list[dict[str, Any]] = []
    channels: list[dict[str, Any]] = []
    for row, track in enumerate(lights):
        at = f"/extensions/{_LIGHTS}/lights/{row}/"
        curves = (
            ({"node": row, "path": "rotation"}, _rotations(track.direction)),
            (_pointer(at + "intensity"), track.intensity[:, None]),
            (_pointer(at + "color"), track.colour),
        )
        for target, values in curves:
            channels.append({"sampler": len(samplers), "target": target})
            samplers.append({"input": 0, "output": len(arrays), "interpolation": "LINEAR"})
            arrays.append(values)
    animation = {"name": "envlights", "channels": channels, "samplers": samplers}
    return {"animations": [animation], **_buffer([array.astype("<f4") for array in arrays])}


def _pointer(pointer: str) -> dict[str, Any]:
    return {"path": "pointer", "extensions": {_POINTER: {"pointer": pointer}}}


def _rotations(directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Quaternions x, y, z, w, (frames, 4), each on the side of the last one."""
    turns = np.array([rotation_between(SHINES, -direction) for direction in directions])
    for last, this in pairwise(turns):
        this *= -1 if last @ this < 0 else 1
    return turns


def _buffer(arrays: list[NDArray[np.float32]]) -> dict[str, Any]:
    ends = np.cumsum([array.nbytes for array in arrays]).tolist()
    accessors = [
        {
            "bufferView": row,
            "componentType": _FLOAT32,
            "count": len(array),
            "type": _TYPES[array.shape[1]],
            # The times of an animation must state their limits.
            "min": array.min(axis=0).tolist(),
            "max": array.max(axis=0).tolist(),
        }
        for row, array in enumerate(arrays)
    ]
    views = [
        {"buffer": 0, "byteOffset": end - array.nbytes, "byteLength": array.nbytes}
        for end, array in zip(ends, arrays, strict=True)
    ]
    data = base64.b64encode(b"".join(array.tobytes() for array in arrays)).decode()
    buffer = {"byteLength": ends[-1], "uri": f"data:application/octet-stream;base64,{data}"}
    return {"accessors": accessors, "bufferViews": views, "buffers": [buffer]}
