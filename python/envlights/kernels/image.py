"""Scalar images: luminance, resizing, blur, and conversion of image coordinates to pixels."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native
from envlights._common.check import amount, count, flag, float_image, reals

#: Rec.709 luminance weights of linear red, green and blue.
LUMINANCE = np.array(_native.LUMINANCE)


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

    Raises
    ------
    EnvLightsError
        If the shape is wrong or a value is not finite.

    Examples
    --------
    >>> luminance(np.full((2, 4, 3), 0.5))[0, 0].round(6)
    np.float32(0.5)
    """
    return _native.luminance(float_image("radiance", radiance, 3))


def resize_bilinear(
    image: ArrayLike, height: int, width: int, *, wrap: bool = False
) -> NDArray[np.float32]:
    """Resize an image by bilinear interpolation; Loghin (2021), step 1.

    A reduction by more than 2 skips pixels, so small lights may vanish, unlike in
    `reduced_luminance`.

    Parameters
    ----------
    image : array_like, shape (rows, columns)
    height, width : int
        The new size.
    wrap : bool
        True: columns wrap around at the seam, as in an equirectangular map. False: the outer pixels
        continue beyond the borders, as in a plane image, which is the default of all steps.

    Returns
    -------
    ndarray of float32, shape (height, width)

    Raises
    ------
    EnvLightsError
        If `image` has another shape or is not finite, or the new size is 0 or beyond 2**30 pixels.

    Examples
    --------
    >>> resize_bilinear([[0, 4]], 1, 4)
    array([[0., 1., 3., 4.]], dtype=float32)
    >>> resize_bilinear([[0, 4]], 1, 4, wrap=True)
    array([[1., 1., 3., 3.]], dtype=float32)
    """
    size = count("height", height, least=1), count("width", width, least=1)
    return _native.resize_bilinear(float_image("image", image, 2), *size, flag("wrap", wrap))


def reduced_luminance(
    radiance: ArrayLike, columns: int, *, border_sampled: bool = False
) -> NDArray[np.float32]:
    """Luminance of a map in fewer pixels, each the mean of a block by solid angle.

    `envlights.detect` works on it. No light is lost, unlike in `resize_bilinear`.

    Parameters
    ----------
    radiance : array_like, shape (height, width, 3)
        Finite and not negative. A float32 array is read in place.
    columns : int
        Largest number of columns; blocks have whole pixels, so there may be fewer.
    border_sampled : bool
        True: the outer pixels lie on the seam and the poles.

    Returns
    -------
    ndarray of float32, shape (rows, columns)

    Raises
    ------
    EnvLightsError
        If the shape is wrong.

    Examples
    --------
    >>> reduced_luminance(np.ones((64, 128, 3), np.float32), 50).shape
    (22, 43)
    """
    image = float_image("radiance", radiance, 3)
    return _native.reduced_luminance(
        image, count("columns", columns, least=1), flag("border_sampled", border_sampled)
    )


def area_means(image: ArrayLike, rows: int, columns: int) -> NDArray[np.float64]:
    """Means of a plane image over equal areas; a pixel on a boundary contributes to both areas.

    Parameters
    ----------
    image : array_like, shape (height, width), or ndarray, shape (height, width, channels)
        A float32 array is read in place. NaN makes the areas that it touches NaN.
    rows, columns : int
        The new size.

    Returns
    -------
    ndarray, shape (rows, columns) or (rows, columns, channels)

    Raises
    ------
    EnvLightsError
        If `image` has another shape, or is empty, or the new size is not positive.

    Examples
    --------
    >>> area_means([[3, 6, 9], [5, 8, 11]], 1, 2)
    array([[5., 9.]])
    """
    size = count("rows", rows, least=1), count("columns", columns, least=1)
    ndim = 3 if getattr(image, "ndim", 2) == 3 else 2
    is_single = isinstance(image, np.ndarray) and image.dtype == np.float32 and image.ndim == ndim
    pixels = np.require(image, None, ["ALIGNED"]) if is_single else reals("image", image, ndim)
    means = _native.area_means(pixels if ndim == 3 else pixels[..., None], *size)
    return means if ndim == 3 else means[..., 0]


def blur(image: ArrayLike, sigma: float, *, wrap: bool = False) -> NDArray[np.float32]:
    """Gaussian blur; Loghin (2021), optional in step 2.

    Parameters
    ----------
    image : array_like, shape (height, width)
    sigma : float
        Standard deviation in pixels: 1 to 2 at a width of 1024. The time grows with it; resize
        before a blur over hundreds of pixels.
    wrap : bool
        True: columns wrap around at the seam, as in an equirectangular map. False: the outer pixels
        continue beyond the borders, as in a plane image.

    Returns
    -------
    ndarray of float32, shape (height, width)

    Raises
    ------
    EnvLightsError
        If `image` has another shape or is not finite, or `sigma` is negative or beyond the width.

    Examples
    --------
    >>> blur([[0, 0, 1, 0, 0, 0, 0, 0]], 1.0).round(2)
    array([[0.05, 0.24, 0.4 , 0.24, 0.05, 0.  , 0.  , 0.  ]], dtype=float32)
    """
    size = amount("sigma", sigma)
    return _native.blur(float_image("image", image, 2), size, flag("wrap", wrap))


def uv_to_pixel(uv: ArrayLike, height: int, width: int) -> NDArray[np.int64]:
    """Pixels that contain image coordinates; Loghin (2021), step 4.

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

    Raises
    ------
    EnvLightsError
        If `uv` has another shape or is not finite, or the size is not positive.

    Examples
    --------
    >>> uv_to_pixel([[0.5, 0.0], [0.999, 1.0]], 4, 8)
    array([[0, 4],
           [3, 7]])
    """
    size = count("height", height, least=1), count("width", width, least=1)
    return _native.uv_to_pixel(reals("uv", uv, 2), *size)
