"""Results of the recognition of a picture."""

from __future__ import annotations

from typing import Any, NamedTuple

from numpy.typing import NDArray

from envlights.environment.layouts.picture_layout import PictureLayout


class Origin(NamedTuple):
    """Original picture of a map, and evidence for its projection."""

    projection: str
    """Name of the projection; see `Layout`."""

    size: tuple[int, int]
    """Rows and columns of the original picture; for six pictures, of their stack."""

    faces: str
    """Order of the faces of a cube, as in `Layout.cube`; empty for other projections."""

    registration: str
    """Positions of the samples: "cell-centred" or "border-sampled"."""

    recognised_by: str
    """Evidence: "attribute", "name", "shape", "seams" or "argument"."""

    layout: PictureLayout
    """Layout of the arranged samples."""


class ArrangedPicture(NamedTuple):
    """Samples of a picture, arranged for its layout."""

    samples: NDArray[Any]
    """Samples, (layout.height, layout.width, ...); not a copy if nothing was moved."""

    coverage: NDArray[Any] | None
    """Coverage of each sample, in the same arrangement; None if complete."""

    layout: PictureLayout
    """Projection of the samples."""

    source: Origin
    """Evidence for the projection."""

    notes: tuple[str, ...]
    """Notes on assumptions."""
