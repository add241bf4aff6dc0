"""Recognition of the order of cube faces from their file names."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple


class NamedOrder(NamedTuple):
    """Order of six files, and the convention that their names imply."""

    order: str
    """Name in `CONVENTIONS`; empty if several conventions use these names."""

    positions: tuple[int, ...]
    """File index of each face, in the order of the convention."""


#: Face names in each scheme, without case, separators, and common prefix and suffix. The convention
#: is empty where programs use the same names for different orders.
_SCHEMES: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("opengl", ("px", "nx", "py", "ny", "pz", "nz")),
    ("opengl", ("posx", "negx", "posy", "negy", "posz", "negz")),
    ("opengl", ("xp", "xn", "yp", "yn", "zp", "zn")),
    ("opengl", ("xpos", "xneg", "ypos", "yneg", "zpos", "zneg")),
    ("openexr", ("+x", "-x", "+y", "-y", "+z", "-z")),
    ("py360convert", ("f", "r", "b", "l", "u", "d")),
    ("", ("0", "1", "2", "3", "4", "5")),
    ("", ("1", "2", "3", "4", "5", "6")),
    *(
        ("pannellum", ("front", "right", "back", "left", *poles))
        for poles in (("up", "down"), ("top", "bottom"), ("top", "down"))
    ),
    *(
        ("pannellum", ("ft", "rt", "bk", "lf", *poles))
        for poles in (("up", "dn"), ("tp", "bt"), ("up", "down"))
    ),
)
#: Characters between the parts of a name; plus and minus signs belong to the names.
_SEPARATORS = re.compile(r"[\s_.]+")


def order_of_names(stems: Sequence[str]) -> NamedOrder | None:
    """Order of six names without suffixes; None if they match no scheme.

    Parts that all names have in common are ignored: "sky_px_1k" is read as "px".

    Examples
    --------
    >>> order_of_names(["sky_nx", "sky_ny", "sky_nz", "sky_px", "sky_py", "sky_pz"]).positions
    (3, 0, 4, 1, 5, 2)
    """
    names = [_SEPARATORS.sub("", stem.lower()) for stem in stems]
    for variants in (names, _without_common(names), _without_common(names, signs=False)):
        for order, tokens in _SCHEMES:
            if sorted(variants) == sorted(tokens):
                positions = tuple(variants.index(token) for token in tokens)
                return NamedOrder(order, positions)
    return None


def face_of_name(stem: str) -> str:
    """Face name at the end of a file name, such as "posx"; empty if there is none."""
    last = re.split(r"[\s_.]+", stem.lower())[-1]
    long_names = (token for _, tokens in _SCHEMES for token in tokens if len(token) > 1)
    return last if last in {*long_names} else ""


def _without_common(names: Sequence[str], *, signs: bool = True) -> list[str]:
    """Names without their common prefix and suffix, and without a leading dash unless `signs`."""
    first = _common_start(names)
    names = [name[first:] for name in names]
    last = _common_start([name[::-1] for name in names])
    short = [name[: len(name) - last] for name in names]
    return short if signs else [name.lstrip("-") for name in short]


def _common_start(names: Sequence[str]) -> int:
    """Length of the common prefix."""
    columns = zip(*names, strict=False)
    return next((k for k, letters in enumerate(columns) if len({*letters}) > 1), len(min(names)))
