"""Files of a sequence by their suffixes."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable

from envlights._common.files import as_path
from envlights._native import EnvLightsError
from envlights.export.files import save_scene
from envlights.export.formats.usd import crate
from envlights.sequence.blender_keyframes import blender
from envlights.sequence.csv_rows import csv
from envlights.sequence.frame_rig import FrameRig
from envlights.sequence.gltf_animation import gltf
from envlights.sequence.json_lines import json_lines
from envlights.sequence.usd_samples import usd

#: Suffixes of the files that `save` writes.
SUFFIXES = (".jsonl", ".csv", ".usda", ".usdc", ".usd", ".gltf", ".py")


def save(
    rigs: Iterable[FrameRig],
    path: str | os.PathLike[str],
    steadiness: int = 0,
    fps: float | None = None,
) -> None:
    """Write rigs of frames in the format of the suffix; a failure leaves no file."""
    save_scene(path, _content(rigs, as_path(path).suffix.lower(), steadiness, fps))


def _content(
    rigs: Iterable[FrameRig], suffix: str, steadiness: int, fps: float | None
) -> str | bytes:
    """Content of a file with this suffix."""
    if suffix == ".jsonl":
        return json_lines(rigs, steadiness, fps)
    if suffix == ".csv":
        return csv(rigs)
    if suffix in (".usda", ".usd"):
        return usd(rigs, fps)
    if suffix == ".usdc":
        return crate(usd(rigs, fps))
    if suffix == ".gltf":
        return json.dumps(gltf(rigs, fps), allow_nan=False) + "\n"
    if suffix == ".py":
        return blender(rigs, fps)
    wanted = ", ".join(SUFFIXES)
    raise EnvLightsError(
        f"a sequence is written as one of {wanted}; got the suffix {suffix!r}. Save single rigs"
        " for other programs"
    )
