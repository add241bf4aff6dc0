"""Detection in a photograph by the steps of Loghin (2021), in its plane."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._common.check import amount, check_choice, count, flag
from envlights._common.srgb import encode_srgb
from envlights.detection import wording
from envlights.detection.lights import DetectionReport
from envlights.environment.colour.choice import ColourArgument
from envlights.environment.layouts import layout as layouts
from envlights.environment.layouts.layout import Layout
from envlights.kernels import image as images
from envlights.kernels import loghin
from envlights.papers.loghin_steps import (
    BrightSamples,
    MergedSamples,
    MergeRule,
    bright_samples,
    climb,
    merged_samples,
    square_points,
)
from envlights.papers.photograph_lights import PhotographLights
from envlights.papers.photograph_measure import measure
from envlights.papers.photograph_pixels import AnyPhotograph, PhotographPixels, photograph_pixels

#: Longer side of a picture in which lengths in pixels are given.
_REFERENCE_PX = 1024
#: Default width of a window divided by the distance between samples: at 1, gaps would remain.
_WINDOW_OVER_SPACING = 1.3
#: Narrowest and widest field of view in degrees; no photograph of a plane shows 180.
_VIEWS_DEG = (0.05, 179.0)
#: Stops below the threshold at which the relative line check treats pixels as equally dark: one
#: black pixel of a window bar would part a lamp otherwise.
_STOPS_BELOW = 2
#: Stops from the maximum of a picture to the least threshold of that check, for black pictures.
_MOST_STOPS = 30
#: Limit in stops that no luminance reaches.
_NO_LIMIT = 1e3
#: Divisor in place of a flux of 0.
_TINY = np.finfo(float).tiny


class _Levels(NamedTuple):
    """Levels of luminance, and the rule that set them."""

    bright: float
    """Luminance above which a pixel is bright."""

    peak: float
    """Least luminance of the maximum of a light."""

    unit: float | None
    """Luminance in place of the article's 1 in the line check; None for a check in stops."""

    reason: str
    """Rule that set them."""


class _Options(NamedTuple):
    """Checked options of steps 3 to 9; lengths are in pixels of the working image."""

    sampling: str
    samples_per_pixel: float
    reach: int
    move_to_maximum: bool
    rule: MergeRule


