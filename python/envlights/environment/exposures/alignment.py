"""Estimation and removal of small rotations and shifts between exposures.

The camera turns a little between two shots, so a picture is a rotated copy of another one: the
method of Gauss and Newton finds the rotation vector that makes the logarithms of the radiances
equal (Lucas and Kanade 1981 on the sphere). Programs also shift rows: a fourth unknown.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights.kernels.image import LUMINANCE, area_means
from envlights.kernels.sphere import direction_to_uv, pixel_directions

#: Columns of the images to compare, coarse to fine; each start is accurate to a pixel.
_WIDTHS = (256, 512, 1024)
#: Iterations at each size.
_STEPS = 6
#: Range of exposure in which pixels are compared.
_DARKEST, _BRIGHTEST = 0.004, 0.8
#: Smallest number of pixels that determine a rotation.
_FEWEST = 100
#: Scale of outliers, as a relative difference of radiance.
_OUTLIER = 0.1
#: Fraction of a pixel below which shifts are not corrected: resampling would blur more.
_LEAST_SHIFT = 0.2
#: Distance to a whole pixel below which columns or rows are rolled, which loses nothing.
_WHOLE = 0.2
#: Largest plausible shift in pixels, for at least `_MANY` pixels and for fewer.
_MOST_SHIFT, _MOST_SHIFT_OF_FEW, _MANY = 24.0, 4.0, 2000
#: Largest ratio of the differences after and before an alignment that is accepted.
_GAIN = 0.97


@dataclass(frozen=True, eq=False)
class Motion:
    """Rotation from one picture to another, and a shift of rows after it."""

    turn: NDArray[np.float64]
    """Rotation vector: axis times angle in radians, (3,)."""

    rise: float
    """Shift of the rows towards the nadir, in radians."""

    def __add__(self, other: Motion) -> Motion:
        return Motion(self.turn + other.turn, self.rise + other.rise)

    def __sub__(self, other: Motion) -> Motion:
        return Motion(self.turn - other.turn, self.rise - other.rise)

    def pixels(self, width: int) -> float:
        """Largest shift of a pixel."""
        return float(np.linalg.norm(self.turn) + abs(self.rise)) * width / (2 * np.pi)


STILL = Motion(np.zeros(3), 0.0)


def motion(
    short: NDArray[np.float32], long: NDArray[np.float32], log_ratio: float, clip: float
) -> Motion | None:
    """Motion from the shorter exposure to the longer one; None if the pixels do not determine it.

    `short` and `long` are exposures, (height, width, 3); `log_ratio` is the logarithm of the ratio
    of their times.
    """
    width = short.shape[1]
    sizes = [size for size in _WIDTHS if size < width] + [width] * (width <= _WIDTHS[-1])
    one, other = (_log_luminance(each, clip) for each in (short, long))
    both = [one, other - log_ratio]
    found = [_descend(both, sizes, unknowns) for unknowns in ([0, 1, 2], [1, 3])]
    best = min(found, key=lambda each: each[1])
    # Prefer a rotation to a shift of rows.
    if found[0][1] < 1.05 * best[1]:
        best = found[0]
    answer, after, before = best
    if not np.isfinite(after) or after > _GAIN * before:
        return STILL if np.isfinite(before) else None
    is_sure = _overlap(one, other) >= _MANY
    most = _MOST_SHIFT if is_sure else _MOST_SHIFT_OF_FEW
    is_small = answer.pixels(min(width, _WIDTHS[-1])) <= most
    return answer if is_small else None


def _log_luminance(exposure: NDArray[np.float32], clip: float) -> NDArray[np.float64]:
    """Logarithms of luminance; NaN where too dark or clipped."""
    luminance = (exposure @ LUMINANCE.astype(np.float32)).astype(np.float64)
    is_good = (luminance > _DARKEST) & (exposure.max(axis=2) < _BRIGHTEST * clip)
    return np.where(is_good, np.log(np.maximum(luminance, 1e-9)), np.nan)


def _descend(
    both: list[NDArray[np.float64]], sizes: list[int], unknowns: list[int]
) -> tuple[Motion, float, float]:
    """Motion with the smallest difference, and the differences after and before it."""
    values = np.zeros(4)
    before = after = np.inf
    for size in sizes:
        one, other = (_reduce(each, size) for each in both)
        if _overlap(one, other) < _FEWEST:
            continue
        for _ in range(_STEPS):
            step = _step(one, _sample_moved(other, values), unknowns)
            values[unknowns] += step
            if np.abs(step).max() < 0.01 * 2 * np.pi / size:
                break
        before, after = _difference(one, other), _difference(one, _sample_moved(other, values))
    return Motion(values[:3], float(values[3])), after, before


def _overlap(one: NDArray[np.float64], other: NDArray[np.float64]) -> int:
    return int(np.isfinite(one + other).sum())


def _difference(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Robust mean difference of two pictures."""
    difference = one - other
    known = difference[np.isfinite(difference)]
    if len(known) < _FEWEST:
        return np.inf
    return float(np.mean(1 - 1 / (1 + (known / _OUTLIER) ** 2)))


