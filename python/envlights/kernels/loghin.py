"""Steps of Loghin (2021), for maps and for plane images.

`envlights.papers.loghin.detect` combines them for a map. For a plane image the samples come from
`halton` instead of the sphere:

>>> import numpy as np
>>> from envlights import kernels
>>> image = np.full((60, 80), 0.1, np.float32)
>>> image[20:24, 30:50] = 1.0  # a tube lamp
>>> pixels = kernels.uv_to_pixel(kernels.halton(200), 60, 80)  # steps 3 and 4
>>> brightest, place = kernels.neighbour_maximum(image, pixels, 3)  # step 5
>>> pixels = place[brightest > 0.8]
>>> order = np.argsort(-image[tuple(pixels.T)], kind="stable")  # step 6
>>> pixels = pixels[order]
>>> pixels = pixels[np.unique(kernels.suppress(pixels, 4.0))]  # step 7
>>> light = kernels.merge_along_lines(image, pixels)  # step 8
>>> np.unique(light)
array([0])
>>> kernels.weighted_means(pixels, image[tuple(pixels.T)], light).round()  # step 9
array([[21., 40.]])
"""

from __future__ import annotations

import numbers
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native
from envlights._common.check import (
    amount,
    count,
    flag,
    float_image,
    reals,
    whole_numbers,
    whole_pixels,
)


class LineRule(NamedTuple):
    """Options of the kernel that merges samples along lines."""

    farthest: float
    tolerance: float
    ceiling: float
    bright: float
    sphere: bool


def neighbour_maximum(
    luminance: ArrayLike, pixels: ArrayLike, reach: int, *, sphere: bool = False
) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """Brightest pixel around each sample; Loghin (2021), step 5.

    Parameters
    ----------
    luminance : array_like, shape (height, width)
    pixels : array_like of int, shape (n, 2)
        Row and column of each sample.
    reach : int
        Pixels from the sample to the border of its window, which is ``2 reach + 1`` wide: 6 in the
        article at a width of 1024. The time is proportional
        to ``len(pixels) * reach**2``.
    sphere : bool
        True: windows cross the seam and widen towards the poles, so that they span the same angle
        everywhere.

    Returns
    -------
    luminance : ndarray of float32, shape (n,)
    pixels : ndarray of int, shape (n, 2)
        Row and column of the brightest pixel; the first of equals, row by row.

    Raises
    ------
    EnvLightsError
        If a shape is wrong, `luminance` is not finite or a sample lies outside of it.

    Examples
    --------
    >>> neighbour_maximum([[0, 1, 2, 3]], [[0, 0]], 1)
    (array([1.], dtype=float32), array([[0, 1]]))
    >>> neighbour_maximum([[0, 1, 2, 3]], [[0, 0]], 1, sphere=True)
    (array([3.], dtype=float32), array([[0, 3]]))
    """
    image = float_image("luminance", luminance, 2)
    return _native.neighbour_maximum(
        image, whole_pixels(pixels), count("reach", reach), flag("sphere", sphere)
    )


def suppress(points: ArrayLike, distance: float) -> NDArray[np.int64]:
    """Suppress points near brighter ones; Loghin (2021), step 7.

    Only survivors suppress others. The time is proportional to the number of points.

    Parameters
    ----------
    points : array_like, shape (n, 2) or (n, 3)
        Brightest first: pixels of a plane image, or unit vectors.
    distance : float
        A point nearer than this to a survivor is suppressed. Between unit vectors an angle a is
        the distance ``2 sin(a / 2)``.

    Returns
    -------
    ndarray of int, shape (n,)
        For each point its survivor: itself, or the brightest one nearer than `distance`.

    Raises
    ------
    EnvLightsError
        If `points` has another shape, is not finite, or `distance` is negative.

    Examples
    --------
    >>> suppress([[0, 0], [0, 3], [0, 5]], 4)
    array([0, 0, 2])
    """
    return _native.suppress(reals("points", points, 2), amount("distance", distance))


