"""Detectors to compare: ours, and simple ones from general image libraries.

Each takes radiance, (height, 2 * height, 3), and returns unit directions and RGB irradiance, both
(n, 3). The peers get the same fair chance: they know the seam and the poles, count by solid angle
and measure on the sphere.
"""

from functools import cache

import numpy as np
from scipy import sparse
from skimage import feature, filters, measure

import envlights as el
from envlights.kernels.image import LUMINANCE
from envlights.papers import loghin

#: Rounds of the median cut; each doubles the cells. The best of 3 to 7 on `TUNING`.
_CUTS = 5


def ours(detect=el.detect, **options):
    def detector(radiance):
        lights = detect(radiance, **options)
        return lights.direction, lights.flux

    return detector


@cache
def sphere(height, width):
    """Direction and solid angle of each pixel, computed once for all maps."""
    directions = el.kernels.pixel_directions(height, width)
    return directions, el.kernels.pixel_solid_angles(height, width)


def twice_the_90_percent_quantile(luminance):
    _, solid_angles = sphere(*luminance.shape)
    return 2 * np.quantile(luminance, 0.9, weights=solid_angles, method="inverted_cdf")


def otsu_of_the_logarithm(luminance):
    # An even map has no second class, and must not gain one by rounding.
    return 1.0001 * np.exp(filters.threshold_otsu(_logarithm(luminance)))


def by_scikit_image(bright):
    return measure.label(bright, connectivity=2)


def by_opencv(bright):
    import cv2

    return cv2.connectedComponents(bright.astype(np.uint8), connectivity=8)[1]


def components(threshold, label=by_scikit_image):
    """Threshold and connected components, whole at the seam and the poles."""

    def detector(radiance):
        luminance = radiance @ LUMINANCE
        return lights_of(radiance, join_seam(label(luminance > threshold(luminance))))

    return detector


def join_seam(labels):
    """Labels made one where they meet at the seam or at a pole."""
    meetings = [*zip(labels[:, 0], labels[:, -1], strict=True)]
    for pole in (labels[0], labels[-1]):
        meetings += [(pole[pole > 0].min(), label) for label in set(pole[pole > 0])]
    pairs = np.array([pair for pair in meetings if all(pair)], int).reshape(-1, 2)
    size = labels.max() + 1
    graph = sparse.coo_array((np.ones(len(pairs)), pairs.T), shape=(size, size))
    _, whole = sparse.csgraph.connected_components(graph, directed=False)
    return np.where(labels > 0, whole[labels] + 1, 0)


def blobs(radiance):
    """Laplacian of Gaussians on the logarithm, kept where the threshold above keeps them.

    Its own threshold and overlap are the best of six on a quarter of `TUNING`, by F1.
    """
    luminance = radiance @ LUMINANCE
    logarithm = _logarithm(luminance)
    height, width = luminance.shape
    margin = width // 8
    padded = np.pad(logarithm, ((0, 0), (margin, margin)), mode="wrap")
    found = feature.blob_log(
        padded, min_sigma=1, max_sigma=30, num_sigma=8, threshold=2.0, overlap=0.05
    )
    directions, _ = sphere(height, width)
    labels = np.zeros((height, width), int)
    threshold = twice_the_90_percent_quantile(luminance)
    for label, (row, padded_column, sigma) in enumerate(found, start=1):
        row, column = int(row), int(padded_column) - margin
        if 0 <= column < width and luminance[row, column] > threshold:
            reach = np.cos(np.sqrt(2) * sigma * np.pi / height)
            labels[directions @ directions[row, column] >= reach] = label
    return lights_of(radiance, labels)


def median_cut(radiance):
    """Debevec (2005): cut the flux in halves along the longer side; keep the bright cells."""
    luminance = radiance @ LUMINANCE
    _, solid_angles = sphere(*luminance.shape)
    flux = luminance * solid_angles
    cells = [(0, flux.shape[0], 0, flux.shape[1])]
    for _ in range(_CUTS):
        cells = [half for cell in cells for half in _halves(flux, *cell)]
    labels = np.zeros(flux.shape, int)
    threshold = twice_the_90_percent_quantile(luminance)
    for label, (top, bottom, left, right) in enumerate(cells, start=1):
        if luminance[top:bottom, left:right].mean() > threshold:
            labels[top:bottom, left:right] = label
    return lights_of(radiance, labels)


def _halves(flux, top, bottom, left, right):
    """Two parts of a cell with about the same flux; the cell alone where it is one pixel."""
    cell = flux[top:bottom, left:right]
    if cell.size == 1:
        return [(top, bottom, left, right)]
    # Meridians draw together towards the poles.
    breadth = (right - left) * np.sin(np.pi * (top + bottom) / 2 / len(flux))
    axis = 0 if bottom - top > 1 and (bottom - top >= breadth or right - left == 1) else 1
    along = cell.sum(axis=1 - axis).cumsum()
    cut = 1 + int(np.searchsorted(along[:-2], along[-1] / 2))
    if axis == 0:
        return [(top, top + cut, left, right), (top + cut, bottom, left, right)]
    return [(top, bottom, left, left + cut), (top, bottom, left + cut, right)]


def lights_of(radiance, labels):
    """Flux centroid and irradiance of the pixels of each label from 1 up."""
    lit = labels > 0
    _, label = np.unique(labels[lit], return_inverse=True)
    directions, solid_angles = sphere(*labels.shape)
    flux = radiance[lit] * solid_angles[lit][:, None]
    weighted = (flux @ LUMINANCE)[:, None] * directions[lit]
    centroid, irradiance = (
        np.stack([np.bincount(label, values) for values in array.T], axis=1)
        for array in (weighted, flux)
    )
    return centroid / np.linalg.norm(centroid, axis=1, keepdims=True), irradiance


def _logarithm(luminance):
    """Logarithm of the luminance, with black raised to 1e-6 of the maximum."""
    brightest = luminance.max()
    return np.log(np.maximum(luminance, 1e-6 * brightest if brightest else 1.0))


IMPROVED = loghin.Settings(relative=True, move_to_maximum=True, sphere=True, reduction="area")
DETECTORS = {
    "tree": ours(),
    "loghin": ours(loghin.detect),
    "loghin improved": ours(loghin.detect, settings=IMPROVED),
    "threshold + components": components(twice_the_90_percent_quantile),
    "threshold + OpenCV": components(twice_the_90_percent_quantile, by_opencv),
    "Otsu + components": components(otsu_of_the_logarithm),
    "blob_log": blobs,
    "median cut": median_cut,
}
