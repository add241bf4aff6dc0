"""Measurement of the lights of a photograph on their samples."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights import _native, _thumbnails
from envlights.detection.article_steps import BrightSamples, MergedSamples, sums_of_lights
from envlights.detection.lights import DetectionReport
from envlights.detection.photograph_lights import PhotographLights, PhotographSamples
from envlights.detection.photograph_pixels import PhotographPixels
from envlights.kernels import image as images
from envlights.layouts.layout import Layout

#: Longer side of the picture that the lights hold for display.
_PICTURE_PX = 1024
#: Divisor in place of a flux of 0.
_TINY = np.finfo(float).tiny


def measure(
    photograph: PhotographPixels,
    camera: Layout | None,
    luminance: NDArray[np.float32],
    working: NDArray[np.float32],
    samples: BrightSamples,
    merged: MergedSamples,
    report: DetectionReport,
    reach: int,
) -> PhotographLights:
    """Measure each light on its samples, each at its first position."""
    radiance, size = photograph.radiance, report.working_size
    height, width, _ = radiance.shape
    to_photograph = np.array([height / size[0], width / size[1]])
    lights = len(merged.means)
    first = _pixels_at(samples.own_pixel, size, radiance.shape)
    values = radiance[first[:, 0], first[:, 1]].astype(np.float64)
    each = height * width / max(samples.total, 1)
    flux = each * sums_of_lights(values, merged.light, lights)
    # A sample may stand for more pixels than are bright around it.
    total = max(float(luminance.sum(dtype=np.float64)), float((flux @ images.LUMINANCE).sum()))
    place = _pixels_at(merged.peak, size, radiance.shape)
    reach_in_photograph = math.ceil((reach + 0.5) * to_photograph.max())
    position = ((merged.means + 0.5) * to_photograph)[:, ::-1]
    places = samples.own_pixel, samples.pixel, samples.maximum
    kept = PhotographSamples(*places, merged.survivor, merged.light)
    arrays: dict[str, Any] = {
        "position": position,
        "pixel_flux": flux,
        "peak_pixel": place,
        "peak_luminance": working[merged.peak[:, 0], merged.peak[:, 1]].astype(np.float64),
        "flux_fraction": flux @ images.LUMINANCE / (total or 1.0),
        "is_clipped": _native.are_clipped(
            radiance, place, reach_in_photograph, False, photograph.white
        ),
    }
    if camera is not None:
        parts = _solid_angles(camera, samples.own_pixel, size, each)
        centres = ((samples.own_pixel + 0.5) * to_photograph)[:, ::-1]
        towards = _native.projection_directions(camera, np.ascontiguousarray(centres))
        arrays["direction"] = _native.projection_directions(camera, np.ascontiguousarray(position))
        arrays["irradiance"] = _irradiance(values, parts, towards, merged.light, lights)
    return PhotographLights(
        **arrays,
        samples=kept,
        report=report,
        size=(height, width),
        field_of_view=None if camera is None else camera.field_of_view,
        picture=_thumbnails.of_photograph(radiance, _PICTURE_PX, photograph.white),
    )


def _pixels_at(
    pixel: NDArray[np.int64], size: tuple[int, int], shape: tuple[int, ...]
) -> NDArray[np.int64]:
    """Pixels of the photograph at the centres of pixels of the working image."""
    uv = (pixel[:, ::-1] + 0.5) / size[::-1]
    return images.uv_to_pixel(uv, shape[0], shape[1])


def _solid_angles(
    camera: Layout, pixel: NDArray[np.int64], size: tuple[int, int], each: float
) -> NDArray[np.float64]:
    """Solid angle of `each` pixels of the photograph at pixels of the working image.

    The working image is a photograph with square pixels and the same horizontal field of view.
    """
    angles = _native.projection_solid_angles(camera._replace(height=size[0], width=size[1]))
    pixels_of_photograph = (camera.width / size[1]) ** 2
    chosen: NDArray[np.float64] = angles[pixel[:, 0], pixel[:, 1]]
    return chosen * (each / pixels_of_photograph)


def _irradiance(
    radiance: NDArray[np.float64],
    solid_angle: NDArray[np.float64],
    direction: NDArray[np.float64],
    light: NDArray[np.int64],
    lights: int,
) -> NDArray[np.float64]:
    """Irradiance of a surface that faces each light: the length of its vector of flux."""
    flux = sums_of_lights(radiance * solid_angle[:, None], light, lights)
    luminance = (radiance @ images.LUMINANCE * solid_angle)[:, None]
    vectors = sums_of_lights(luminance * direction, light, lights)
    towards = np.linalg.norm(vectors, axis=1) / np.maximum(flux @ images.LUMINANCE, _TINY)
    received: NDArray[np.float64] = flux * towards[:, None]
    return received
