"""Ambient terms that a fit may use, for a target and over a floor."""

from __future__ import annotations

from envlights._common.check import check_choice
from envlights._native import EnvLightsError
from envlights.export.capabilities import Capabilities
from envlights.fitting.request import Request

#: Ambient terms with their number of coefficients in each channel, the simplest first.
AMBIENTS = {"none": 0, "constant": 1, "sh2": 9}
#: Name for the best ambient term.
AUTO = "auto"


def ambient_for(ambient: str | None, has_target: bool, shows: Capabilities) -> str:
    """Checked name of an ambient term, or the default for a target."""
    if ambient is None:
        return AUTO if has_target and shows.harmonics == "exact" else "constant"
    check_choice("ambient", ambient, (*AMBIENTS, AUTO))
    if ambient == "sh2" and shows.harmonics == "none":
        raise EnvLightsError("ambient must not be 'sh2' for a target that shows no harmonics")
    return ambient


def ambient_names(floor: bool, shows: Capabilities) -> tuple[str, ...]:
    """Ambient terms that "auto" compares, the simplest first."""
    return tuple(name for name in shows.ambients() if not (floor and name == "sh2"))


def check_over_floor(ambient: str, request: Request, shows: Capabilities) -> None:
    """Refuse arguments that a floor makes impossible."""
    if not shows.floor:
        raise EnvLightsError(
            "floor must be False for a target that shows no light from above alone"
        )
    if ambient == "sh2":
        raise EnvLightsError(
            "ambient must be 'none' or 'constant' or 'auto' where there is a floor, because"
            " harmonics cannot be fitted over one; got 'sh2'"
        )
    request.check_above_horizon()
