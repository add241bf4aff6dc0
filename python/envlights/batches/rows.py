"""Row for a result: numbers and texts of a rig, of lights, or of a user's function."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from envlights._common.check import describe
from envlights._common.fields import plain as plain_values
from envlights._common.result import Result
from envlights._native import EnvLightsError
from envlights.detection.lights import DetectedLights
from envlights.environment.envmap import EnvMap
from envlights.environment.light import mean_radiance
from envlights.kernels.ambient import half_sky_harmonics, mean_ambient
from envlights.rigs.lights import Lights
from envlights.rigs.rig import Rig


def row_of(result: Any) -> dict[str, Any]:
    """Numbers and texts of a result, with an entry for each light."""
    if isinstance(result, Rig):
        return _of_rig(result)
    if isinstance(result, Lights):
        return _of_lights(result)
    lights = getattr(result, "lights", None)
    if isinstance(lights, Lights):  # a split, or an excess
        return _of_lights(lights) | _of_remainder(getattr(result, "remainder", None))
    if isinstance(result, Mapping):
        return {"values": plain(result)}
    if isinstance(result, Result) and hasattr(result, "to_dict"):
        return {"values": plain(result.to_dict())}
    raise EnvLightsError(
        "the function of a batch must return a dict, a rig, lights or another result; got"
        f" {describe(result)}"
    )


def note_codes(notes: Iterable[Any]) -> list[str]:
    """Code of each note; the text for a note without a code."""
    return [str(getattr(note, "code", note)) for note in notes]


def _of_rig(rig: Rig) -> dict[str, Any]:
    report = rig.report
    lights = _each_light(rig.lights, tolerances=report.direction_tolerances)
    given = rig.ambient if rig.ambient.ndim == 2 else None
    harmonics = half_sky_harmonics(rig.ambient) if rig.floor else given
    return {
        "error": rig.error,
        "shadow_error": report.shadow_error,
        "gloss_error": report.gloss_error(),
        "ambient": mean_ambient(rig.ambient).tolist(),
        "ambient_harmonics": None if harmonics is None else harmonics.tolist(),
        "units": rig.units,
        "notes": note_codes(rig.notes),
        "lights": lights,
    }


def _of_lights(lights: Lights) -> dict[str, Any]:
    report = getattr(lights, "report", None)
    notes = lights.notes if report is None else report.notes
    row = {"units": lights.units, "notes": note_codes(notes), "lights": _each_light(lights)}
    remainder = getattr(report, "remainder", None)
    return row if remainder is None else {**row, "ambient": [*remainder]}


def _of_remainder(env: EnvMap | None) -> dict[str, Any]:
    """Notes and mean radiance of a map without its lights."""
    if env is None:
        return {"notes": []}
    mean = mean_radiance(env.radiance, env.is_border_sampled, env.coverage_fraction)
    return {"notes": note_codes(env.notes), "ambient": mean.tolist()}


def _each_light(lights: Lights, tolerances: Iterable[float] = ()) -> list[dict[str, Any]]:
    """Numbers of each light, brightest first; None for values that were not measured."""
    columns: dict[str, Any] = {
        "direction": lights.direction.tolist(),
        "irradiance": lights.irradiance.tolist(),
        "angular_radius": lights.angular_radius.tolist(),
        "fraction": lights.fraction.tolist(),
    }
    if isinstance(lights, DetectedLights):
        columns |= {"is_clipped": lights.is_clipped.tolist(), "is_cut": lights.is_cut.tolist()}
        if lights.direction_uncertainty is not None:
            columns["direction_uncertainty"] = lights.direction_uncertainty.tolist()
    if tolerances := list(tolerances):
        columns["direction_tolerance"] = tolerances
    return [
        {name: plain(values[row]) for name, values in columns.items()} for row in range(len(lights))
    ]


def plain(value: Any) -> Any:
    """Plain `value`; non-finite numbers become None."""
    return plain_values(value, infinity=None)