def _step(
    one: NDArray[np.float64], moved: NDArray[np.float64], unknowns: list[int]
) -> NDArray[np.float64]:
    """Gauss-Newton step with robust weights."""
    height, width = one.shape
    # Average both pictures, so that first-order errors of the gradient cancel.
    mean = (one + moved) / 2
    along = (np.roll(mean, -1, 1) - np.roll(mean, 1, 1)) * width / (4 * np.pi)
    down = np.full_like(mean, np.nan)
    down[1:-1] = (mean[2:] - mean[:-2]) * height / (2 * np.pi)
    rates = [_rates(height, width)[each] for each in unknowns]
    columns = [along * azimuth + down * polar for azimuth, polar in rates]
    matrix = np.stack([column.ravel() for column in columns], axis=1)
    wanted = (one - moved).ravel()
    known = np.isfinite(matrix).all(axis=1) & np.isfinite(wanted)
    if known.sum() < _FEWEST:
        return np.zeros(len(unknowns))
    matrix, wanted = matrix[known], wanted[known]
    weight = _areas(height, width).ravel()[known] / (1 + (wanted / _OUTLIER) ** 2) ** 2
    normal = matrix.T @ (weight[:, None] * matrix)
    normal += np.eye(len(unknowns)) * (1e-6 * np.trace(normal) + 1e-12)
    step = np.linalg.solve(normal, matrix.T @ (weight * wanted))
    most = 2 * 2 * np.pi / width
    return np.asarray(step * min(1.0, most / max(float(np.abs(step).max()), 1e-12)))


def _angles(height: int, width: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Polar angles and azimuths of the pixels."""
    polar = np.pi * (np.arange(height) + 0.5) / height
    azimuth = 2 * np.pi * (np.arange(width) + 0.5) / width
    return polar[:, None], azimuth[None, :]


def _areas(height: int, width: int) -> NDArray[np.float64]:
    polar, azimuth = _angles(height, width)
    return np.asarray(np.sin(polar) + 0 * azimuth)


def _rates(height: int, width: int) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Derivatives of azimuth and polar angle of a sample by each unknown.

    With d = (sin p sin a, cos p, -cos p cos a) and a turn w, the place moves by w x d.
    """
    polar, azimuth = _angles(height, width)
    cotangent = np.cos(polar) / np.sin(polar)
    zero = 0 * (polar + azimuth)
    return [
        (cotangent * np.sin(azimuth), zero - np.cos(azimuth)),
        (-1 + zero, zero),
        (-cotangent * np.cos(azimuth), zero - np.sin(azimuth)),
        (zero, 1 + zero),
    ]


def _sample_moved(picture: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Picture sampled at the moved positions; NaN if a neighbour is NaN."""
    height, width = picture.shape
    directions = pixel_directions(height, width) @ rotation(values[:3]).T
    uv = direction_to_uv(directions.reshape(-1, 3)).reshape(height, width, 2)
    x = uv[..., 0] * width - 0.5
    y = (uv[..., 1] + values[3] / np.pi) * height - 0.5
    y = np.clip(y, 0, height - 1)
    left, top = np.floor(x).astype(int), np.minimum(np.floor(y).astype(int), height - 2)
    right, down = (x - left), (y - top)
    rows = [
        picture[top + i, left % width] * (1 - right) + picture[top + i, (left + 1) % width] * right
        for i in (0, 1)
    ]
    return np.asarray(rows[0] * (1 - down) + rows[1] * down)


def rotation(turn: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotation matrix of a rotation vector (Rodrigues)."""
    angle = float(np.linalg.norm(turn))
    x, y, z = turn / angle if angle else turn
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)


def _reduce(picture: NDArray[np.float64], width: int) -> NDArray[np.float64]:
    """Means of blocks of pixels; NaN if a block contains NaN."""
    factor = max(picture.shape[1] // width, 1)
    height, width = (size // factor for size in picture.shape)
    return area_means(picture[: height * factor, : width * factor], height, width)


def positions(motions: list[Motion | None]) -> list[Motion]:
    """Motion of each picture, relative to the picture closest to all others.

    `motions` lead from each picture to the next; None counts as none.
    """
    chain = [STILL]
    for step in motions:
        chain.append(chain[-1] + (STILL if step is None else step))
    reference = min(chain, key=lambda each: sum((each - other).pixels(1) for other in chain))
    return [each - reference for each in chain]


def align(picture: NDArray[np.float32], move: Motion) -> NDArray[np.float32]:
    """Picture with its motion removed: rolled by whole pixels if possible, otherwise resampled."""
    height, width, _ = picture.shape
    columns = move.turn[1] * width / (2 * np.pi)
    rows = move.rise * height / np.pi
    tilt = np.hypot(move.turn[0], move.turn[2]) * width / (2 * np.pi)
    if abs(rows) > _WHOLE:
        picture = picture[np.clip(np.arange(height) + round(rows), 0, height - 1)]
    if tilt <= _WHOLE and abs(columns - round(columns)) <= _WHOLE:
        return np.ascontiguousarray(np.roll(picture, round(columns), axis=1))
    return _native.rotate_map(np.ascontiguousarray(picture), rotation(move.turn).T)


def is_moved(move: Motion, width: int) -> bool:
    """True if a motion is large enough to be removed."""
    return move.pixels(width) > _LEAST_SHIFT
