"""Names of the files of a cube map, and the order of the faces that they determine."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple


class NamedOrder(NamedTuple):
    """Order of six files, and the convention that their names determine."""

    order: str
    """Name in `CONVENTIONS`; empty if the names leave it open."""

    positions: tuple[int, ...]
    """Index of the file of each face, in the order of the convention."""


#: Names of the faces in each scheme, without case, separators, and common first and last letters.
#: The convention is open where several programs use the same names for different orders.
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
#: Characters between the parts of a name; signs are parts of names.
_SEPARATORS = re.compile(r"[\s_.]+")


def order_of_names(stems: Sequence[str]) -> NamedOrder | None:
    """Order of six names without suffixes; None if they are of no scheme.

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
    """Scheme name that ends the name of a single file, such as "posx"; empty without one."""
    last = re.split(r"[\s_.]+", stem.lower())[-1]
    long_names = (token for _, tokens in _SCHEMES for token in tokens if len(token) > 1)
    return last if last in {*long_names} else ""


def _without_common(names: Sequence[str], *, signs: bool = True) -> list[str]:
    """Names without their common first and last letters, and perhaps without a dash before."""
    first = _common_start(names)
    names = [name[first:] for name in names]
    last = _common_start([name[::-1] for name in names])
    short = [name[: len(name) - last] for name in names]
    return short if signs else [name.lstrip("-") for name in short]


def _common_start(names: Sequence[str]) -> int:
    """Number of first letters that all names share."""
    columns = zip(*names, strict=False)
    return next((k for k, letters in enumerate(columns) if len({*letters}) > 1), len(min(names)))
