"""The steps of Loghin (2021), for maps and for plane images.

`envlights.detect_article` puts them together for a map. For a plane image the samples come from
`halton` instead of the sphere:

>>> import numpy as np
>>> from envlights import kernels
>>> image = np.full((60, 80), 0.1, np.float32)
>>> image[20:24, 30:50] = 1.0  # a tube lamp
>>> pixels = kernels.uv_to_pixel(kernels.halton(200), 60, 80)  # steps 3 and 4
>>> brightest, place = kernels.neighbour_maximum(image, pixels, 3)  # step 5
>>> pixels = place[brightest > 0.8]
>>> order = np.argsort(-image[*pixels.T], kind="stable")  # step 6
>>> pixels = pixels[order]
>>> survivors = np.unique(kernels.suppress(pixels, 4.0))  # step 7
>>> light = kernels.merge_along_lines(image, pixels[survivors])  # step 8
>>> np.unique(light)
array([0])
>>> kernels.weighted_means(pixels[survivors], image[*pixels[survivors].T], light).round()  # step 9
array([[21., 40.]])
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native
from envlights._check import amount, count, reals
from envlights._native import EnvLightsError


def luminance(radiance: ArrayLike) -> NDArray[np.float32]:
    """Rec.709 luminance of linear RGB; Loghin (2021), step 2.

    Parameters
    ----------
    radiance : array_like, shape (height, width, 3)
        Linear RGB. A float32 array is read in place.

    Returns
    -------
    ndarray of float32, shape (height, width)
        ``0.2126 R + 0.7152 G + 0.0722 B``.

    Examples
    --------
    >>> luminance(np.full((2, 4, 3), 0.5))[0, 0].round(6)
    np.float32(0.5)
    """
    return _native.luminance(_image("radiance", radiance, 3))


def resize_bilinear(image: ArrayLike, height: int, width: int) -> NDArray[np.float32]:
    """An image in another size, linear between the pixels' centres; Loghin (2021), step 1.

    A reduction by more than 2 leaves pixels out: small lights may vanish. The area average of
    `envlights.detect` does not.

    Parameters
    ----------
    image : array_like, shape (rows, columns)
        Columns meet at the seam, as those of an equirectangular map.
    height, width : int
        The new size.

    Returns
    -------
    ndarray of float32, shape (height, width)

    Examples
    --------
    >>> resize_bilinear([[0, 2, 4, 2]], 1, 2)
    array([[1., 3.]], dtype=float32)
    """
    size = count("height", height, least=1), count("width", width, least=1)
    return _native.resize_bilinear(_image("image", image, 2), *size)


def reduced_luminance(
    radiance: NDArray[np.float32], columns: int, *, border_sampled: bool = False
) -> NDArray[np.float32]:
    """Luminance of a map in fewer pixels, each the mean of a block by solid angle.

    What `envlights.detect` works on. No light is lost, unlike in `resize_bilinear`.

    Parameters
    ----------
    radiance : ndarray of float32, shape (height, width, 3)
        Finite and not negative; read in place.
    columns : int
        At most so many columns are made; blocks have whole pixels, so there may be fewer.
    border_sampled : bool
        Whether the outer pixels lie on the seam and the poles.

    Returns
    -------
    ndarray of float32, shape (rows, columns)

    Examples
    --------
    >>> reduced_luminance(np.ones((64, 128, 3), np.float32), 50).shape
    (22, 43)
    """
    return _native.reduced_luminance(radiance, count("columns", columns, least=1), border_sampled)


def blur(image: ArrayLike, sigma: float) -> NDArray[np.float32]:
    """A Gaussian blur; Loghin (2021), step 2, where it is optional.

    Parameters
    ----------
    image : array_like, shape (height, width)
        Columns meet at the seam; rows end.
    sigma : float
        Standard deviation in pixels: 1 to 2 at a width of 1024.

    Returns
    -------
    ndarray of float32, shape (height, width)

    Examples
    --------
    >>> blur([[0, 0, 1, 0, 0, 0, 0, 0]], 1.0).round(2)
    array([[0.05, 0.24, 0.4 , 0.24, 0.05, 0.  , 0.  , 0.  ]], dtype=float32)
    """
    return _native.blur(_image("image", image, 2), amount("sigma", sigma))


def uv_to_pixel(uv: ArrayLike, height: int, width: int) -> NDArray[np.int64]:
    """The pixels in which image coordinates lie; Loghin (2021), step 4.

    Parameters
    ----------
    uv : array_like, shape (n, 2)
        ``u`` from the left edge, ``v`` from the top, 0 to 1.
    height, width : int
        Size of the image.

    Returns
    -------
    ndarray of int, shape (n, 2)
        Row and column.

    Examples
    --------
    >>> uv_to_pixel([[0.5, 0.0], [0.999, 1.0]], 4, 8)
    array([[0, 4],
           [3, 7]])
    """
    size = np.array([count("height", height, least=1), count("width", width, least=1)])
    # Hammersley points lie on the very borders of pixels, where rounding would toss a coin.
    at = np.floor(reals("uv", uv, 2)[:, ::-1] * size + 1e-9)
    pixel: NDArray[np.int64] = np.clip(at, 0, size - 1).astype(np.int64)
    return pixel


def neighbour_maximum(
    luminance: ArrayLike, pixels: ArrayLike, reach: int, *, sphere: bool = False
) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """The brightest pixel around each sample; Loghin (2021), step 5.

    Parameters
    ----------
    luminance : array_like, shape (height, width)
    pixels : array_like of int, shape (n, 2)
        Row and column of each sample.
    reach : int
        Pixels from the sample to the border of its window, which is ``2 reach + 1`` wide: 6 in the
        article at a width of 1024.
    sphere : bool
        Whether windows cross the seam and widen towards the poles, so that they span the same
        angle everywhere.

    Returns
    -------
    luminance : ndarray of float32, shape (n,)
    pixels : ndarray of int, shape (n, 2)
        Where it was seen; the first of equals, row by row.

    Examples
    --------
    >>> neighbour_maximum([[0, 1, 2, 3]], [[0, 0]], 1)
    (array([1.], dtype=float32), array([[0, 1]]))
    >>> neighbour_maximum([[0, 1, 2, 3]], [[0, 0]], 1, sphere=True)
    (array([3.], dtype=float32), array([[0, 3]]))
    """
    image = _image("luminance", luminance, 2)
    return _native.neighbour_maximum(image, _pixels(pixels), count("reach", reach), bool(sphere))


def suppress(points: ArrayLike, distance: float) -> NDArray[np.int64]:
    """Which of some points survive beside brighter ones; Loghin (2021), step 7.

    Only survivors suppress. The work grows with the number of points, not with its square.

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

    Examples
    --------
    >>> suppress([[0, 0], [0, 3], [0, 5]], 4)
    array([0, 0, 2])
    """
    return _native.suppress(reals("points", points, 2), amount("distance", distance))


def bresenham_line(start: Sequence[int], end: Sequence[int]) -> NDArray[np.int64]:
    """The pixels of Bresenham's line, both ends included; Loghin (2021), step 8.

    Parameters
    ----------
    start, end : sequence of 2 ints
        Row and column.

    Returns
    -------
    ndarray of int, shape (k, 2)
        One pixel for each step along the longer side. A line and its reverse are the same pixels.

    Examples
    --------
    >>> bresenham_line((0, 0), (1, 3)).tolist()
    [[0, 0], [0, 1], [1, 2], [1, 3]]
    """
    (first, last) = _pixels([start, end]).tolist()
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
    """Merge samples that a line of like luminance joins; Loghin (2021), step 8.

    From each sample that is not merged yet, brightest first, a line goes to each later one. It
    holds while the mean of its pixels, each cut at `ceiling`, differs from the start's luminance by
    at most `tolerance` or is at least `bright`. The defaults are the article's.

    Parameters
    ----------
    luminance : array_like, shape (height, width)
    pixels : array_like of int, shape (n, 2)
        Row and column of the samples, brightest first.
    tolerance, ceiling, bright : float
        In units of luminance.
    points : array_like, shape (n, 2) or (n, 3), optional
        Where the samples are, for `farthest`; their pixels when left out.
    farthest : float
        Samples farther apart are not merged. The article has no such limit.
    sphere : bool
        Whether lines take the shorter way around, across the seam.

    Returns
    -------
    ndarray of int, shape (n,)
        For each sample the one that it became part of; itself for a light.

    Examples
    --------
    >>> image = [[1.0, 1.0, 1.0, 0.0, 1.0]]
    >>> merge_along_lines(image, [[0, 0], [0, 2], [0, 4]])
    array([0, 0, 2])
    """
    image, pixels = _image("luminance", luminance, 2), _pixels(pixels)
    where = reals("points", pixels if points is None else points, 2)
    limit = np.inf if farthest == np.inf else amount("farthest", farthest)
    levels = amount("tolerance", tolerance), amount("ceiling", ceiling), amount("bright", bright)
    return _native.merge_along_lines(image, pixels, where, limit, *levels, bool(sphere))


def weighted_means(points: ArrayLike, weights: ArrayLike, light: ArrayLike) -> NDArray[np.float64]:
    """Weighted mean of the points of each light; Loghin (2021), step 9.

    Parameters
    ----------
    points : array_like, shape (n, d)
        Pixels, or unit vectors (whose mean is shorter than 1).
    weights : array_like, shape (n,)
        Luminance. Where all of a light are 0, its points count alike.
    light : array_like of int, shape (n,)
        Which light each point belongs to, as from `merge_along_lines`.

    Returns
    -------
    ndarray, shape (m, d)
        ``sum(w p) / sum(w)`` for each number that `light` holds, in rising order.

    Examples
    --------
    >>> weighted_means([[0, 0], [0, 4], [9, 9]], [3, 1, 5], [0, 0, 2])
    array([[0., 1.],
           [9., 9.]])
    """
    points, weights = reals("points", points, 2), reals("weights", weights, 1)
    which = np.unique(light, return_inverse=True)[1]
    totals = np.bincount(which, weights)
    weights = np.where(totals[which] > 0, weights, 1.0)
    sums = np.stack([np.bincount(which, weights * axis) for axis in points.T], axis=1)
    means: NDArray[np.float64] = sums / np.bincount(which, weights)[:, None]
    return means


def _image(name: str, values: ArrayLike, ndim: int) -> NDArray[np.float32]:
    """`values` as a C-contiguous float32 array of `ndim` axes, or a refusal that names it."""
    is_ready = isinstance(values, np.ndarray) and values.dtype == np.float32
    array = values if is_ready else reals(name, values, np.ndim(values))
    if np.ndim(array) != ndim:
        raise EnvLightsError(f"{name} must have {ndim} axes; got the shape {np.shape(array)}")
    return np.ascontiguousarray(array, dtype=np.float32)


def _pixels(values: ArrayLike) -> NDArray[np.int64]:
    """`values` as rows and columns, or a refusal."""
    array = np.asarray(values)
    if array.dtype.kind not in "iu" or array.ndim != 2 or array.shape[1] != 2:
        raise EnvLightsError(
            f"pixels must be whole numbers of the shape (n, 2);"
            f" got the dtype {array.dtype} and the shape {array.shape}"
        )
    return np.ascontiguousarray(array, dtype=np.int64)
