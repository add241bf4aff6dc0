"""Errors of a sphere under two lightings: in closed form from all sides, or in images."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from envlights.comparison import harmonics, rays, spectra
from envlights.comparison.image_errors import (
    ImageErrors,
    Products,
    errors_of_pixels,
    errors_of_products,
    mean_angle,
)
from envlights.comparison.lighting import Lighting, reduce_cells
from envlights.comparison.protocol import Camera, Material, Protocol
from envlights.kernels.reflection import rough_reflection
from envlights.kernels.sphere import pixel_solid_angles

#: Most rows of the maps from which rough images are summed, whose time grows with their pixels.
_ROUGH_ROWS = 128

#: Two images, (n, 3) each.
_Images = tuple[NDArray[np.float64], NDArray[np.float64]]


def sphere_errors(
    truth: Lighting, guess: Lighting, material: Material, protocol: Protocol
) -> ImageErrors:
    """Errors of a sphere of a `material` by the rules of a protocol."""
    if protocol.camera is None:
        return _from_all_sides(truth, guess, material, protocol)
    images = camera_images(truth, guess, material, protocol.camera)
    errors = errors_of_pixels(*images, channels=protocol.channels, black=protocol.black)
    if not protocol.normalised:
        return errors
    return replace(errors, normalised_rmse=_normalised_rmse(images, protocol))


def _from_all_sides(
    truth: Lighting, guess: Lighting, material: Material, protocol: Protocol
) -> ImageErrors:
    """Errors in closed form; the angle is a mean over sampled pixels."""
    factors = spectra.of_material(material)
    if factors is None:
        products = _products_of_mirror(truth, guess, material)
    else:
        products = products_of(degree_products(truth, guess), factors)
    angle = _angle(truth, guess, material, protocol.black)
    return errors_of_products(products, angle, channels=protocol.channels)


def degree_products(truth: Lighting, guess: Lighting) -> NDArray[np.float64]:
    """Inner products of each degree, (4, degree): T T, T G, G G and those of the difference."""
    one, other = truth.harmonics, guess.harmonics
    difference = other - one
    pairs = [(one, one), (one, other), (other, other), (difference, difference)]
    return np.stack([harmonics.products(*pair) for pair in pairs])


def products_of(by_degree: NDArray[np.float64], factors: NDArray[np.float64]) -> Products:
    """Means over all pixels, sides and channels, from inner products of each degree."""
    return Products(*(by_degree @ factors / (12 * np.pi)))


def _products_of_mirror(truth: Lighting, guess: Lighting, material: Material) -> Products:
    """Products of the maps themselves, weighted by solid angle."""
    one, other = (each.radiance.astype(np.float64) for each in (truth, guess))
    share = pixel_solid_angles(*one.shape[:2]) / (4 * np.pi)
    pairs = [(one, one), (one, other), (other, other), (other - one, other - one)]
    means = [float(np.einsum("hw,hwc,hwc->", share, *pair)) / 3 for pair in pairs]
    return Products(*(material.specular**2 * np.array(means)))


def _angle(
    truth: Lighting, guess: Lighting, material: Material, black: str
) -> tuple[float | None, float]:
    """RGB angle in degrees over pixels from all sides, and the fraction of black ones."""
    if material.roughness == 0 and material.specular:
        solid_angles = pixel_solid_angles(*truth.radiance.shape[:2]).reshape(-1)
        one, other = (each.radiance.reshape(-1, 3).astype(np.float64) for each in (truth, guess))
        return mean_angle(one, other, solid_angles, black=black)
    points = rays.sides() if material.specular else rays.even_normals()
    one, other = _rough_images(truth, guess, material, points)
    return mean_angle(one, other, points.weights, black=black)


def camera_images(truth: Lighting, guess: Lighting, material: Material, camera: Camera) -> _Images:
    """Pixels of the ball in the images of a camera, (n, 3) for each lighting."""
    if material.roughness == 0 and material.specular:
        return _mirror_images(truth, guess, material, camera)
    points = rays.of_camera(camera, is_mirror=False)
    return _rough_images(truth, guess, material, points)


def _rough_images(
    truth: Lighting, guess: Lighting, material: Material, points: rays.Rays
) -> _Images:
    """Radiance of points of a ball that is no mirror."""
    images = [np.zeros((len(points.normals), 3)) for _ in range(2)]
    if material.specular:
        cells = [reduce_cells(each.radiance, _ROUGH_ROWS) for each in (truth, guess)]
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
    """Pixels of a mirror, from the map interpolated between its pixels."""
    points = rays.of_camera(camera, is_mirror=True)
    indices, weights = rays.lookup(camera, truth.rows)
    cosine = (points.normals * points.views).sum(axis=1)
    weights = weights * (material.specular + (1 - material.specular) * (1 - cosine) ** 5)

    def image(light: Lighting) -> NDArray[np.float64]:
        cells = light.radiance.reshape(-1, 3).astype(np.float64)
        colours = sum(weights[i, :, None] * cells[indices[i]] for i in range(4))
        return points.pixel_means(np.asarray(colours))

    return image(truth), image(guess)


def _normalised_rmse(images: _Images, protocol: Protocol) -> float:
    """RMSE of images over the 99.9 % percentile of their whole pictures, black but for the ball."""
    coverage = protocol.camera.coverage if protocol.camera else 1.0
    level = 1 - 0.001 / coverage
    scaled = []
    for image in images:
        most = float(np.quantile(image, level)) if level > 0 else 0.0
        scaled.append(image / most if most > 0 else image)
    return errors_of_pixels(*scaled, channels=protocol.channels).rmse
