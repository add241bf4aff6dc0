"""Lossless JSON of the package, with format, version, frame and units: reader and writer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from envlights._common.check import describe
from envlights._common.errors import DamagedFileError, FileError
from envlights._common.files import read_text
from envlights._common.printable import printable_parts
from envlights._common.units import statement
from envlights._native import EnvLightsError
from envlights.export.files import AnyPath, json_text, save_scene
from envlights.kernels.sphere import FRAME

_T = TypeVar("_T")

#: Header of a file of lights. `Lights.to_dict` holds only arrays, as a part of a rig.
LIGHTS_HEADER: dict[str, str | int] = {
    "format": "envlights lights",
    "version": 2,
    "frame": FRAME,
    "units": "irradiance: at normal incidence; linear Rec.709 RGB; angular_radius: radians",
}


def save_json(rig: Any, path: AnyPath) -> None:
    """Write the result of `to_dict`, which `load` of the same class reads; of cards, the lights."""
    data = rig.to_dict()
    if "format" not in data:
        data = getattr(rig, "lights", rig).to_dict()
        units = f"{LIGHTS_HEADER['units']}; {statement(data['scale'])}"
        data = {**LIGHTS_HEADER, "units": units, **data}
    save_scene(path, json_text(data))


def read_json(
    path: AnyPath, kind: str, versions: tuple[int, ...], build: Callable[[dict[str, Any]], _T]
) -> _T:
    """Read a file of a `kind`, such as "rig", and pass its content to `build`.

    Raises
    ------
    EnvLightsError
        If the file is missing, of another kind or version, or `build` cannot use it.
    """
    data = parse(path, read_text(path))
    _check_version(path, kind, versions, data)
    return build_from(path, kind, build, data)


def parse(place: object, text: str, noun: str = "a JSON file") -> Any:
    """Content of JSON at a `place`, such as a path, or a refusal that names it."""
    import json  # here, so that `import envlights` does not wait for it

    try:
        return printable_parts(json.loads(text))
    except (ValueError, RecursionError) as error:
        raise DamagedFileError(f"{place} is not {noun}: {error}") from None


def build_from(place: object, kind: str, build: Callable[[Any], _T], data: Any) -> _T:
    """Result of `build` for the content of a `kind`, or a refusal that names the place."""
    try:
        return build(data)
    except EnvLightsError as error:
        raise DamagedFileError(f"{place} holds {_impossible(kind)}: {error}") from None
    except KeyError as error:
        reason = f"the key {error} is missing"
    except (AttributeError, IndexError, OverflowError, TypeError, ValueError):
        reason = "a value has another type or shape than `save` writes"
    raise DamagedFileError(f"{place} is not {_one(kind, 'complete')}: {reason}")


def _check_version(path: object, kind: str, versions: tuple[int, ...], data: Any) -> None:
    name = f"envlights {kind}"
    if not isinstance(data, dict) or data.get("format") != name:
        raise FileError(f"{path} is not {_one(kind)}: it does not say 'format': '{name}'")
    if data.get("version") not in versions:
        version, read = describe(data.get("version")), ", ".join(map(str, versions))
        raise FileError(f"{path} is {_one(kind)} of version {version}; this package reads {read}")


def _one(kind: str, quality: str = "") -> str:
    """Noun for a file of a `kind`: "a rig", "a complete list of lights"."""
    noun = f"list of {kind}" if kind.endswith("s") else kind
    return f"a {quality} {noun}" if quality else f"a {noun}"


def _impossible(kind: str) -> str:
    return f"impossible {kind}" if kind.endswith("s") else f"an impossible {kind}"
