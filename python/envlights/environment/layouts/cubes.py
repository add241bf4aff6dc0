"""Cube maps: order of the six faces, from arguments, metadata, names or seams."""

from __future__ import annotations

import math
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import amount
from envlights._common.errors import FileError
from envlights._native import EnvLightsError
from envlights.environment.files.hints import Hints
from envlights.environment.layouts.conventions import (
    CONVENTIONS,
    CROSSES,
    DISTINCT,
    FACES,
    title_of,
)
from envlights.environment.layouts.faces import (
    crosses_of,
    faces_of_cross,
    is_strip,
    outside_of_cross,
    split_strip,
    upright_faces,
)
from envlights.environment.layouts.picture_layout import PictureLayout, cube
from envlights.environment.layouts.projections import (
    REGISTRATIONS,
    Layout,
    argument_for,
    candidates,
)
from envlights.environment.layouts.records import ArrangedPicture, Origin
from envlights.environment.layouts.seams import (
    Evidence,
    compare,
    contradicts,
    equal_edges,
    every_nth,
    lines_of_faces,
    log_luminance,
)

#: Sides of a complete DDS cube.
_SIDES = "+x -x +y -y +z -z"
#: Orders whose files are named by axes.
_AXIS_ORDERS = ("opengl", "openexr")


class _Order(NamedTuple):
    """Order of the faces, and its evidence."""

    name: str
    recognised_by: str
    notes: tuple[str, ...] = ()


def arrange_cube(
    samples: NDArray[Any],
    coverage: NDArray[Any] | None,
    hints: Hints,
    layout: Layout,
    recognised_by: str,
) -> ArrangedPicture:
    """Stack of six upright faces, (6 n, n, ...), in our order.

    Parameters
    ----------
    samples : ndarray, shape (6, n, n, channels) or (height, width, channels)
        Six faces, a stack, a strip or a cross.
    coverage : ndarray, optional
        Fraction of each pixel that is seen, of the same arrangement.
    hints, layout
        Statements of the file and of the user.
    recognised_by : str
        Evidence that it is a cube, for one whose order needs none.
    """
    orders = _possible_orders(samples)
    if not orders:
        raise _no_cube(samples, hints)
    upright_of = partial(_upright, is_faces=samples.ndim == 4)
    side = _side_of(samples, orders[0])
    view = None if layout.fov is None else math.radians(amount("fov", layout.fov, 90, 170))
    # Crop faces with a wider field of view to 90 degrees.
    margin = 0 if view is None else round(side * (1 - 1 / math.tan(view / 2)) / 2)
    lines = margin + lines_of_faces(side - 2 * margin)
    logs = log_luminance(_sample_of(samples, lines, side))
    # Vertical crosses differ only in the back face.
    faces = ("back",) if orders[0].startswith("vertical") else FACES
    evidence = compare({order: upright_of(logs, order) for order in orders}, faces, lines)
    order = _order(evidence, hints, layout, recognised_by)
    upright = upright_of(samples, order.name)
    is_border, notes = _registration(upright, order, layout)
    n = upright.shape[1]
    made = cube(n, border_sampled=is_border, field_of_view=view)
    name = _name_of(order, is_border=is_border)
    size = (6 * n, n) if samples.ndim == 4 else samples.shape[:2]
    source = Origin("cube", size, name, REGISTRATIONS[is_border], order.recognised_by, made)
    fraction = None if coverage is None else _stack(upright_of(coverage, order.name), made)
    return ArrangedPicture(_stack(upright, made), fraction, made, source, (*order.notes, *notes))


def is_unfolded_cube(picture: NDArray[Any]) -> bool:
    """True for a strip of six squares, and for a cross whose other squares are empty."""
    height, width = picture.shape[:2]
    crosses = crosses_of(height, width)
    is_cross = bool(crosses) and _is_constant(outside_of_cross(picture, crosses[0]))
    return is_strip(height, width) or is_cross


def _is_constant(samples: NDArray[Any]) -> bool:
    """True if each of the squares, (k, n, n, channels), is constant up to JPEG noise."""
    return all(
        np.ptp(every_nth(square).astype(np.float32), axis=(0, 1)).max() <= _tolerance(square)
        for square in samples
    )


