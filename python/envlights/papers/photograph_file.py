"""Files of the lights of a photograph: own JSON, and a table of places without directions."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import amount, counts, flag, reals
from envlights._common.files import write_content
from envlights._common.tables import csv_of
from envlights._native import EnvLightsError
from envlights.detection.lights import DetectionReport
from envlights.rigs.light_arrays import light_arrays

#: Columns of the arrays of samples; `light` and `survivor` are indices.
_PLACES = ("first", "pixel", "maximum")
#: First line of a table of places.
_FORMAT = "# envlights CSV of a photograph, version 1"


def fields_of(data: Mapping[str, Any]) -> dict[str, Any]:
    """Fields of `PhotographLights` from the dictionary of `to_dict`, checked; no picture."""
    lights = len(data["position"])
    numbers = {name: reals(name, data[name], 1) for name in ("peak_luminance", "flux_fraction")}
    arrays: dict[str, Any] = {
        "position": _rows("position", data["position"], 2),
        "pixel_flux": _rows("pixel_flux", data["pixel_flux"], 3),
        "peak_pixel": _rows("peak_pixel", data["peak_pixel"], 2).astype(np.int64),
        **numbers,
        "is_clipped": np.array([flag("is_clipped", each) for each in data["is_clipped"]], bool),
    }
    if data["direction"] is not None:
        given = (_rows(name, data[name], 3) for name in ("direction", "irradiance"))
        arrays["direction"], arrays["irradiance"] = light_arrays(*given)
    for name, array in arrays.items():
        if len(array) != lights or (name != "direction" and not _is_usable(array)):
            raise EnvLightsError(f"{name} must have {lights} rows of finite numbers from 0 on")
    height, width = counts("size", data["size"])
    view = data["field_of_view"]
    return {
        **arrays,
        "samples": _samples(data["samples"], lights),
        "report": DetectionReport.from_dict(data["report"]),
        "size": (height, width),
        "field_of_view": None if view is None else amount("field_of_view", view, most=np.pi),
    }


def _rows(name: str, values: Any, columns: int) -> NDArray[np.float64]:
    """Array of rows; an empty list has no second axis."""
    return reals(name, np.reshape(values, (-1, columns)), 2)


def _is_usable(array: NDArray[Any]) -> bool:
    return bool(np.isfinite(array).all() and (array >= 0).all())


def _samples(data: Mapping[str, Any], lights: int) -> tuple[NDArray[np.int64], ...]:
    """Arrays of `PhotographSamples`, whose indices are in range."""
    arrays = [_rows(name, data[name], 2).astype(np.int64) for name in _PLACES]
    arrays += [reals(name, data[name], 1).astype(np.int64) for name in ("survivor", "light")]
    count = len(arrays[0])
    if any(len(array) != count for array in arrays):
        raise EnvLightsError("samples must have arrays of one length")
    for name, array, most in (("survivor", arrays[3], count), ("light", arrays[4], lights)):
        if not ((array >= 0) & (array < most)).all():
            raise EnvLightsError(f"{name} of the samples must be indices below {most}")
    return tuple(arrays)


def save_table(
    path: str | os.PathLike[str], size: tuple[int, int], columns: Mapping[str, NDArray[Any]]
) -> None:
    """Write columns with a row for each light of a photograph, for spreadsheets.

    Parameters
    ----------
    path : path-like
    size : tuple of int
        Height and width of the photograph.
    columns : mapping
        Arrays by their names.
    """
    height, width = size
    about = f"# {width}x{height} pixels; x, y from the top left corner; red, green, blue: linear"
    head = f"{_FORMAT}\n{about} Rec.709 radiance times pixels\n"
    numbers = {name: array + 0 for name, array in columns.items()}  # False becomes 0
    write_content(path, head + csv_of(numbers))
