"""Colour spaces by name or by codes of ITU-T H.273."""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights.environment.colour import primaries as p
from envlights.environment.colour import transfer_curves as curves
from envlights.environment.colour.transfer_curves import Curve, Power


class Space(NamedTuple):
    """Colour space of samples, with the names of its parts for notes."""

    curve: Curve | None
    """Function from codes to linear values; None if the codes are linear."""

    matrix: NDArray[np.float64] | None
    """Linear RGB to linear Rec.709; None for Rec.709."""

    curve_name: str
    """Name of the curve; empty if the codes are linear."""

    primaries_name: str
    """Name of the primaries; empty for Rec.709."""

    notes: tuple[str, ...] = ()
    """Notes on assumptions."""


#: Transfer curves, and their names in notes.
_CURVES: dict[str, tuple[Curve | None, str]] = {
    "linear": (None, ""),
    "srgb": (curves.srgb, "sRGB"),
    "rec709": (curves.rec709, "the camera curve of BT.709, to the light of the scene"),
    "adobe": (Power(curves.ADOBE_EXPONENT), "a power law of exponent 2.2"),
    "prophoto": (curves.prophoto, "ProPhoto RGB"),
    "pq": (curves.pq, "PQ; 203 cd/m2 became 1"),
    "hlg": (curves.hlg, "HLG to the light of the scene; diffuse white became 1"),
    "cinema": (Power(2.6, 52.37 / 48), "the curve of SMPTE ST 428-1"),
}

#: Names of primaries in notes.
_PRIMARIES: dict[str, p.Chromaticities] = {
    "Rec.709": p.REC709,
    "Display P3": p.DISPLAY_P3,
    "DCI-P3": p.DCI_P3,
    "Adobe RGB": p.ADOBE_RGB,
    "Rec.2020": p.REC2020,
    "ACES AP0": p.ACES_AP0,
    "ACES AP1": p.ACES_AP1,
    "ProPhoto RGB": p.PROPHOTO,
    "BT.470 M": (0.67, 0.33, 0.21, 0.71, 0.14, 0.08, 0.310, 0.316),
    "BT.470 BG": (0.64, 0.33, 0.29, 0.60, 0.15, 0.06, 0.3127, 0.3290),
    "SMPTE 170M": (0.630, 0.340, 0.310, 0.595, 0.155, 0.070, 0.3127, 0.3290),
    "generic film": (0.681, 0.319, 0.243, 0.692, 0.145, 0.049, 0.310, 0.316),
    "EBU 3213": (0.630, 0.340, 0.295, 0.605, 0.155, 0.077, 0.3127, 0.3290),
}

#: Curve and primaries of each name for `colour`.
_NAMES = {
    "linear": ("linear", "Rec.709"),
    "srgb": ("srgb", "Rec.709"),
    "p3": ("srgb", "Display P3"),
    "adobe-rgb": ("adobe", "Adobe RGB"),
    "rec2020": ("rec709", "Rec.2020"),
    "prophoto": ("prophoto", "ProPhoto RGB"),
    "acescg": ("linear", "ACES AP1"),
    "aces": ("linear", "ACES AP0"),
    "pq": ("pq", "Rec.2020"),
    "hlg": ("hlg", "Rec.2020"),
    "xyz": ("linear", "CIE XYZ"),
    "linear-p3": ("linear", "Display P3"),
    "linear-adobe-rgb": ("linear", "Adobe RGB"),
    "linear-rec2020": ("linear", "Rec.2020"),
    "linear-prophoto": ("linear", "ProPhoto RGB"),
}
#: Other names for the same spaces, without marks between words.
_ALIASES = {
    "displayp3": "p3",
    "aces20651": "aces",
    "linearrec709": "linear",
    "linearsrgb": "linear",
    "bt2020": "rec2020",
    "prophotorgb": "prophoto",
    "rommrgb": "prophoto",
}
_BY_KEY = {name.replace("-", ""): name for name in _NAMES} | _ALIASES

#: Names for `colour`, as error messages list them.
NAMES = tuple(_NAMES)

