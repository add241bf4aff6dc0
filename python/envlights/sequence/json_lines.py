"""JSON lines: a header, then the rig of a frame in each line; lossless."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from typing import Any

from envlights._common import tables
from envlights._common.check import texts
from envlights._common.files import as_path
from envlights._common.printable import printable_parts
from envlights._native import EnvLightsError
from envlights.rigs.lights import lights_of
from envlights.rigs.report import FitReport
from envlights.sequence.frame_rig import FrameRig
from envlights.sequence.light_tracks import checked_rigs

_HEADER = {"format": "envlights rig sequence", "version": 1}


def json_lines(rigs: Iterable[FrameRig], steadiness: int = 0, fps: float | None = None) -> str:
    """Lines of JSON: a header, then `FrameRig.to_dict` of each frame.

    Examples
    --------
    >>> import envlights as el
    >>> lamp = el.Lights([[0, 1, 0]], [[3, 2, 1]], [0.5])
    >>> text = json_lines([el.sequence.FrameRig([0, 0, 0], lamp, 0.0, ids=(2,))], fps=25.0)
    >>> text.splitlines()[0]
    '{"format": "envlights rig sequence", "version": 1, "steadiness": 0, "fps": 25.0}'
    """
    header = {**_HEADER, "steadiness": steadiness, "fps": fps}
    return tables.json_lines([header, *(rig.to_dict() for rig in checked_rigs(rigs))])


def read_json_lines(
    path: str | os.PathLike[str],
) -> tuple[tuple[FrameRig, ...], int, float | None]:
    """Rigs, steadiness and frames in a second of a file that `json_lines` filled.

    Raises
    ------
    EnvLightsError
        If the file is missing, or is no complete sequence.
    """
    try:
        lines = as_path(path).read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise EnvLightsError(f"cannot read {path}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise EnvLightsError(f"{path} is not a sequence of rigs: it is not text") from None
    header = _parse(path, 1, lines[0] if lines else "")
    if {name: header.get(name) for name in _HEADER} != _HEADER:
        raise EnvLightsError(
            f"{path} is not a sequence of rigs of version 1: its first line does not say"
            f" {json.dumps(_HEADER)}"
        )
    rigs = tuple(_rig(path, number, line) for number, line in enumerate(lines[1:], 2))
    return rigs, header.get("steadiness", 0), header.get("fps")


def _parse(path: object, number: int, line: str) -> dict[str, Any]:
    """Object in one line."""
    try:
        data = printable_parts(json.loads(line))
    except (ValueError, RecursionError) as error:
        raise EnvLightsError(f"{path}, line {number}, is not JSON: {error}") from None
    if not isinstance(data, dict):
        raise EnvLightsError(f"{path}, line {number}, is not an object of JSON")
    return data


def _rig(path: object, number: int, line: str) -> FrameRig:
    """Rig in one line."""
    data = _parse(path, number, line)
    try:
        return FrameRig(
            data["ambient"],
            lights_of(data["lights"]),
            data["error"],
            FitReport.from_dict(data["report"]),
            tuple(texts("notes", data["notes"])),
            data["floor"],
            data["frame_number"],
            tuple(data["ids"]),
            data["fit_error"],
            data["is_search"],
            data["is_step"],
        )
    except EnvLightsError as error:
        raise EnvLightsError(f"{path}, line {number}, holds an impossible rig: {error}") from None
    except (AttributeError, IndexError, KeyError, OverflowError, TypeError, ValueError) as error:
        raise EnvLightsError(
            f"{path}, line {number}, is not a rig of a sequence: {type(error).__name__} {error}"
        ) from None
