"""Detection of 2:1 pictures that are not panoramas: dual fisheye, stereo, unmarked crops.

They are evaluated on the overview of a map, its means over blocks, which each way of a file or an
array to a map has. The numbers were chosen on 30 real maps in 6 exposures, 4 sizes and 3 codings,
and on pictures made of them with margins, noise and JPEG compression.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights._native import EnvLightsError

#: Columns of the grids for finding lenses and eyes, and for measuring seams: coarse enough to
#: average code noise and to keep stereo parallax within a cell.
_COARSE, _FINE = 64, 128

#: Deviation up to which a cell is background, relative to the contrast of disc and background:
#: noise, glare.
_EVEN = 0.2
#: Smallest background fraction of the corners, and largest radiance of a black background relative
#: to the discs.
_CORNERS, _BLACK = 0.9, 0.05
#: Disc radii relative to half the square, and offsets of disc centres.
_RADII, _OFFSETS = (0.6, 1.25), np.linspace(-0.12, 0.12, 5)
#: Smallest intersection over union of the background and the outside of a disc, for a note and for
#: an error. Real maps reach 0.36; lenses cropped at 8 % of their radius reach 0.47.
_LENSES, _SURE = 0.45, 0.7

#: Smallest correlation of the halves of a stereo picture. Real maps of studios reach 0.67, and a
#: room of six colours 0.85; stereo pictures with fine structure and JPEG compression have 0.88.
_ALIKE = 0.87
#: Bands of rows with their own parallax: the ground is nearer than the horizon.
_BANDS = 4
#: Smallest deviation of log radiance along the rows for a meaningful correlation.
_CONTRAST = 0.02

#: Smallest step across the seam of a crop, relative to the mean difference of columns two cells
#: apart: median over bands of rows. Real maps reach 0.8, and 92 % of their crops exceed 1.2; so do
#: 2 % of maps that are clipped or tilted.
_SEAM = 1.2
#: Height of the row that is compared with the outermost one, as a fraction of the image height: it
#: is 8 degrees from the pole, so that its circle is about 13 times as long.
_BESIDE_POLE = 0.047
#: Largest ratio of the deviation in the outermost row to that in the row beside it at a pole, and
#: smallest ratio in a crop.
_POLE, _NO_POLE = 0.2, 0.4

Array = NDArray[np.float64]


def notes_on_panorama(overview: NDArray[np.float32], height: int, width: int) -> tuple[str, ...]:
    """Notes on a picture that may not be a panorama; raises an error if it certainly is not.

    Parameters
    ----------
    overview : ndarray, shape (rows, columns, 3)
        Means over blocks of a picture that is read as a whole panorama.
    height, width : int
        Size of the picture.

    Raises
    ------
    EnvLightsError
        If it shows the circles of two lenses.
    """
    # Small maps have too few pixels for this test; a fit repeats it.
    if min(overview.shape[1], width) < _COARSE:
        return ()
    fine = _means(overview, _FINE)
    coarse = _means(fine, _COARSE)
    fit = _fit_of_lenses(coarse.sum(axis=2))
    what = f"a picture of {width}x{height} pixels with two discs on an even background"
    if fit >= _SURE:
        raise EnvLightsError(
            f"{what} is a dual fisheye, whose lenses only its camera knows; stitch it in the"
            " camera's program, or give layout='equirectangular' if it is a panorama"
        )
    doubts = []
    if fit >= _LENSES:
        doubts.append(f"{what} may be a dual fisheye; stitch it in the camera's program")
    if _is_one_lens(coarse.sum(axis=2)):
        doubts.append("a disc between black sides may be a fisheye picture; cut it out")
    logs = _logs(fine)
    if _has_two_eyes(_logs(coarse), logs):
        doubts.append("its halves are alike, so that it may hold two eyes; cut out one of them")
    if _is_part(logs):
        doubts.append(
            "its left and right edges do not meet, and its upper and lower rows are no poles, so"
            " that it may be a part of one or a photograph; give fov="
        )
    end = "; layout='equirectangular' reads it as a panorama without this note"
    return tuple(f"the picture may be no panorama: {doubt}{end}" for doubt in doubts)


def _means(picture: NDArray[np.floating], columns: int) -> Array:
    """Means over blocks, with at least this number of columns."""
    step = max(picture.shape[1] // columns, 1)
    height, width = (side // step * step for side in picture.shape[:2])
    # Adding slices is faster than adding axes of blocks.
    rows: Array = np.sum([picture[i:height:step] for i in range(step)], axis=0, dtype=np.float64)
    means: Array = np.sum([rows[:, i:width:step] for i in range(step)], axis=0) / step**2
    return means


def _median(cells: Array) -> float:
    """Median of all cells; `np.median` would import `numpy.ma`, which takes 11 ms."""
    middle = (cells.size - 1) // 2, cells.size // 2
    return float(np.partition(cells, middle, axis=None)[[*middle]].mean())


def _logs(cells: Array) -> Array:
    """Logarithm of radiance relative to its median, limited in the dark and at lamps."""
    middle = _median(cells) or float(cells.mean()) or 1.0
    logs: Array = np.minimum(np.log(cells / middle + 0.03), 3)
    return logs


def _fit_of_lenses(cells: Array) -> float:
    """Intersection over union of the background and the outside of the best disc, worse half."""
    columns = cells.shape[1] // 2
    halves = cells[:, :columns], cells[:, -columns:]
    y, x = ((2 * np.arange(n)[:, None] + 1) / n - 1 for n in halves[0].shape)
    corner, middle = (np.abs(y) > 0.9) & (np.abs(x.T) > 0.9), np.hypot(x.T, y) < 0.7
    if not corner.any() or not middle.any():
        return 0.0
    corners = np.stack([half[corner] for half in halves])
    background = _median(corners)
    inside = _median(np.stack([half[middle] for half in halves]))
    contrast = abs(inside - background)
    if contrast == 0 or np.mean(np.abs(corners - background) <= _EVEN * contrast) < _CORNERS:
        return 0.0
    # Wide lamps before an even sky look like lenses. A smooth sky has no outline, so its background
    # depends on the limit.
    is_black = background <= _BLACK * inside
    limits = (_EVEN,) if is_black else (_EVEN, _EVEN / 4)
    masks = (np.abs(half - background) <= limit * contrast for half in halves for limit in limits)
    fit = min(_overlap(mask, x.T, y) for mask in masks)
    return fit if is_black else min(fit, _LENSES)


def _is_one_lens(cells: Array) -> bool:
    """True if the sides are black, and the middle square has the outline of a disc."""
    side = cells.shape[1] // 4
    middle = cells[:, side:-side]
    sides = np.hstack([cells[:, : side - 1], cells[:, 1 - side :]])
    if sides.max() > _BLACK * middle.mean():
        return False
    return _fit_of_lenses(np.hstack([middle, middle])) >= _LENSES


def _overlap(background: NDArray[np.bool_], x: Array, y: Array) -> float:
    """Largest intersection over union of a mask with the outside of a disc."""
    best = 0.0
    for at_x in _OFFSETS:
        for at_y in _OFFSETS:
            radius = np.hypot(x - at_x, y - at_y).ravel()
            order = np.argsort(-radius, kind="stable")
            common = np.cumsum(background.ravel()[order])
            union = np.arange(1, len(order) + 1) + common[-1] - common
            usable = (radius[order] >= _RADII[0]) & (radius[order] <= _RADII[1])
            best = max(best, float((common / union)[usable].max(initial=0)))
    return best


def _has_two_eyes(coarse: Array, fine: Array) -> bool:
    """True if the left and right, or the upper and lower, halves show the same scene."""
    likeness = _likeness_of_eyes(coarse)
    # Few maps are half as alike, so that fine structure is rarely compared.
    if _ALIKE / 2 < likeness <= _ALIKE:
        likeness = _likeness_of_eyes(fine)
    return likeness > _ALIKE


def _likeness_of_eyes(logs: Array) -> float:
    """Likeness of the left and right, or of the upper and lower halves."""
    rows, columns = (side // 2 for side in logs.shape[:2])
    beside = _likeness(logs[:, :columns], logs[:, -columns:])
    return max(beside, _likeness(logs[:rows], logs[-rows:]))


def _likeness(one: Array, other: Array) -> float:
    """Correlation of two halves, as deviations from row means, at the best shift of each band."""
    # Move the channels first, so that the rows are contiguous.
    rows = (np.ascontiguousarray(half.transpose(2, 0, 1)) for half in (one, other))
    one, other = (half - half.mean(axis=2, keepdims=True) for half in rows)
    if min(one.std(), other.std()) < _CONTRAST:
        return 0.0
    width = one.shape[2]
    reach = width // 24
    # Without wrapping: the halves of a lamp in the middle would match those of one at the seam.
    pairs = [(one[..., by:], other[..., : width - by]) for by in range(reach + 1)]
    pairs += [(one[..., : width - by], other[..., by:]) for by in range(1, reach + 1)]
    rows_of_shifts = np.stack([(left * right).sum((0, 2)) for left, right in pairs])
    bands = np.array_split(rows_of_shifts, _BANDS, axis=1)
    common = sum(band.sum(axis=1).max() for band in bands)
    return float(common / np.sqrt((one**2).sum() * (other**2).sum()))


def _is_part(logs: Array) -> bool:
    """True if the outer columns do not match, and the outer rows are not poles."""
    height, width = logs.shape[:2]
    beside = round(_BESIDE_POLE * height)
    if beside < 1 or width < 32:
        return False
    # Average noise over bands of rows and groups of columns.
    bands = _bands(logs, 16)[1:-1]
    seam = np.abs(bands[:, 0] - bands[:, -1]).mean(axis=1)
    inside = np.abs(bands[:, 2:] - bands[:, :-2]).mean(axis=(1, 2))
    if _median(seam / (inside + 0.005)) <= _SEAM:
        return False
    groups = _bands(logs.swapaxes(0, 1), 32)
    spread = groups.std(axis=0).mean(axis=1)
    ends = (spread[0], spread[beside]), (spread[-1], spread[-1 - beside])
    is_pole = any(near < _POLE * far and far > _CONTRAST for near, far in ends)
    return not is_pole and any(near > max(_NO_POLE * far, _CONTRAST) for near, far in ends)


def _bands(logs: Array, count: int) -> Array:
    """Means over about `count` bands of rows."""
    step = max(len(logs) // count, 1)
    height = len(logs) // step * step
    bands: Array = logs[:height].reshape(height // step, step, *logs.shape[1:]).mean(axis=1)
    return bands