#: Primaries and curves of the codes of ITU-T H.273; 2 is "unspecified".
_H273_PRIMARIES = {
    1: "Rec.709",
    2: "Rec.709",
    4: "BT.470 M",
    5: "BT.470 BG",
    6: "SMPTE 170M",
    7: "SMPTE 170M",
    8: "generic film",
    9: "Rec.2020",
    10: "CIE XYZ",
    11: "DCI-P3",
    12: "Display P3",
    22: "EBU 3213",
}
_H273_CURVES: dict[int, str | float] = {
    1: "rec709",
    4: 2.2,
    5: 2.8,
    6: "rec709",
    8: "linear",
    13: "srgb",
    14: "rec709",
    15: "rec709",
    16: "pq",
    17: "cinema",
    18: "hlg",
}
UNSPECIFIED = 2

#: Parts of the names of OpenImageIO, such as ``srgb_p3d65_scene``.
_OIIO_NAME = re.compile(r"(lin|srgb|pq|hlg|g\d\d)_(\w+?)(?:_scene|_display)?")
_OIIO_PRIMARIES = {
    "rec709": "Rec.709",
    "srgb": "Rec.709",
    "p3d65": "Display P3",
    "rec2020": "Rec.2020",
    "adobergb": "Adobe RGB",
    "ap0": "ACES AP0",
    "ap1": "ACES AP1",
    "ciexyzd65": "CIE XYZ",
}
_OIIO_CURVES = {"lin": "linear", "srgb": "srgb", "pq": "pq", "hlg": "hlg"}


def linear(chromaticities: p.Chromaticities | tuple[float, ...], name: str) -> Space:
    """Linear space with these primaries.

    Raises
    ------
    ValueError
        If no colours can have these primaries.
    """
    matrix = p.to_rec709(chromaticities)
    return Space(None, matrix, "", "" if matrix is None else name)


def by_name(name: str) -> Space | None:
    """Space with a name of `NAMES`, in any case and with any marks between words."""
    key = re.sub(r"[\s_.-]", "", name.lower())
    if key not in _BY_KEY:
        return None
    curve, primaries = _NAMES[_BY_KEY[key]]
    return _space(*_CURVES[curve], primaries)


def power(exponent: float) -> tuple[Curve | None, str]:
    """Power law, and its name."""
    if abs(exponent - 1) < 1e-3:
        return None, ""
    return Power(exponent), f"a power law of exponent {exponent:.3g}"


def by_cicp(cicp: tuple[int, int, int, int], bits: int) -> Space | None:
    """Colour space of codes of ITU-T H.273; None for codes without a conversion here.

    A full range of 0 asks for integers of `bits` bits in the narrow range of video.
    """
    curve_of, primaries = _H273_CURVES.get(cicp[1]), _H273_PRIMARIES.get(cicp[0])
    if curve_of is None or primaries is None:
        return None
    curve, words = power(curve_of) if isinstance(curve_of, float) else _CURVES[curve_of]
    if not cicp[3]:
        curve = curves.narrow_range(curve or Power(1.0), bits)
        words = f"{words or 'linear values'}, in the narrow range of video"
    return _space(curve, words, primaries)


def by_openimageio_name(name: str) -> Space | None:
    """Space with a name of OpenImageIO; None for unknown names."""
    parts = re.fullmatch(_OIIO_NAME, name.lower())
    if parts is None or parts[2] not in _OIIO_PRIMARIES:
        return by_name(name)
    is_power = parts[1].startswith("g")
    curve, words = power(int(parts[1][1:]) / 10) if is_power else _CURVES[_OIIO_CURVES[parts[1]]]
    return _space(curve, words, _OIIO_PRIMARIES[parts[2]])


def _space(curve: Curve | None, words: str, primaries: str) -> Space:
    if primaries == "CIE XYZ":
        return Space(curve, p.xyz_to_rec709(), words, primaries)
    return linear(_PRIMARIES[primaries], primaries)._replace(curve=curve, curve_name=words)


SRGB = _space(*_CURVES["srgb"], "Rec.709")
LINEAR = _space(*_CURVES["linear"], "Rec.709")
