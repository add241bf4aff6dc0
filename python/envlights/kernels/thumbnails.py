"""Small pictures of maps and lights, for notebooks; without Matplotlib."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights._common.blocks import in_blocks
from envlights._common.srgb import encode_srgb
from envlights.kernels import sphere
from envlights.kernels.image import LUMINANCE

#: Columns of a thumbnail.
_COLUMNS = 240
#: Smallest number of rows to sample for the display white level.
_ROWS = 256
#: Fraction of the sphere that is darker than white in a picture of a map.
_DARKER_THAN_WHITE = 0.98
#: Smallest ratio of the white level to the median of the sphere.
_OVER_MEDIAN = 2.5
#: 8-bit grey values of the background behind lights, and of the horizon line.
_GROUND, _HORIZON = 40, 84
#: Image size in pixels, number of images, and gap in pixels, in a strip.
_SIDE, _IMAGES, _GAP = 96, 4, 4
#: Largest number of lights in a picture.
_MOST_LIGHTS = 64


def white_of(radiance: NDArray[np.floating], *, is_plane: bool = False) -> tuple[float, float]:
    """Luminance to display as white in a picture of a map, and the fraction of the sphere below it.

    In a plane picture all pixels count the same.

    Only lamps exceed it; an even sky does not, because white is a multiple of the median. Of large
    maps every n-th row and column is sampled.
    """
    step = max(radiance.shape[0] // _ROWS, 1)
    radiance = radiance[::step, ::step]
    height = radiance.shape[0]
    luminance = radiance @ LUMINANCE
    bands = np.ones(height) if is_plane else np.sin(np.pi * (np.arange(height) + 0.5) / height)
    weights = np.broadcast_to(bands[:, None], luminance.shape).ravel()
    order = np.argsort(luminance, axis=None)
    values = luminance.ravel()[order]
    darker = np.cumsum(weights[order]) / weights.sum()

    def quantile(fraction: float) -> float:
        return float(values[min(int(np.searchsorted(darker, fraction)), len(values) - 1)])

    white = max(quantile(_DARKER_THAN_WHITE), _OVER_MEDIAN * quantile(0.5))
    # Use the maximum for a lamp in a black sky.
    white = white or float(values[-1]) or 1.0
    below = int(np.searchsorted(values, white))
    return white, float(darker[below - 1]) if below else 0.0


def shrink(radiance: NDArray[np.floating], columns: int) -> NDArray[np.float64]:
    """Block means, at least `columns` and less than twice `columns` wide.

    A narrower image keeps its size.
    """
    step = max(radiance.shape[1] // columns, 1)
    height, width = (side // step * step for side in radiance.shape[:2])
    cells = radiance[:height, :width].reshape(height // step, step, width // step, step, -1)
    return in_blocks(cells.shape, lambda rows: cells[rows].mean(axis=(1, 3), dtype=np.float64))


def expose(radiance: NDArray[np.floating], white: float) -> NDArray[np.uint8]:
    """8-bit sRGB pixels, with the luminance `white` displayed as white."""
    return _codes(encode_srgb(radiance / white))


def of_map(radiance: NDArray[np.floating]) -> NDArray[np.uint8]:
    """8-bit pixels of a map, exposed so that its lamps are visible."""
    small = shrink(radiance, _COLUMNS)
    return expose(small, white_of(small)[0])


def of_photograph(
    radiance: NDArray[np.floating], longest: int, white: float | None
) -> NDArray[np.uint8]:
    """8-bit pixels of a photograph, at most `longest` wide or high; `white` is the clip level."""
    step = -(-max(radiance.shape[:2]) // longest)
    small = radiance[::step, ::step]
    return expose(small, white_of(small, is_plane=True)[0] if white is None else white)


def nearest_columns(codes: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """8-bit pixels reduced to thumbnail size, by taking every n-th pixel."""
    step = -(-codes.shape[1] // _COLUMNS)
    return codes[::step, ::step]


def of_lights(
    direction: NDArray[np.float64],
    irradiance: NDArray[np.float64],
    angular_radius: NDArray[np.float64],
) -> NDArray[np.uint8]:
    """8-bit picture of lights, brightest first: discs with the colour and size of the lights.

    Small discs get a visible area that grows with their brightness.
    """
    forward = sphere.pixel_directions(_COLUMNS // 2, _COLUMNS)
    picture = np.full(forward.shape, _GROUND, np.uint8)
    picture[_COLUMNS // 4] = _HORIZON
    luminance = irradiance @ LUMINANCE
    fraction = luminance / (luminance.max(initial=0.0) or 1.0)
    radius = np.maximum(angular_radius, np.deg2rad(1.5 + 4.5 * np.sqrt(fraction)))
    colours = _codes(colours_of(irradiance))
    for k in reversed(range(min(len(direction), _MOST_LIGHTS))):
        picture[forward @ direction[k] > np.cos(radius[k])] = colours[k]
    return picture


def of_pairs(direct: NDArray[np.floating], indirect: NDArray[np.floating]) -> NDArray[np.uint8]:
    """8-bit picture of the first few pairs: direct light above, indirect light below."""
    rows = [[_expose_image(image) for image in images[:_IMAGES]] for images in (direct, indirect)]
    return np.vstack([_strip(images) for images in rows])


def of_signed(images: NDArray[np.floating]) -> NDArray[np.uint8]:
    """8-bit picture of a few signed images (n, height, width), with grey for zero."""
    limits = np.abs(images).max(axis=(1, 2), keepdims=True)
    grey = 0.5 + 0.5 * images / np.where(limits > 0, limits, 1)
    return _strip(
        [_codes(_nearest_texels(np.repeat(image[..., None], 3, axis=2))) for image in grey]
    )


def _expose_image(image: NDArray[np.floating]) -> NDArray[np.uint8]:
    small = _nearest_texels(image.astype(np.float64))
    white = np.percentile(small, 99) or small.max() or 1.0
    return expose(small, white)


def _nearest_texels(image: NDArray[np.floating]) -> NDArray[np.floating]:
    """Image resized to thumbnail size by nearest-neighbour sampling."""
    height, width = image.shape[:2]
    longest = max(height, width)
    sides = [max(round(_SIDE * side / longest), 1) for side in (height, width)]
    rows, columns = (
        np.arange(n) * side // n for n, side in zip(sides, (height, width), strict=True)
    )
    scaled: NDArray[np.floating] = image[rows][:, columns]
    return scaled


def _strip(images: list[NDArray[np.uint8]]) -> NDArray[np.uint8]:
    """Images in a row, with gaps between and below them."""
    framed = [
        np.pad(image, ((0, _GAP), (0, _GAP), (0, 0)), constant_values=128) for image in images
    ]
    return np.hstack(framed)


def colours_of(irradiance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Colours of lights at full brightness in sRGB, (n, 3); black for a black light."""
    largest = irradiance.max(axis=1, keepdims=True, initial=0.0)
    return np.asarray(
        encode_srgb(np.maximum(irradiance, 0) / np.where(largest > 0, largest, 1)), np.float64
    )


def hex_of(irradiance: NDArray[np.float64]) -> list[str]:
    """Colours of lights as ``#rrggbb``."""
    return ["#" + bytes(code).hex() for code in _codes(colours_of(irradiance))]


def _codes(encoded: NDArray[np.floating]) -> NDArray[np.uint8]:
    return np.round(255 * encoded).astype(np.uint8)
