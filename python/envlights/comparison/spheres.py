"""Errors of a sphere under two lightings: in closed form over all views, or by images."""

from __future__ import annotations

from dataclasses import replace
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from envlights._common.blocks import blocks
from envlights.comparison import rays, spectra
from envlights.comparison.harmonics import reduce_cells
from envlights.comparison.image_errors import (
    ImageErrors,
    PixelSums,
    Products,
    errors_of_products,
    pixel_sums,
)
from envlights.comparison.lighting import Lighting, Pair
from envlights.comparison.protocol import Camera, Material, Protocol
from envlights.kernels.reflection import rough_reflection
from envlights.kernels.sphere import pixel_solid_angles

#: Largest number of map rows for rough images, whose time grows with the number of pixels.
_ROUGH_ROWS = 128

#: Two images, (n, 3) each.
_Images = tuple[NDArray[np.float64], NDArray[np.float64]]


def sphere_errors(pair: Pair, material: Material, protocol: Protocol) -> ImageErrors:
    """Errors of a sphere with a `material`, by the rules of a protocol."""
    rules = {"channels": protocol.channels, "black": protocol.black}
    if protocol.camera is None:
        return _from_all_sides(pair, material, protocol)
    images = camera_images(*pair.sides, material, protocol.camera)
    errors = pixel_sums(*images).errors(**rules)
    if not protocol.normalised:
        return errors
    scaled = [_over_percentile(image, protocol.camera.coverage) for image in images]
    return replace(errors, normalised_rmse=pixel_sums(*scaled).errors(**rules).rmse)


def _from_all_sides(pair: Pair, material: Material, protocol: Protocol) -> ImageErrors:
    """Errors in closed form; except for a mirror, the angle is a mean over sampled pixels."""
    factors = spectra.of_material(material)
    if factors is None:
        sums = _sums_of_mirror(*pair.sides, material)
        return sums.errors(channels=protocol.channels, black=protocol.black)
    products = products_of(pair.by_degree, factors)
    points = rays.sides() if material.specular else rays.even_normals()
    # Use half of the rows, which changes angles by less than 1 %, to allow more pixels.
    one, other = _rough_images(*pair.sides, material, points, _ROUGH_ROWS // 2)
    angle = pixel_sums(one, other, points.weights).mean_angle(protocol.black)
    return errors_of_products(products, angle, channels=protocol.channels)


def products_of(by_degree: NDArray[np.float64], factors: NDArray[np.float64]) -> Products:
    """Means over all pixels, views and channels, from inner products per degree."""
    return Products(*(by_degree[:, : len(factors)] @ factors / (12 * np.pi)))


def _sums_of_mirror(truth: Lighting, guess: Lighting, material: Material) -> PixelSums:
    """Sums over the map pixels, weighted by solid angle."""
    shape = truth.radiance.shape
    weights = pixel_solid_angles(*shape[:2])

    def sums(rows: slice) -> PixelSums:
        pair = (side.radiance[rows].reshape(-1, 3) for side in (truth, guess))
        one, other = (material.specular * each.astype(np.float64) for each in pair)
        return pixel_sums(one, other, weights[rows].reshape(-1))

    return reduce(PixelSums.plus, map(sums, blocks(shape)))


def camera_images(truth: Lighting, guess: Lighting, material: Material, camera: Camera) -> _Images:
    """Pixels of the ball in the two images of a camera, (n, 3) each."""
    if material.roughness == 0 and material.specular:
        return _mirror_images(truth, guess, material, camera)
    points = rays.of_camera(camera, is_mirror=False)
    return _rough_images(truth, guess, material, points)


def _rough_images(
    truth: Lighting, guess: Lighting, material: Material, points: rays.Rays, rows: int = _ROUGH_ROWS
) -> _Images:
    """Radiance at points of a rough ball."""
    images = [np.zeros((len(points.normals), 3)) for _ in range(2)]
    if material.specular:
        cells = [reduce_cells(each.radiance, rows) for each in (truth, guess)]
        surface = {"roughness": material.roughness, "specular": material.specular}
        stack = np.concatenate(cells, axis=2)
        both = rough_reflection(stack, points.normals, points.views, **surface)
        images = [both[:, :3], both[:, 3:]]
    if material.base:
        albedo = material.base / np.pi
        sides = zip(images, (truth, guess), strict=True)
        images = [image + albedo * light.probe(points.normals) for image, light in sides]
    return images[0], images[1]


def _mirror_images(truth: Lighting, guess: Lighting, material: Material, camera: Camera) -> _Images:
    """Pixels of a mirror ball, by interpolation in the map."""
    points = rays.of_camera(camera, is_mirror=True)
    indices, weights = rays.lookup(camera, truth.rows)
    cosine = (points.normals * points.views).sum(axis=1)
    weights = weights * (material.specular + (1 - material.specular) * (1 - cosine) ** 5)

    def image(light: Lighting) -> NDArray[np.float64]:
        cells = light.radiance.reshape(-1, 3).astype(np.float64)
        colours = sum(weights[i, :, None] * cells[indices[i]] for i in range(4))
        return points.pixel_means(np.asarray(colours))

    return image(truth), image(guess)


def _over_percentile(image: NDArray[np.float64], coverage: float) -> NDArray[np.float64]:
    """Image divided by the 99.9 % percentile of the picture, which is black off the ball."""
    level = 1 - 0.001 / coverage
    most = float(np.quantile(image, level)) if level > 0 else 0.0
    return image / most if most > 0 else image
