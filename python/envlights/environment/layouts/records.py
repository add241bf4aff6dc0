"""Arguments and results of the recognition of a picture."""

from __future__ import annotations

from typing import Any, NamedTuple

from numpy.typing import ArrayLike, NDArray

from envlights._common.check import amount, check_choice
from envlights._native import EnvLightsError
from envlights.environment.layouts.conventions import NAMES
from envlights.environment.layouts.picture_layout import MAPPINGS, PictureLayout
from envlights.environment.layouts.projections import PROJECTIONS

#: Names of the positions of samples.
REGISTRATIONS: tuple[str, str] = ("cell-centred", "border-sampled")
#: Names of the halves of a stereo picture.
EYES = ("left", "right")


class Arguments(NamedTuple):
    """Arguments of a user on the projection; None where the picture decides."""

    projection: str | None = None
    """One of `PROJECTIONS`."""

    faces: str | None = None
    """Order of the faces of a cube: one of `NAMES`."""

    registration: str | None = None
    """One of `REGISTRATIONS`."""

    mapping: str | None = None
    """Mapping of a fisheye: one of `MAPPINGS`."""

    fov: float | None = None
    """Horizontal field of view, in degrees; of a fisheye, the angle across the circle."""

    horizon: float | None = None
    """Row coordinate of elevation 0 in a cylinder or a part of a panorama."""

    circle: ArrayLike | None = None
    """Centre x, centre y and radius of a fisheye or a mirror ball, in pixels."""

    forward: ArrayLike | None = None
    """Direction of the centre of the picture; +z when left out."""

    eye: str | None = None
    """Half of a stereo panorama: "left" or "right"."""

    axes: ArrayLike | None = None
    """Unit vectors forward, right and up of the picture, from the statement of a file."""

    def names(self) -> list[str]:
        """Names of the arguments of a user that are not None, without `projection`."""
        each = zip(self._fields[1:-1], self[1:-1], strict=True)
        return [name for name, value in each if value is not None]

    def check(self) -> None:
        """Refuse values that no argument has."""
        for name, choices in (
            ("projection", tuple(PROJECTIONS)),
            ("faces", NAMES),
            ("registration", REGISTRATIONS),
            ("mapping", MAPPINGS),
            ("eye", EYES),
        ):
            if (value := getattr(self, name)) is not None:
                check_choice(name, value, choices)
        if self.fov is not None and amount("fov", self.fov, 0, 360) == 0:
            raise EnvLightsError("fov must be above 0 degrees, up to 360; got 0")


#: Arguments of a user who names nothing.
NO_ARGUMENTS: Arguments = Arguments()


class Origin(NamedTuple):
    """Origin of a map: the picture that was read, and evidence for its projection."""

    projection: str
    """Value of `projection=` that names it."""

    size: tuple[int, int]
    """Rows and columns of the picture as it was given; of six pictures, of their stack."""

    faces: str
    """Order of the faces of a cube, one of `NAMES`; empty for other projections."""

    registration: str
    """Positions of the samples: "cell-centred" or "border-sampled"."""

    recognised_by: str
    """Evidence: "attribute", "name", "shape", "seams" or "argument"."""

    layout: PictureLayout
    """Layout of the arranged samples."""


class ArrangedPicture(NamedTuple):
    """Samples of a picture, arranged for its layout."""

    samples: NDArray[Any]
    """Samples, (layout.height, layout.width, ...); the given array if nothing was moved."""

    coverage: NDArray[Any] | None
    """Share of each sample that is seen, arranged alike; None if all is seen."""

    layout: PictureLayout
    """Projection of the samples."""

    source: Origin
    """Evidence for the projection."""

    notes: tuple[str, ...]
    """Remarks on assumptions."""
