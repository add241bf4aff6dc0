"""Detection in a photograph by the steps of Loghin (2021), in its plane."""

from __future__ import annotations

import math
import time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights import _native, _thumbnails
from envlights._check import amount, check_choice, count, flag
from envlights._native import EnvLightsError
from envlights._srgb import encode_srgb
from envlights.detection import wording
from envlights.detection.article_steps import (
    BrightSamples,
    MergedSamples,
    MergeRule,
    bright_samples,
    merged_samples,
    square_points,
    sums_of_lights,
)
from envlights.detection.lights import DetectionReport
from envlights.detection.photograph_lights import PhotographLights, PhotographSamples
from envlights.detection.photograph_pixels import (
    AnyPhotograph,
    PhotographPixels,
    photograph_pixels,
)
from envlights.detection.pinhole import Pinhole
from envlights.kernels import image as images

#: Longer side of a picture in which lengths in pixels are given.
_REFERENCE_PX = 1024
#: Widest field of view in degrees; a pinhole camera cannot see 180.
_WIDEST_DEG = 179.0
#: Divisor in place of a flux of 0.
_TINY = np.finfo(float).tiny


class _Threshold(NamedTuple):
    """Luminance above which a pixel is bright, and the unit of the other levels."""

    level: float
    unit: float
    reason: str


def detect_photograph(
    image: AnyPhotograph,
    fov: float | None = None,
    *,
    max_lights: int | None = None,
    working_side: int = 1024,
    reduction: str = "bilinear",
    blur_px: float = 0.0,
    sampling: str = "halton",
    samples_per_pixel: float = 0.006,
    window_px: int = 12,
    threshold: float = 0.8,
    suppression_px: float = 20.0,
    tolerance: float = 0.15,
    ceiling: float = 1.25,
    merge_cap_px: float | None = None,
    relative: bool = False,
    move_to_maximum: bool = False,
) -> PhotographLights:
    """Docstring."""
    start = time.perf_counter()
    relative = flag("relative", relative)
    move_to_maximum = flag("move_to_maximum", move_to_maximum)
    photograph = photograph_pixels(image)
    camera, notes = _camera(photograph, fov)
    luminance = images.luminance(photograph.radiance)
    working = _working_image(luminance, working_side, reduction, blur_px)
    scale = max(working.shape) / _REFERENCE_PX
    limit = _threshold(working, photograph.white, amount("threshold", threshold), relative)
    reach = int(count("window_px", window_px) * scale) // 2
    uv = square_points(sampling, working, samples_per_pixel)
    pixel = images.uv_to_pixel(uv, *working.shape)
    samples = bright_samples(working, pixel, reach, limit.level, move_to_maximum, sphere=False)
    cap = math.inf if merge_cap_px is None else scale * amount("merge_cap_px", merge_cap_px)
    rule = MergeRule(
        apart=scale * amount("suppression_px", suppression_px),
        farthest=cap,
        tolerance=limit.unit * amount("tolerance", tolerance),
        ceiling=limit.unit * amount("ceiling", ceiling),
        bright=limit.unit,
    )
    points = samples.pixel.astype(np.float64)
    merged = merged_samples(working, samples, points, rule, sphere=False)
    report = DetectionReport(
        method="article",
        threshold=limit.level,
        reason=limit.reason,
        working_size=(working.shape[0], working.shape[1]),
        details=(f"{samples.total - len(samples.pixel)} of {samples.total} samples are dark",),
        notes=(*photograph.notes, *notes),
        seconds={"detect": time.perf_counter() - start},
    )
    lights = _lights(photograph, camera, luminance, working, samples, merged, report, reach)
    return lights if max_lights is None else lights[: count("max_lights", max_lights, least=1)]


def _camera(
    photograph: PhotographPixels, fov: float | None
) -> tuple[Pinhole | None, tuple[str, ...]]:
    """Camera of a horizontal field of view in degrees, or of the EXIF, with a note on it."""
    height, width, _ = photograph.radiance.shape
    if fov is not None:
        angle = amount("fov", fov, most=_WIDEST_DEG)
        if angle == 0:
            raise EnvLightsError("fov must be above 0 degrees; got 0")
        return Pinhole.of_field(height, width, math.radians(angle)), ()
    if photograph.focal is None:
        return None, ("no field of view is known, so there are no directions; give fov in degrees",)
    camera = Pinhole(height, width, photograph.focal.pixels)
    angle = math.degrees(camera.field_of_view)
    return camera, (
        f"the horizontal field of view is {angle:.1f} degrees, from the EXIF"
        f" ({photograph.focal.tag})",
    )