def bresenham_line(start: Sequence[int], end: Sequence[int]) -> NDArray[np.int64]:
    """Pixels of Bresenham's line, both ends included; Loghin (2021), step 8.

    Parameters
    ----------
    start, end : sequence of 2 ints
        Row and column.

    Returns
    -------
    ndarray of int, shape (k, 2)
        One pixel for each step along the longer side. A line and its reverse are the same pixels.

    Raises
    ------
    EnvLightsError
        If an end is not two whole numbers or the line has 2**24 steps or more.

    Examples
    --------
    >>> bresenham_line((0, 0), (1, 3)).tolist()
    [[0, 0], [0, 1], [1, 2], [1, 3]]
    """
    (first, last) = whole_pixels([start, end]).tolist()
    return _native.bresenham_line(first, last)


def merge_along_lines(
    luminance: ArrayLike,
    pixels: ArrayLike,
    *,
    tolerance: float = 0.15,
    ceiling: float = 1.25,
    bright: float = 1.0,
    points: ArrayLike | None = None,
    farthest: float = np.inf,
    sphere: bool = False,
) -> NDArray[np.int64]:
    """Merge samples that a line of similar luminance joins; Loghin (2021), step 8.

    Lines go from each unmerged sample, brightest first, to each later one. They merge two samples
    if the mean of the pixels, each limited to `ceiling`, differs from the luminance of the start by
    at most `tolerance` or is at least `bright`. The defaults are the article's.

    Parameters
    ----------
    luminance : array_like, shape (height, width)
    pixels : array_like of int, shape (n, 2)
        Row and column of the samples, brightest first.
    tolerance, ceiling, bright : float
        In units of luminance.
    points : array_like, shape (n, 2) or (n, 3), optional
        Positions of the samples, for `farthest`. Default: their pixels.
    farthest : float
        Samples farther apart are not merged. The article has no such limit.
    sphere : bool
        True: lines take the shorter way around, across the seam.

    Returns
    -------
    ndarray of int, shape (n,)
        Index of the sample that each was merged into; its own for a light.

    Raises
    ------
    EnvLightsError
        If a shape is wrong, `luminance` is not finite, a sample lies outside of it or an option
        is negative.

    Examples
    --------
    >>> image = [[1.0, 1.0, 1.0, 0.0, 1.0]]
    >>> merge_along_lines(image, [[0, 0], [0, 2], [0, 4]])
    array([0, 0, 2])
    """
    image, pixels = float_image("luminance", luminance, 2), whole_pixels(pixels)
    where = reals("points", pixels if points is None else points, 2)
    is_limited = not (isinstance(farthest, numbers.Real) and farthest == np.inf)
    limit = amount("farthest", farthest) if is_limited else np.inf
    rule = LineRule(
        limit,
        amount("tolerance", tolerance),
        amount("ceiling", ceiling),
        amount("bright", bright),
        flag("sphere", sphere),
    )
    return _native.merge_along_lines(image, pixels, where, rule)


def weighted_means(points: ArrayLike, weights: ArrayLike, light: ArrayLike) -> NDArray[np.float64]:
    """Weighted mean of the points of each light; Loghin (2021), step 9.

    Parameters
    ----------
    points : array_like, shape (n, d)
        Pixels, or unit vectors (whose mean is shorter than 1).
    weights : array_like, shape (n,)
        Luminance. If all weights of a light are 0, its points have equal weights.
    light : array_like of int, shape (n,)
        Light of each point, as from `merge_along_lines`.

    Returns
    -------
    ndarray, shape (m, d)
        ``sum(w p) / sum(w)`` for each number that `light` holds, in rising order.

    Raises
    ------
    EnvLightsError
        If the lengths differ, a number is not finite or a weight is negative.

    Examples
    --------
    >>> weighted_means([[0, 0], [0, 4], [9, 9]], [3, 1, 5], [0, 0, 2])
    array([[0., 1.],
           [9., 9.]])
    """
    points, weights = reals("points", points, 2), reals("weights", weights, 1)
    return _native.weighted_means(points, weights, whole_numbers("light", light))
