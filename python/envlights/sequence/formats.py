"""File formats of a sequence by suffix."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from typing import Any

import numpy as np

from envlights._common import tables
from envlights._common.check import count
from envlights._common.errors import DamagedFileError
from envlights._common.files import as_path, read_text
from envlights._common.tables import csv_text
from envlights._common.units import statement
from envlights._native import EnvLightsError
from envlights.export.files import save_scene
from envlights.export.formats.own_json import build_from, parse
from envlights.export.formats.usd import crate
from envlights.export.saving import check_options
from envlights.export.targets import target_of
from envlights.rigs.rig import rig_fields
from envlights.sequence.blender_keyframes import blender
from envlights.sequence.frame_rig import FrameRig
from envlights.sequence.gltf_animation import gltf
from envlights.sequence.light_tracks import checked_rigs
from envlights.sequence.usd_samples import usd

_HEADER = {"format": "envlights rig sequence", "version": 1}


def json_lines(rigs: Iterable[FrameRig], steadiness: int = 0, fps: float | None = None) -> str:
    """Lines of JSON: a header, then `FrameRig.to_dict` of each frame.

    Examples
    --------
    >>> import envlights as el
    >>> lamp = el.Lights([[0, 1, 0]], [[3, 2, 1]], [0.5])
    >>> text = json_lines([el.sequence.FrameRig([0, 0, 0], lamp, 0.0, ids=(2,))], fps=25.0)
    >>> text.splitlines()[0]
    '{"format": "envlights rig sequence", "version": 1, "steadiness": 0, "fps": 25.0, "frames": 1}'
    """
    rows = [rig.to_dict() for rig in checked_rigs(rigs)]
    header = {**_HEADER, "steadiness": steadiness, "fps": fps, "frames": len(rows)}
    return tables.json_lines([header, *rows])


def read_json_lines(
    path: str | os.PathLike[str],
) -> tuple[tuple[FrameRig, ...], int, float | None]:
    """Rigs, steadiness and frames per second, from a file of `json_lines`.

    Raises
    ------
    EnvLightsError
        If the file is missing, or is no complete sequence.
    """
    lines = read_text(path).splitlines()
    header = parse(f"{path}, line 1,", lines[0] if lines else "", "JSON")
    if not isinstance(header, dict) or not header.items() >= _HEADER.items():
        raise DamagedFileError(
            f"{path} is not a sequence of rigs of version 1: its first line does not say"
            f" {json.dumps(_HEADER)}"
        )
    places = [f"{path}, line {number}," for number in range(2, len(lines) + 1)]
    rigs = tuple(
        build_from(place, "rig", _frame_rig, parse(place, line, "JSON"))
        for place, line in zip(places, lines[1:], strict=True)
    )
    frames = count("frames of the first line", header.get("frames", len(rigs)))
    if len(rigs) < frames:
        raise DamagedFileError(f"{path} is incomplete: it holds {len(rigs)} of {frames} frames")
    return rigs, header.get("steadiness", 0), header.get("fps")


def _frame_rig(data: dict[str, Any]) -> FrameRig:
    flags = data["fit_error"], data["is_search"], data["is_step"]
    return FrameRig(*rig_fields(data), data["frame_number"], tuple(data["ids"]), *flags)


HEADER = "frame,kind,id,x,y,z,red,green,blue,angular_radius"
_HEAD = (
    "# envlights sequence CSV, version 1; right-handed, +y up; x, y, z: towards the light; light:"
    " irradiance at normal incidence, angular_radius in radians; ambient: radiance; linear Rec.709"
    " RGB; "
)


def csv(rigs: Iterable[FrameRig]) -> str:
    """CSV table with a row per light, and one or nine rows for the ambient term, of each frame.

    Examples
    --------
    >>> import envlights as el
    >>> lamp = el.Lights([[0, 1, 0]], [[3, 2, 1]], [0.5])
    >>> print(csv([el.sequence.FrameRig([0, 0, 0], lamp, 0.0, frame=8, ids=(2,))]).splitlines()[2])
    8,light,2,0.0,1.0,0.0,3.0,2.0,1.0,0.5
    """
    rigs = checked_rigs(rigs)
    rows = []
    for rig in rigs:
        lights = rig.lights
        table = np.hstack([lights.direction, lights.irradiance, lights.angular_radius[:, None]])
        numbers = zip(rig.ids, table.tolist(), strict=True)
        rows += [[rig.frame, "light", identity, *row] for identity, row in numbers]
        ambient = np.atleast_2d(rig.ambient).tolist()
        rows += [[rig.frame, "ambient", *[None] * 4, *row, None] for row in ambient]
    return f"{_HEAD}{statement(rigs[0].units)}\n{HEADER}\n{csv_text(rows)}"


#: Suffixes of the files that `save` writes.
SUFFIXES = (".jsonl", ".csv", ".usda", ".usdc", ".usd", ".gltf", ".py")


def save(
    rigs: Iterable[FrameRig],
    path: str | os.PathLike[str],
    steadiness: int = 0,
    fps: float | None = None,
    **options: Any,
) -> None:
    """Write rigs of frames in the format of the suffix; a failure leaves no file.

    `options` are those of an OpenUSD file, `up` and `metres_per_unit`.
    """
    suffix = as_path(path).suffix.lower()
    if suffix in SUFFIXES:
        check_options((target_of(f"rigs{suffix}"),) if suffix != ".jsonl" else (), options)
    save_scene(path, _content(rigs, suffix, steadiness, fps, options))


def _content(
    rigs: Iterable[FrameRig],
    suffix: str,
    steadiness: int,
    fps: float | None,
    options: dict[str, Any],
) -> str | bytes:
    if suffix == ".jsonl":
        return json_lines(rigs, steadiness, fps)
    if suffix == ".csv":
        return csv(rigs)
    if suffix in (".usda", ".usd"):
        return usd(rigs, fps, **options)
    if suffix == ".usdc":
        return crate(usd(rigs, fps, **options))
    if suffix == ".gltf":
        return json.dumps(gltf(rigs, fps), allow_nan=False) + "\n"
    if suffix == ".py":
        return blender(rigs, fps)
    wanted = ", ".join(SUFFIXES)
    raise EnvLightsError(
        f"a sequence is written as one of {wanted}; got the suffix {suffix!r}. Save single rigs"
        " for other programs"
    )
