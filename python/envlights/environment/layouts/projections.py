"""Projections that a user can name, and the sentences that list them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from envlights._native import EnvLightsError


class Projection(NamedTuple):
    """A projection that a user can name."""

    title: str
    """Name in a sentence, with its article."""

    example: str
    """Arguments that name it."""

    arguments: tuple[str, ...]
    """Names of the other arguments that it takes."""


_DISC = ("circle", "forward")

#: Projections by the value of `projection=`.
PROJECTIONS = {
    "equirectangular": Projection(
        "an equirectangular panorama or a part of one",
        "projection='equirectangular', fov=360",
        ("registration", "fov", "horizon", "eye"),
    ),
    "cylinder": Projection(
        "a cylindrical panorama", "projection='cylinder', fov=360", ("fov", "horizon")
    ),
    "cube": Projection(
        "a cube map", "projection='cube', faces='opengl'", ("faces", "registration")
    ),
    "octahedral": Projection("an octahedral map", "projection='octahedral'", ("forward",)),
    "octahedral-equal-area": Projection(
        "an equal-area octahedral map, as of pbrt",
        "projection='octahedral-equal-area'",
        ("forward",),
    ),
    "angular": Projection("an angular map or light probe", "projection='angular'", ("forward",)),
    "mirror-ball": Projection(
        "a photograph of a mirror ball", "projection='mirror-ball'", ("circle",)
    ),
    "fisheye": Projection(
        "a fisheye picture",
        "projection='fisheye', mapping='equidistant', fov=180",
        ("mapping", "fov", *_DISC),
    ),
    "planar": Projection("a photograph", "projection='planar', fov=65", ("fov", "forward")),
}

#: Discs in a black square.
DISCS = ("angular", "mirror-ball", "fisheye")
#: Squares without black corners.
SQUARES = ("octahedral", "octahedral-equal-area")


def candidates(names: Iterable[str]) -> str:
    """List of projections for a sentence, each with its arguments."""
    each = [f"{PROJECTIONS[name].title} ({PROJECTIONS[name].example})" for name in names]
    return " or ".join([", ".join(each[:-1]), each[-1]] if len(each) > 1 else each)


def check_unused(projection: str, given: Iterable[str]) -> None:
    """Refuse arguments that a projection does not take."""
    taken = PROJECTIONS[projection].arguments
    if others := [name for name in given if name not in taken]:
        allowed = f"it takes {', '.join(taken)}" if taken else "it takes no other arguments"
        raise EnvLightsError(
            f"{', '.join(others)} is no argument of {PROJECTIONS[projection].title}; {allowed};"
            " leave the others out"
        )