def detect_photograph(
    image: AnyPhotograph,
    fov: float | None = None,
    *,
    colour: ColourArgument | None = None,
    part: str | int | None = None,
    max_lights: int | None = None,
    working_side: int = 1024,
    reduction: str = "bilinear",
    blur_px: float = 0.0,
    sampling: str = "halton",
    samples_per_pixel: float = 0.012,
    window_px: int | None = None,
    relative: bool = True,
    threshold: float = 0.8,
    rise: float = 2.0,
    suppression_px: float = 10.0,
    tolerance: float = 0.15,
    tolerance_stops: float = 1.5,
    ceiling: float = 1.25,
    merge_cap_px: float | None = None,
    move_to_maximum: bool = True,
) -> PhotographLights:
    """Lights of a photograph or another plane picture, by the steps of Loghin (2021).

    The plane is sampled with Halton points, as the article advises. Samples near a bright pixel are
    retained, samples near a brighter sample are suppressed, and samples that a bright line joins
    are merged. By default, levels follow the exposure and samples move to maxima.
    ``relative=False, move_to_maximum=False, samples_per_pixel=0.006, window_px=12`` is the article
    itself.

    Parameters
    ----------
    image : path-like, bytes, file object or array_like, shape (height, width, 3) or (height, width)
        The photograph, of any aspect. Files are read as in `EnvMap.open`. Arrays of uint8 and
        uint16 are decoded from sRGB; arrays of floating point are linear.
    fov : float, optional
        Horizontal field of view in degrees, below 180, of a camera without distortion. When left
        out, the file gives it: a picture of `EnvMap.view` states it, and EXIF has the focal length
        equivalent to 35 mm film, by the diagonal, or the focal length with the resolution of the
        sensor. A note names the source.
    colour, part
        Colour space of the samples of a file, and its layer; see `EnvMap.open`.
    max_lights : int, optional
        Largest number of lights. The dimmest are dropped; nothing is merged.
    working_side : int
        Pixels of the longer side of the reduced picture; a picture is not enlarged.
    reduction : {"bilinear", "area"}
        Reduction of the picture. Bilinear, as in the article, skips pixels.
    blur_px : float
        Standard deviation of a blur in the reduced picture; optional in the article, with 1 to 2.
    sampling : {"halton", "hammersley"}
        Sequence of points.
    samples_per_pixel : float
        Number of samples divided by the number of pixels of the reduced picture: 0.006 in the
        article.
    window_px : int, optional
        Width of the window around a sample, less one, in a picture of 1024 pixels: 12 in the
        article. By default 1.3 times the distance between samples, for pictures of any size.
    relative : bool
        True: the threshold comes from the histogram of the picture, by the rule of `detect`
        with equal weights of all pixels, and lines are checked in stops, so that the exposure has
        no influence. In a clipped picture, such as most of 8 bits, the levels of the article are
        relative to the clip level. False: they are absolute, as in the article.
    threshold : float
        Luminance that the brightest pixel of a window must exceed, in the article and in clipped
        pictures. It is linear: 0.8 is the code 231 of 255.
    rise : float
        Least ratio of the maximum of a light to the relative threshold, as in `detect`.
    suppression_px : float
        Samples closer to a brighter sample are suppressed, in a picture of 1024 pixels.
    tolerance, ceiling : float
        Limits of the absolute line check; see `kernels.merge_along_lines`.
    tolerance_stops : float
        Limit of the relative line check: largest difference of the mean of a line from its start,
        in stops (powers of two).
    merge_cap_px : float, optional
        Samples farther apart are not merged. The article has no such limit.
    move_to_maximum : bool
        True: samples climb from window to window to a maximum, and the place of a light is the mean
        over these maxima and over the samples on the light. False: they stay, as in the article.

    Returns
    -------
    PhotographLights
        Brightest first, with places in pixels. Each of n samples has ``height * width / n`` pixels
        at its first position, and with a field of view their solid angle. The sum over
        samples is right on average, and inaccurate for lights smaller than the distance between
        samples. No background is subtracted, because the article has none.

    Raises
    ------
    EnvLightsError
        If `image` is no picture, or an option is out of its range.

    See Also
    --------
    detect : the same for maps, and with `EnvMap(image, projection="planar", fov=...)` the component
        tree for photographs, which is more exact on linear pictures.

    Examples
    --------
    >>> photograph = np.full((60, 80, 3), 0.1)
    >>> photograph[18:24, 28:50] = 2.0
    >>> lights = detect_photograph(photograph, fov=60)
    >>> len(lights), bool(abs(lights.position[0] - (39, 21)).max() < 3)
    (1, True)
    >>> lights.direction.round(1) + 0.0
    array([[0. , 0.1, 1. ]])
    """
    start = time.perf_counter()
    options = (amount("threshold", threshold), amount("rise", rise), flag("relative", relative))
    photograph = photograph_pixels(image, colour, part)
    camera, notes = _camera(photograph, fov)
    luminance = images.luminance(photograph.radiance)
    working = _working_image(luminance, working_side, reduction, blur_px)
    levels = _levels(working, photograph.clip_level, *options)
    scale = max(working.shape) / _REFERENCE_PX
    cap = math.inf if merge_cap_px is None else scale * amount("merge_cap_px", merge_cap_px)
    absolute = amount("tolerance", tolerance), amount("ceiling", ceiling)
    limits = amount("tolerance_stops", tolerance_stops), _NO_LIMIT, _NO_LIMIT
    if levels.unit is not None:
        limits = levels.unit * absolute[0], levels.unit * absolute[1], levels.unit
    steps = _Options(
        sampling=sampling,
        samples_per_pixel=samples_per_pixel,
        reach=_reach(window_px, scale, amount("samples_per_pixel", samples_per_pixel, most=1.0)),
        move_to_maximum=flag("move_to_maximum", move_to_maximum),
        rule=MergeRule(scale * amount("suppression_px", suppression_px), cap, *limits),
    )
    samples, merged = _lights_of(working, levels, steps)
    report = DetectionReport(
        method="loghin",
        threshold=levels.bright,
        reason=levels.reason,
        working_size=(working.shape[0], working.shape[1]),
        details=(f"{samples.total - len(samples.pixel)} of {samples.total} samples are dark",),
        notes=(*photograph.notes, *notes),
        seconds={"detect": time.perf_counter() - start},
    )
    lights = measure(photograph, camera, luminance, working, samples, merged, report, steps.reach)
    return lights if max_lights is None else lights[: count("max_lights", max_lights, least=1)]


def _reach(window_px: int | None, scale: float, samples_per_pixel: float) -> int:
    """Pixels from a sample to the border of its window."""
    if window_px is not None:
        return int(count("window_px", window_px) * scale) // 2
    spacing = 1 / math.sqrt(samples_per_pixel) if samples_per_pixel > 0 else 0.0
    return round(_WINDOW_OVER_SPACING / 2 * min(spacing, _REFERENCE_PX))


