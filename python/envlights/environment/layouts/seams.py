"""Comparison of the seams of a cube map, to find the order in which the edges of faces fit."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._common.blocks import in_blocks
from envlights.environment.layouts.conventions import FACES
from envlights.kernels.image import LUMINANCE

#: Number of rows of the grid on which pictures are compared.
_ROWS = 128
#: Twelve edges: face and side, neighbouring face and side, and reading direction of the second
#: side.
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
#: Largest score of an order that fits. In the test maps, right orders score up to 0.9, wrong orders
#: 3.8 and more.
_FITS = 1.5
#: Smallest ratio of the second-best score to the best. In these maps it is 3.8 and more.
_APART = 2.5
#: Approximate number of pairs of neighbouring rows to compare; faces of up to 256 pixels are
#: compared completely.
_PAIRS = 128
#: Luminance relative to the mean, below which steps of its logarithm are noise.
_DARK = 1e-3


class Evidence(NamedTuple):
    """Result of comparing orders by their seams."""

    chosen: str
    """Order that fits; empty if the seams are inconclusive."""

    scores: dict[str, float]
    """Score of each order: step of log luminance at edges relative to the step inside."""

    def fits(self, order: str) -> bool:
        """True if the edges fit in this order."""
        return self.scores[order] < _FITS


def lines_of_faces(n: int) -> NDArray[np.intp]:
    """Rows (and columns) to compare in a face of n x n pixels: the outer ones, and pairs.

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
    """Mean step of log luminance across edges, relative to the mean step inside.

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
    """Mean step from the rows `firsts` to the next rows; 0 if there are none."""
    if not firsts.size:
        return 0.0
    steps = [np.abs(face[firsts + 1] - face[firsts]).mean(dtype=np.float64) for face in logs]
    return float(np.mean(steps))


def compare(
    candidates: dict[str, NDArray[np.float32]],
    faces: Collection[str] = FACES,
    lines: NDArray[np.intp] | None = None,
) -> Evidence:
    """Order whose seams fit, and fit much better than all others.

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
    evidence = Evidence("", scores)
    return evidence._replace(chosen=best) if is_clear and evidence.fits(best) else evidence


def contradicts(evidence: Evidence, order: str) -> bool:
    """True if the seams favour an order other than the one that names or metadata state."""
    return bool(evidence.chosen) and evidence.chosen != order


def equal_edges(faces: NDArray[Any]) -> float | None:
    """Fraction of the edges with equal samples on both faces; None if an edge contradicts.

    An edge shows them if its samples vary along it, and are not those of the next line inside.
    A lamp across one edge of a black world varies there, and in cells too both sides can be equal.

    Parameters
    ----------
    faces : ndarray, shape (6, n, n, ...)
        Upright faces in the order of `FACES`.
    """
    if faces.shape[1] < 2:
        return None
    at = dict(zip(FACES, faces, strict=True))
    inner = dict(zip(FACES, faces[:, 1:-1, 1:-1], strict=True))
    shown = 0
    for one, s, other, t, turn in _EDGES:
        line = _side(at[one], s)
        if not np.array_equal(line, _side(at[other], t)[::turn]):
            return None
        is_line_inside = faces.shape[1] > 2 and np.array_equal(line[1:-1], _side(inner[one], s))
        shown += bool((line != line[:1]).any()) and not is_line_inside
    return shown / len(_EDGES)


def every_nth(samples: NDArray[Any]) -> NDArray[Any]:
    """Every n-th row and column, about 128 of them."""
    step = max(min(samples.shape[:2]) // _ROWS, 1)
    return samples[::step, ::step]


def log_luminance(samples: NDArray[Any]) -> NDArray[np.float32]:
    """Logarithm of the luminance, relative to its mean, of samples (..., channels)."""
    if samples.shape[-1] >= 3:
        weights = LUMINANCE.astype(np.float32)
        shape = samples.shape[:-1]
        # Ignore samples beyond single precision, which become infinite or NaN.
        with np.errstate(over="ignore", invalid="ignore"):
            grey = in_blocks(shape, lambda at: samples[at][..., :3].astype(np.float32) @ weights)
    else:
        grey = samples[..., 0].astype(np.float32)
    grey = np.nan_to_num(grey, nan=0.0, posinf=1e30, neginf=0.0).clip(0, 1e30)
    mean = float(grey.mean(dtype=np.float64)) or 1.0
    logs: NDArray[np.float32] = np.log(grey / np.float32(mean) + _DARK)
    return logs


def _side(face: NDArray[Any], side: str) -> NDArray[Any]:
    """Outer row or column of a face: top, bottom, left or right."""
    lines: dict[str, NDArray[Any]]
    lines = {"t": face[0], "b": face[-1], "l": face[:, 0], "r": face[:, -1]}
    return lines[side]