def _working_image(
    luminance: NDArray[np.float32], side: int, reduction: str, blur_px: float
) -> NDArray[np.float32]:
    """Steps 1 and 2: luminance with a longer side of at most `side` pixels."""
    check_choice("reduction", reduction, ("bilinear", "area"))
    side = min(count("working_side", side, least=16), max(luminance.shape))
    height, width = (max(round(each * side / max(luminance.shape)), 1) for each in luminance.shape)
    image = luminance
    if (height, width) != luminance.shape and reduction == "area":
        image = _means(_means(luminance, height).T, width).T.astype(np.float32)
    elif (height, width) != luminance.shape:
        image = images.resize_bilinear(luminance, height, width)
    return images.blur(image, blur_px) if amount("blur_px", blur_px) > 0 else image


def _means(image: NDArray[np.floating], rows: int) -> NDArray[np.float64]:
    """Exact means of an image over `rows` bands of equal height."""
    sums = np.vstack([np.zeros(image.shape[1]), np.cumsum(image, axis=0, dtype=np.float64)])
    edges = np.linspace(0, len(image), rows + 1)
    first = np.minimum(edges.astype(int), len(image) - 1)
    part = (edges - first)[:, None]
    at_edges = sums[first] + part * (sums[first + 1] - sums[first])
    means: NDArray[np.float64] = np.diff(at_edges, axis=0) * (rows / len(image))
    return means


def _threshold(
    working: NDArray[np.float32], white: float | None, threshold: float, relative: bool
) -> _Threshold:
    """Absolute threshold of the article, or that of the histogram, below the clip level."""
    level = threshold
    if relative:
        level = _native.plane_threshold(np.ascontiguousarray(working))
        level = level if white is None else min(level, threshold * white)
    unit = level / threshold if relative and level > 0 and threshold > 0 else 1.0
    share = 0.0 if white is None else min(level / white, 1.0)
    code = 255 * float(encode_srgb(np.array(share)))
    return _Threshold(level, unit, wording.reason_of_article(relative, level, white, code))


def _lights(
    photograph: PhotographPixels,
    camera: Pinhole | None,
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
    total = float(luminance.sum(dtype=np.float64)) or 1.0
    place = _pixels_at(merged.peak, size, radiance.shape)
    reach_in_photograph = math.ceil((reach + 0.5) * to_photograph.max())
    position = ((merged.means + 0.5) * to_photograph)[:, ::-1]
    kept = PhotographSamples(samples.pixel, samples.maximum, merged.survivor, merged.light)
    arrays = {
        "position": position,
        "pixel_flux": flux,
        "peak_pixel": place,
        "peak_luminance": working[merged.peak[:, 0], merged.peak[:, 1]].astype(np.float64),
        "flux_share": flux @ images.LUMINANCE / total,
        "is_clipped": _native.are_clipped(
            radiance, place, reach_in_photograph, False, photograph.white
        ),
    }
    if camera is not None:
        parts = camera.solid_angles(samples.own_pixel, size) * working.size / max(samples.total, 1)
        centres = ((samples.own_pixel + 0.5) * to_photograph)[:, ::-1]
        arrays["direction"] = camera.directions(position)
        arrays["irradiance"] = _irradiance(
            values, parts, camera.directions(centres), merged.light, lights
        )
    return PhotographLights(
        **arrays,
        samples=kept,
        report=report,
        size=(height, width),
        field_of_view=None if camera is None else camera.field_of_view,
        picture=_thumbnails.of_photograph(radiance, _REFERENCE_PX, photograph.white),
    )


def _pixels_at(
    pixel: NDArray[np.int64], size: tuple[int, int], shape: tuple[int, ...]
) -> NDArray[np.int64]:
    """Pixels of the photograph at the centres of pixels of the working image."""
    uv = (pixel[:, ::-1] + 0.5) / size[::-1]
    return images.uv_to_pixel(uv, shape[0], shape[1])


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
    return flux * towards[:, None]