def _tolerance(square: NDArray[Any]) -> float:
    """Largest deviation of samples in an empty square, due to JPEG noise or rounding."""
    return max(0.02 * float(np.abs(square).max(initial=0)), 2e-3)


def _possible_orders(samples: NDArray[Any]) -> tuple[str, ...]:
    """Orders that are possible for the shape, without orders that pixels cannot distinguish."""
    if samples.ndim == 4:
        return DISTINCT if samples.shape[0] == 6 and samples.shape[1] == samples.shape[2] else ()
    height, width = samples.shape[:2]
    return DISTINCT if is_strip(height, width) else crosses_of(height, width)


def _side_of(samples: NDArray[Any], order: str) -> int:
    """Number of rows of a face in the picture."""
    height, width = (int(side) for side in samples.shape[-3:-1])
    if samples.ndim == 4:
        return height
    return height // CROSSES[order].rows if order in CROSSES else min(height, width)


def _sample_of(samples: NDArray[Any], lines: NDArray[np.intp], n: int) -> NDArray[Any]:
    """Some rows and columns of each face, arranged as in the picture."""
    if samples.ndim == 4:
        faces: NDArray[Any] = samples[:, lines[:, None], lines]
        return faces
    rows, columns = ((lines + np.arange(0, side, n)[:, None]).ravel() for side in samples.shape[:2])
    picture: NDArray[Any] = samples[rows[:, None], columns]
    return picture


def _upright(samples: NDArray[Any], order: str, *, is_faces: bool) -> NDArray[Any]:
    """Six upright faces from six stored faces or a picture; axes after the pixels are kept."""
    if order in CROSSES:
        return faces_of_cross(samples, order)
    return upright_faces(samples if is_faces else split_strip(samples), order)


def _stack(faces: NDArray[Any], layout: PictureLayout) -> NDArray[Any]:
    return np.ascontiguousarray(faces).reshape(layout.height, layout.width, *faces.shape[3:])


def _order(evidence: Evidence, hints: Hints, layout: Layout, recognised_by: str) -> _Order:
    """Order by argument, by metadata or names unless seams contradict, or by seams."""
    if layout.faces is not None:
        return _order_of_argument(layout.faces, hints.order, evidence)
    stated, by = _stated_order(hints)
    if stated and set(evidence.scores) == {*DISTINCT}:
        return _order_of_statement(stated, by, evidence)
    if len(evidence.scores) == 1:  # a horizontal cross
        (name,) = evidence.scores
        by = recognised_by if recognised_by != "argument" else "shape"
        fits = evidence.fits(name)
        if not fits and by == "shape" and recognised_by == "shape":
            raise EnvLightsError(
                f"a picture with even corners of the shape 4:3 may be a cube map"
                f" ({argument_for(Layout.cube(faces=name))}),"
                f" but the edges of its faces do not fit ({_scores(evidence)}), or"
                f" {candidates(('planar',))}; give one of them"
            )
        return _Order(name, by, (f"faces of {title_of(name)}{'' if fits else _doubt(evidence)}",))
    if not evidence.chosen:
        raise EnvLightsError(_ambiguous(evidence))
    how = f"faces in {title_of(evidence.chosen)}, by their seams"
    return _Order(evidence.chosen, "seams", (how,))


def _order_of_argument(name: str, by_names: str, evidence: Evidence) -> _Order:
    fits = _distinct(name)
    if by_names and (fits in _AXIS_ORDERS) != (by_names in _AXIS_ORDERS):
        raise EnvLightsError(
            f"faces={name!r} contradicts the names of the files, which are those of"
            f" {title_of(by_names)}; leave out faces=, or rename the files"
        )
    if fits not in evidence.scores:
        possible = ", ".join(repr(order) for order in _possible_names(evidence))
        raise EnvLightsError(
            f"faces={name!r} does not fit the shape of the picture; give faces= {possible}"
        )
    if contradicts(evidence, fits):
        return _Order(name, "argument", (_misfit(name, evidence),))
    is_doubtful = not evidence.fits(fits)
    note = f"faces in {title_of(name)}, as stated{_doubt(evidence)}"
    return _Order(name, "argument", (note,) if is_doubtful else ())