def _lights_of(
    working: NDArray[np.float32], levels: _Levels, options: _Options
) -> tuple[BrightSamples, MergedSamples]:
    """Steps 3 to 9."""
    uv = square_points(options.sampling, working, options.samples_per_pixel)
    pixel = images.uv_to_pixel(uv, *working.shape)
    is_moved, reach = options.move_to_maximum, options.reach
    samples = bright_samples(working, pixel, reach, levels.bright, is_moved, sphere=False)
    if is_moved:
        samples = climb(working, samples, reach, levels.peak)
    lines = _stops(working, levels.bright) if levels.unit is None else working
    points = samples.pixel.astype(np.float64)
    merged = merged_samples(lines, samples, points, options.rule, sphere=False)
    if is_moved:
        means = _means_of_all(working, samples, merged, levels.bright)
        merged = replace(merged, means=means)
    return samples, merged


def _stops(working: NDArray[np.float32], bright: float) -> NDArray[np.float32]:
    """Luminance in stops above a level below the threshold."""
    bright = max(bright, float(working.max()) * 2.0**-_MOST_STOPS, _TINY)
    floor = np.float32(max(bright * 2.0**-_STOPS_BELOW, float(np.finfo(np.float32).tiny)))
    stops: NDArray[np.float32] = np.log2(np.maximum(working, floor) / floor)
    return stops


def _means_of_all(
    working: NDArray[np.float32], samples: BrightSamples, merged: MergedSamples, bright: float
) -> NDArray[np.float64]:
    """Mean place of each light, over the maxima that survive and the samples on the light.

    Maxima alone miss the middle of a broad light, and samples alone miss a small one.
    """
    at_first = working[samples.own_pixel[:, 0], samples.own_pixel[:, 1]]
    kept = np.unique(merged.survivor)
    points = np.concatenate([samples.pixel[kept], samples.own_pixel])
    weights = np.concatenate([samples.luminance[kept], np.where(at_first > bright, at_first, 0)])
    light = np.concatenate([merged.light[kept], merged.light])
    return loghin.weighted_means(points, weights, light)


def _camera(
    photograph: PhotographPixels, fov: float | None
) -> tuple[Layout | None, tuple[str, ...]]:
    """Layout for a horizontal field of view in degrees, or that of the file, with a note on it."""
    height, width, _ = photograph.radiance.shape
    if fov is not None:
        view = math.radians(amount("fov", fov, *_VIEWS_DEG))
        return layouts.planar(height, width, field_of_view=view), ()
    focal = photograph.focal
    view = 0.0 if focal is None else 2 * math.atan(width / 2 / focal.pixels)
    if focal is None or not _VIEWS_DEG[0] <= math.degrees(view) <= _VIEWS_DEG[1]:
        return None, ("no field of view is known, so there are no directions; give fov in degrees",)
    note = f"the horizontal field of view is {math.degrees(view):.1f} degrees, from {focal.origin}"
    return layouts.planar(height, width, field_of_view=view), (note,)


def _working_image(
    luminance: NDArray[np.float32], side: int, reduction: str, blur_px: float
) -> NDArray[np.float32]:
    """Steps 1 and 2: luminance with a longer side of at most `side` pixels."""
    check_choice("reduction", reduction, ("bilinear", "area"))
    side = min(count("working_side", side, least=16), max(luminance.shape))
    height, width = (max(round(each * side / max(luminance.shape)), 1) for each in luminance.shape)
    image = luminance
    if (height, width) != luminance.shape and reduction == "area":
        image = images.area_means(luminance, height, width).astype(np.float32)
    elif (height, width) != luminance.shape:
        image = images.resize_bilinear(luminance, height, width)
    return images.blur(image, blur_px) if amount("blur_px", blur_px) > 0 else image


def _levels(
    working: NDArray[np.float32],
    clip_level: float | None,
    threshold: float,
    rise: float,
    relative: bool,
) -> _Levels:
    """Levels of the article, the same for the clip level as 1, or those of the histogram."""
    bright, unit, rule = threshold, 1.0, ""
    if relative and clip_level is not None and float(working.max()) > threshold * clip_level:
        bright, unit, rule = threshold * clip_level, clip_level, "relative to the clip level"
    elif relative:
        bright = _native.plane_threshold(np.ascontiguousarray(working))
        rule = "from the histogram of the picture"
        return _Levels(bright, rise * bright, None, rule)
    fraction = 0.0 if clip_level is None else min(bright / clip_level, 1.0)
    code = 255 * float(encode_srgb(np.array(fraction)))
    return _Levels(bright, bright, unit, wording.reason_of_article(rule, bright, clip_level, code))
