"""Conventions of cube maps: position and rotation of each face in a picture."""

from __future__ import annotations

from typing import NamedTuple

#: Names of the faces, seen from inside: front looks along +z, right along -x, left along +x.
FACES = ("front", "right", "back", "left", "up", "down")


class Convention(NamedTuple):
    """Order of six faces in a file, and the quarter turns that make each face upright."""

    title: str
    """Name for messages."""

    faces: tuple[str, ...]
    """Names of the faces, in file order."""

    names: tuple[str, ...]
    """Usual names of the files, in the same order."""

    turns: tuple[int, ...] = (0, 0, 0, 0, 0, 0)
    """Quarter turns counter-clockwise, as in `numpy.rot90`, that make each stored face upright."""

    border_sampled: bool = False
    """True if the outer samples of each face lie on its edges."""


_AXES = ("px", "nx", "py", "ny", "pz", "nz")

#: Conventions by name. The right face is +X in OpenGL, and -X in OpenEXR, whose frame is ours.
CONVENTIONS = {
    "opengl": Convention("OpenGL", ("right", "left", "up", "down", "front", "back"), _AXES),
    "openexr": Convention(
        "OpenEXR",
        ("left", "right", "up", "down", "front", "back"),
        ("+X", "-X", "+Y", "-Y", "+Z", "-Z"),
        (0, 0, 2, 2, 0, 0),
        border_sampled=True,
    ),
    "py360convert": Convention(
        "py360convert", FACES, ("F", "R", "B", "L", "U", "D"), border_sampled=True
    ),
    "pannellum": Convention("pannellum", FACES, ("0", "1", "2", "3", "4", "5")),
    "directxtex": Convention("DirectXTex", FACES, ("pz", "px", "nz", "nx", "py", "ny")),
}

#: One convention per order that pixels can distinguish: py360convert, pannellum and DirectXTex
#: share an order.
DISTINCT = ("opengl", "openexr", "py360convert")


class Cross(NamedTuple):
    """Unfolded cube: positions of the faces on a grid."""

    title: str
    """Name for messages."""

    rows: int
    """Rows of the grid."""

    columns: int
    """Columns of the grid."""

    places: tuple[tuple[int, int], ...]
    """Row and column of each of our faces, in the order of `FACES`."""

    turns: tuple[int, ...] = (0, 0, 0, 0, 0, 0)
    """Quarter turns counter-clockwise that make each stored face upright."""


_VERTICAL = ((1, 1), (1, 2), (3, 1), (1, 0), (0, 1), (2, 1))

#: Crosses by name.
CROSSES = {
    "horizontal-cross": Cross(
        "horizontal cross", 3, 4, ((1, 1), (1, 2), (1, 3), (1, 0), (0, 1), (2, 1))
    ),
    "vertical-cross": Cross(
        "vertical cross with its back face turned by 180 degrees",
        4,
        3,
        _VERTICAL,
        (0, 0, 2, 0, 0, 0),
    ),
    "vertical-cross-upright": Cross("vertical cross with its back face upright", 4, 3, _VERTICAL),
}

#: All accepted values of `faces=`.
NAMES = (*CONVENTIONS, *CROSSES)


def title_of(order: str) -> str:
    """Name of an order for messages: "the order of OpenGL", "a horizontal cross"."""
    if order in CROSSES:
        return f"a {CROSSES[order].title}"
    return f"the order of {CONVENTIONS[order].title}"