def _order_of_statement(name: str, by: str, evidence: Evidence) -> _Order:
    source = "the names of the files" if by == "name" else "the metadata"
    distinct = _distinct(name)
    if not contradicts(evidence, distinct):
        note = f"faces in {title_of(name)}, by {source}"
        if not evidence.fits(distinct):
            note += _doubt(evidence)
        return _Order(name, by, (note,))
    note = (
        f"faces in {title_of(evidence.chosen)}, by their seams; {source} name"
        f" {title_of(name)}, whose edges do not fit: {_scores(evidence)}"
    )
    return _Order(evidence.chosen, "seams", (note,))


def _stated_order(hints: Hints) -> tuple[str, str]:
    """Order and evidence from names or metadata; empty if unknown."""
    if hints.order:
        return hints.order, "name"
    if hints.environment == "cube" and hints.kind == "openexr":
        return "openexr", "attribute"
    if hints.environment == "cube" and hints.kind == "dds":
        if hints.cube_sides not in ("", _SIDES):
            raise FileError(
                f"cannot read {hints.name}: it holds only the faces {hints.cube_sides} of a cube;"
                " give all six"
            )
        return "opengl", "attribute"
    return "", ""


def _registration(
    upright: NDArray[Any], order: _Order, layout: Layout
) -> tuple[bool, tuple[str, ...]]:
    """True for border samples, and notes."""
    if layout.registration is not None:
        return layout.registration == REGISTRATIONS[1], ()
    convention = CONVENTIONS.get(order.name)
    if order.recognised_by != "seams" and convention is not None and convention.border_sampled:
        return True, ()
    shown = equal_edges(upright) if layout.fov is None else None
    if shown is None or not (upright != upright[:1, :1, :1]).any():
        return False, ()
    if shown > 0.5:
        note = "the edges of the faces are equal, so the samples lie on them (border-sampled)"
        return True, (note,)
    border = argument_for(Layout.cube(registration=REGISTRATIONS[1]))
    note = (
        "the edges of the faces are equal, but nearly all are constant, so the samples were taken"
        f" to be cell-centred; directions are half a pixel off if they are not ({border})"
    )
    return False, (note,)


def _name_of(order: _Order, *, is_border: bool) -> str:
    """Name of a convention; among equal orders, the one with this registration."""
    if order.recognised_by == "seams" and order.name == "py360convert" and not is_border:
        return "pannellum"
    return order.name


def _distinct(name: str) -> str:
    """Name of the convention that represents an order in the seam comparison."""
    if name in CROSSES:
        return name
    wanted = CONVENTIONS[name]
    for other in DISTINCT:
        convention = CONVENTIONS[other]
        if (convention.faces, convention.turns) == (wanted.faces, wanted.turns):
            return other
    return name


def _possible_names(evidence: Evidence) -> list[str]:
    """Names of the orders that are possible for the shape."""
    return [name for name in (*CONVENTIONS, *CROSSES) if _distinct(name) in evidence.scores]


def _scores(evidence: Evidence) -> str:
    each = (f"{name} {score:.2g}" for name, score in evidence.scores.items())
    return "step across the edges over the step inside: " + ", ".join(each)


def _doubt(evidence: Evidence) -> str:
    """Addition to a note if the edges of the faces do not fit."""
    return (
        f", but their edges do not fit, so that faces may be turned, swapped or"
        f" wider than 90 degrees (fov=); {_scores(evidence)}"
    )


def _misfit(name: str, evidence: Evidence) -> str:
    return (
        f"the edges of the faces fit {title_of(evidence.chosen)}, not {title_of(name)} as"
        f" stated; {_scores(evidence)}"
    )


def _ambiguous(evidence: Evidence) -> str:
    choices = ", ".join(repr(name) for name in _possible_names(evidence))
    return (
        f"the order of the faces of a cube map cannot be decided by their edges"
        f" ({_scores(evidence)}); give faces= one of {choices}"
    )


def _no_cube(samples: NDArray[Any], hints: Hints) -> EnvLightsError:
    height, width = samples.shape[-3:-1]
    what = f"cannot read {hints.name} as a cube map: it has" if hints.name else "a cube map has"
    got = f" {width}x{height} pixels" if hints.name else f" six square faces; got {width}x{height}"
    return EnvLightsError(
        f"{what}{got}; give a stack (1:6), a strip (6:1), a horizontal cross (4:3), a vertical"
        " cross (3:4), or six squares; or layout= if it is no cube map"
    )
