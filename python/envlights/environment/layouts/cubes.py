"""Cube maps: names of the files, faces in a picture, and their order by the seams."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from functools import partial
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from envlights._common.blocks import in_blocks
from envlights._common.errors import FileError
from envlights._native import EnvLightsError
from envlights.environment.files.hints import Hints
from envlights.environment.layouts.conventions import (
    CONVENTIONS,
    CROSSES,
    DISTINCT,
    FACES,
    Cross,
    title_of,
)
from envlights.environment.layouts.picture_layout import PictureLayout, cube
from envlights.environment.layouts.projections import (
    REGISTRATIONS,
    Layout,
    argument_for,
    candidates,
)
from envlights.environment.layouts.records import ArrangedPicture, Origin
from envlights.kernels.image import LUMINANCE

#: Rows of the grid on which pictures are compared.
_ROWS = 128
#: Sides of a complete DDS cube.
_SIDES = "+x -x +y -y +z -z"
#: Orders whose files have the names of axes.
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
        Share of each pixel that is seen, of the same arrangement.
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
    lines = lines_of_faces(side)
    logs = log_luminance(_sample_of(samples, lines, side))
    # Vertical crosses differ in one face.
    faces = ("back",) if orders[0].startswith("vertical") else FACES
    evidence = compare({order: upright_of(logs, order) for order in orders}, faces, lines)
    order = _order(evidence, hints, layout, recognised_by)
    upright = upright_of(samples, order.name)
    is_border, notes = _registration(upright, order, layout)
    n = upright.shape[1]
    made = cube(n, border_sampled=is_border)
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
    """True if each of the squares, (k, n, n, channels), has one luminance, up to JPEG noise."""
    return all(
        np.ptp(every_nth(square).astype(np.float32), axis=(0, 1)).max() <= _tolerance(square)
        for square in samples
    )


def _tolerance(square: NDArray[Any]) -> float:
    """Largest difference of samples of an empty square: noise of JPEG codes, or rounding."""
    return max(0.02 * float(np.abs(square).max(initial=0)), 2e-3)


def every_nth(samples: NDArray[Any]) -> NDArray[Any]:
    """Every n-th row and column, about 128 of them."""
    step = max(min(samples.shape[:2]) // _ROWS, 1)
    return samples[::step, ::step]


def _possible_orders(samples: NDArray[Any]) -> tuple[str, ...]:
    """Orders that the shape admits; one for each that pixels can distinguish."""
    if samples.ndim == 4:
        return DISTINCT if samples.shape[0] == 6 and samples.shape[1] == samples.shape[2] else ()
    height, width = samples.shape[:2]
    return DISTINCT if is_strip(height, width) else crosses_of(height, width)


def _side_of(samples: NDArray[Any], order: str) -> int:
    """Rows of a face in a picture."""
    height, width = (int(side) for side in samples.shape[-3:-1])
    if samples.ndim == 4:
        return height
    return height // CROSSES[order].rows if order in CROSSES else min(height, width)


def _sample_of(samples: NDArray[Any], lines: NDArray[np.intp], n: int) -> NDArray[Any]:
    """Some rows and columns of each face, in the arrangement of the picture."""
    if samples.ndim == 4:
        faces: NDArray[Any] = samples[:, lines[:, None], lines]
        return faces
    rows, columns = ((lines + np.arange(0, side, n)[:, None]).ravel() for side in samples.shape[:2])
    picture: NDArray[Any] = samples[rows[:, None], columns]
    return picture


def _upright(samples: NDArray[Any], order: str, *, is_faces: bool) -> NDArray[Any]:
    """Six upright faces of six faces or of a picture; axes after the pixels stay."""
    if order in CROSSES:
        return faces_of_cross(samples, order)
    return upright_faces(samples if is_faces else split_strip(samples), order)


def _stack(faces: NDArray[Any], layout: PictureLayout) -> NDArray[Any]:
    return np.ascontiguousarray(faces).reshape(layout.height, layout.width, *faces.shape[3:])


def _order(evidence: Evidence, hints: Hints, layout: Layout, recognised_by: str) -> _Order:
    """Order by argument, by metadata or names unless the seams decide on another, or by seams."""
    if layout.faces is not None:
        return _order_of_argument(layout.faces, hints.order, evidence)
    stated, by = _stated_order(hints)
    if stated and set(evidence.scores) == {*DISTINCT}:
        return _order_of_statement(stated, by, evidence)
    if len(evidence.scores) == 1:  # a horizontal cross
        (name,) = evidence.scores
        by = recognised_by if recognised_by != "argument" else "shape"
        fits = evidence.scores[name] < FITS
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
    return _Order(name, "argument")


def _order_of_statement(name: str, by: str, evidence: Evidence) -> _Order:
    source = "the names of the files" if by == "name" else "the metadata"
    distinct = _distinct(name)
    if not contradicts(evidence, distinct):
        note = f"faces in {title_of(name)}, by {source}"
        if evidence.scores[distinct] >= FITS:
            note += _doubt(evidence)
        return _Order(name, by, (note,))
    note = (
        f"faces in {title_of(evidence.chosen)}, by their seams; {source} name"
        f" {title_of(name)}, whose edges do not fit: {_scores(evidence)}"
    )
    return _Order(evidence.chosen, "seams", (note,))


def _stated_order(hints: Hints) -> tuple[str, str]:
    """Order that names or metadata determine, and its evidence; empty without one."""
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
    if has_equal_edges(upright):
        note = "the edges of the faces are equal, so the samples lie on them (border-sampled)"
        return True, (note,)
    return False, ()


def _name_of(order: _Order, *, is_border: bool) -> str:
    """Name of a convention; of equal orders, the one with this registration."""
    if order.recognised_by == "seams" and order.name == "py360convert" and not is_border:
        return "pannellum"
    return order.name


def _distinct(name: str) -> str:
    """Name of the convention with the same order that the seams distinguish."""
    if name in CROSSES:
        return name
    wanted = CONVENTIONS[name]
    for other in DISTINCT:
        convention = CONVENTIONS[other]
        if (convention.faces, convention.turns) == (wanted.faces, wanted.turns):
            return other
    return name


def _possible_names(evidence: Evidence) -> list[str]:
    """Names of the orders that the shape admits."""
    return [name for name in (*CONVENTIONS, *CROSSES) if _distinct(name) in evidence.scores]


def _scores(evidence: Evidence) -> str:
    each = (f"{name} {score:.2g}" for name, score in evidence.scores.items())
    return "step across the edges over the step inside: " + ", ".join(each)


def _doubt(evidence: Evidence) -> str:
    """End of a note on faces whose edges do not fit."""
    return (
        f", but their edges do not fit, so that faces may be turned or swapped; {_scores(evidence)}"
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


#: Twelve edges: face and side, face and side, and the direction in which the second one is read.
_EDGES = (
    ("front", "r", "right", "l", 1),
    ("right", "r", "back", "l", 1),
    ("back", "r", "left", "l", 1),
    ("left", "r", "front", "l", 1),
    ("up", "b", "front", "t", 1),
    ("up", "r", "right", "t", -1),
    ("up", "t", "back", "t", -1),
    ("up", "l", "left", "t", 1),
    ("down", "t", "front", "b", 1),
    ("down", "r", "right", "b", 1),
    ("down", "b", "back", "b", -1),
    ("down", "l", "left", "b", -1),
)
#: Largest score of an order that fits. Right orders of the maps in the tests have up to 0.9, wrong
#: ones 3.8 and more.
FITS = 1.5
#: Smallest ratio of the second score to the first. It is 3.8 and more for the same maps.
_APART = 2.5
#: Pairs of neighbouring rows of a face that are compared, about; faces of 256 pixels are whole.
_PAIRS = 128
#: Luminance, relative to the mean, below which steps of its logarithm are noise.
_DARK = 1e-3


class Evidence(NamedTuple):
    """Result of a comparison of orders by their seams."""

    chosen: str
    """Order that fits; empty if the seams decide on none."""

    scores: dict[str, float]
    """Step of log luminance across the edges, divided by the mean step inside, by order."""


def lines_of_faces(n: int) -> NDArray[np.intp]:
    """Rows, and columns, of a face of n x n pixels that are compared: the outer ones, and pairs.

    Large faces are sampled, so that the comparison needs little memory. Read from the other end the
    lines are the same.
    """
    step = max(n // _PAIRS, 1)
    firsts = np.arange(0, n, step)
    lines = np.concatenate([firsts, firsts + 1, [n - 1]])
    lines = lines[lines < n]
    return np.unique(np.concatenate([lines, n - 1 - lines]))


def seam_score(
    logs: NDArray[np.float32],
    faces: Collection[str] = FACES,
    lines: NDArray[np.intp] | None = None,
) -> float:
    """Mean step of log luminance across edges, divided by the mean step inside.

    Parameters
    ----------
    logs : ndarray, shape (6, n, n)
        Result of `log_luminance`, as upright faces in the order of `FACES`.
    faces : collection of str
        Names of faces whose edges count.
    lines : ndarray, optional
        Result of `lines_of_faces`, if only these rows and columns are given.

    Returns
    -------
    float
        About 1 or less where the faces fit, 0 for border samples; 1 for a constant picture.
    """
    at = dict(zip(FACES, logs, strict=True))
    steps = [
        np.abs(_side(at[one], s) - _side(at[other], t)[::turn]).mean(dtype=np.float64)
        for one, s, other, t, turn in _EDGES
        if one in faces or other in faces
    ]
    lines = np.arange(logs.shape[1]) if lines is None else lines
    firsts = np.flatnonzero(np.diff(lines) == 1)
    inside = (_mean_step(logs, firsts) + _mean_step(logs.swapaxes(1, 2), firsts)) / 2
    across = float(np.mean(steps))
    if inside == 0:
        return 1.0 if across == 0 else float("inf")
    return across / inside


def _mean_step(logs: NDArray[np.float32], firsts: NDArray[np.intp]) -> float:
    """Mean step from some rows to the next ones; 0 without any."""
    if not firsts.size:
        return 0.0
    steps = [np.abs(face[firsts + 1] - face[firsts]).mean(dtype=np.float64) for face in logs]
    return float(np.mean(steps))


def compare(
    candidates: dict[str, NDArray[np.float32]],
    faces: Collection[str] = FACES,
    lines: NDArray[np.intp] | None = None,
) -> Evidence:
    """Order whose seams fit and fit much better than all others.

    Parameters
    ----------
    candidates : dict
        Result of `log_luminance` as upright faces, by the name of the order.
    faces : collection of str
        Names of the faces that differ between the candidates.
    lines : ndarray, optional
        Result of `lines_of_faces`, if only these rows and columns are given.
    """
    scores = {order: seam_score(logs, faces, lines) for order, logs in candidates.items()}
    best, *others = sorted(scores, key=scores.__getitem__)
    is_clear = all(scores[other] > max(_APART * scores[best], 1e-9) for other in others)
    return Evidence(best if scores[best] < FITS and is_clear else "", scores)


def contradicts(evidence: Evidence, order: str) -> bool:
    """True if the seams decide on another order than one that is known by name."""
    return bool(evidence.chosen) and evidence.chosen != order


def has_equal_edges(faces: NDArray[Any]) -> bool:
    """True if the faces share the samples on all edges, and not because they are constant there.

    Parameters
    ----------
    faces : ndarray, shape (6, n, n, ...)
        Upright faces in the order of `FACES`.
    """
    if faces.shape[1] < 2:
        return False
    at = dict(zip(FACES, faces, strict=True))
    are_equal = all(
        np.array_equal(_side(at[one], s), _side(at[other], t)[::turn])
        for one, s, other, t, turn in _EDGES
    )
    if not are_equal:
        return False
    inner = faces[:, 1:-1, 1:-1] if faces.shape[1] > 2 else faces
    return not all(
        np.array_equal(_side(face, s)[1:-1], _side(small, s))
        for face, small in zip(faces, inner, strict=True)
        for s in "tblr"
    )


def log_luminance(samples: NDArray[Any]) -> NDArray[np.float32]:
    """Logarithm of the luminance, relative to its mean, (...), of samples (..., channels)."""
    if samples.shape[-1] >= 3:
        weights = LUMINANCE.astype(np.float32)
        shape = samples.shape[:-1]
        # Samples beyond single precision become infinite, and infinity times 0 is NaN.
        with np.errstate(over="ignore", invalid="ignore"):
            grey = in_blocks(shape, lambda at: samples[at][..., :3].astype(np.float32) @ weights)
    else:
        grey = samples[..., 0].astype(np.float32)
    grey = np.nan_to_num(grey, nan=0.0, posinf=1e30, neginf=0.0).clip(0, 1e30)
    mean = float(grey.mean(dtype=np.float64)) or 1.0
    logs: NDArray[np.float32] = np.log(grey / np.float32(mean) + _DARK)
    return logs


def _side(face: NDArray[Any], side: str) -> NDArray[Any]:
    """Outer line of samples: top, bottom, left or right."""
    lines: dict[str, NDArray[Any]]
    lines = {"t": face[0], "b": face[-1], "l": face[:, 0], "r": face[:, -1]}
    return lines[side]


_Samples = TypeVar("_Samples", bound=np.generic)

#: Arrangements of six faces in one picture.
ARRANGEMENTS: tuple[str, ...] = ("stack", "strip", *CROSSES)


def upright_faces(stored: NDArray[_Samples], order: str) -> NDArray[_Samples]:
    """Six upright faces, (6, n, n, ...), in the order of `FACES`.

    Parameters
    ----------
    stored : ndarray, shape (6, n, n, ...)
        Faces in the order of a convention.
    order : str
        Name in `CONVENTIONS`.
    """
    convention = CONVENTIONS[order]
    if convention.faces == FACES and not any(convention.turns):
        return stored
    each = zip(stored, convention.faces, convention.turns, strict=True)
    upright = {face: np.rot90(picture, turns) for picture, face, turns in each}
    return np.stack([upright[face] for face in FACES])


def stored_faces(upright: NDArray[_Samples], order: str) -> NDArray[_Samples]:
    """Faces as a convention stores them, (6, n, n, ...), from six upright ones."""
    convention = CONVENTIONS[order]
    each = zip(convention.faces, convention.turns, strict=True)
    return np.stack([np.rot90(upright[FACES.index(face)], -turns) for face, turns in each])


def split_strip(image: NDArray[_Samples]) -> NDArray[_Samples]:
    """Six squares of a picture of 6:1 or 1:6, (6, n, n, ...), in its order."""
    height, width = image.shape[:2]
    if height > width:
        return image.reshape(6, width, width, *image.shape[2:])
    squares = image.reshape(height, 6, height, *image.shape[2:])
    return squares.swapaxes(0, 1)


def faces_of_cross(image: NDArray[_Samples], order: str) -> NDArray[_Samples]:
    """Six upright faces, (6, n, n, ...), of an unfolded cube."""
    cross = CROSSES[order]
    each = zip(cross.places, cross.turns, strict=True)
    return np.stack([np.rot90(_square(image, cross, place), turns) for place, turns in each])


def outside_of_cross(image: NDArray[_Samples], order: str) -> NDArray[_Samples]:
    """Six squares of the grid, (6, n, n, ...), that hold no face."""
    cross = CROSSES[order]
    grid = ((row, column) for row in range(cross.rows) for column in range(cross.columns))
    return np.stack([_square(image, cross, at) for at in grid if at not in cross.places])


def cross_of_faces(upright: NDArray[_Samples], order: str) -> NDArray[_Samples]:
    """Unfolded cube of six upright faces; 0 beside them."""
    cross, n = CROSSES[order], upright.shape[1]
    image = np.zeros((cross.rows * n, cross.columns * n, *upright.shape[3:]), upright.dtype)
    for face, place, turns in zip(upright, cross.places, cross.turns, strict=True):
        _square(image, cross, place)[...] = np.rot90(face, -turns)
    return image


def arranged_faces(upright: NDArray[Any], order: str, arrangement: str) -> NDArray[Any]:
    """One picture of six upright faces: a stack or a strip in an order, or a cross."""
    if arrangement in CROSSES:
        return cross_of_faces(upright, arrangement)
    stored = stored_faces(upright, order)
    n = stored.shape[1]
    if arrangement == "stack":
        return stored.reshape(6 * n, n, *stored.shape[3:])
    return stored.swapaxes(0, 1).reshape(n, 6 * n, *stored.shape[3:])


def _square(image: NDArray[_Samples], cross: Cross, place: tuple[int, int]) -> NDArray[_Samples]:
    """View of one square of the grid."""
    n = image.shape[0] // cross.rows
    row, column = (n * index for index in place)
    return image[row : row + n, column : column + n]


def is_strip(height: int, width: int) -> bool:
    """True for a size of 6:1 or 1:6."""
    return max(height, width) == 6 * min(height, width)


def crosses_of(height: int, width: int) -> tuple[str, ...]:
    """Names of the crosses with the aspect of a size."""
    return tuple(
        name
        for name, cross in CROSSES.items()
        if height * cross.columns == width * cross.rows and height % cross.rows == 0
    )


def check_square(sizes: dict[str, tuple[int, int]]) -> None:
    """Refuse faces that are no squares of one size; the keys name them in the sentence."""
    for name, (height, width) in sizes.items():
        if height != width:
            raise EnvLightsError(
                f"the faces of a cube are squares; {name} has {width}x{height} pixels; give six"
                " squares of one size"
            )
    if len({*sizes.values()}) > 1:
        said = ", ".join(f"{name} {size[1]}x{size[0]}" for name, size in sizes.items())
        raise EnvLightsError(f"the faces of a cube have one size; got {said}")


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
