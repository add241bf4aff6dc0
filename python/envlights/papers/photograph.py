"""Detection of lights in a photograph by the steps of Loghin (2021), in the image plane."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._common.check import amount, count, named_arguments
from envlights._common.former import former_settings
from envlights._common.notes import black_note
from envlights._common.tables import MOST_ROWS
from envlights._common.words import quantity
from envlights.detection.lights import DetectionReport
from envlights.environment.colour.choice import ColourArgument
from envlights.environment.layouts import picture_layout as layouts
from envlights.environment.layouts.picture_layout import PictureLayout
from envlights.kernels import image as images
from envlights.kernels import loghin, thumbnails
from envlights.papers.loghin_steps import (
    PHOTOGRAPH,
    REFERENCE_PX,
    MergeRule,
    Settings,
    Steps,
    blur,
    bright_samples,
    check_settings,
    climb,
    merged_samples,
    threshold_reason,
)
from envlights.papers.photograph_lights import PhotographLights, PhotographSamples
from envlights.papers.photograph_pixels import AnyPhotograph, PhotographPixels, photograph_pixels
from envlights.rigs.lights import brightest_first

#: Range of fields of view in degrees; a plane picture cannot show 180.
_VIEWS_DEG = (0.05, 179.0)
#: Stops below the threshold at which the relative line check stops to distinguish dark pixels.
#: Without it, a black pixel of a window bar would split a lamp.
_STOPS_BELOW = 2
#: Largest distance in stops from the picture maximum to this limit, for black pictures.
_MOST_STOPS = 30
#: Tolerance in stops that no luminance exceeds.
_NO_LIMIT = 1e3
#: Longer side of the picture that is stored with the lights for display.
_PICTURE_PX = 1024
#: Settings that only maps use.
_OF_MAPS = ("suppression_deg", "merge_cap_deg", "sphere")
#: Divisor that replaces a flux of 0.
_TINY = np.finfo(float).tiny


class _Levels(NamedTuple):
    """Luminance levels, with the rule that determined them."""

    bright: float
    """Luminance above which a pixel is bright."""

    peak: float
    """Smallest luminance for the maximum of a light."""

    unit: float | None
    """Luminance that replaces the article's unit in the line check; None for a check in stops."""

    reason: str
    """Rule that determined the levels, as text."""


@former_settings(max_lights="lights")
@named_arguments()
def detect_photograph(
    image: AnyPhotograph,
    fov: float | None = None,
    *,
    lights: int | None = None,
    colour: ColourArgument | None = None,
    part: str | int | None = None,
    working_side: int = 1024,
    settings: Settings = PHOTOGRAPH,
) -> PhotographLights:
    """Lights of a photograph or another plane picture, by the steps of Loghin (2021).

    The plane is sampled with Halton points, as the article advises. Samples near a bright pixel are
    retained, samples near a brighter sample are suppressed, and samples that a bright line joins
    are merged. By default, levels follow the exposure and samples move to maxima. The settings
    ``papers.loghin.Settings(sampling="halton")`` are the article itself.

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
    lights : int, optional
        Largest number of lights. The dimmest are dropped; nothing is merged.
    colour, part
        Colour space of the samples of a file, and its layer; see `EnvMap.open`.
    working_side : int
        Pixels of the longer side of the reduced picture; a picture is not enlarged.
    settings : papers.loghin.Settings
        Settings of the steps, by default ``papers.loghin.PHOTOGRAPH``.

    Returns
    -------
    PhotographLights
        Brightest first, with places in pixels. Each of n samples has ``height * width / n`` pixels
        at its first position, and with a field of view their solid angle. The sum over
        samples is right on average, and inaccurate for lights smaller than the distance between
        samples: a note states their uncertainty. No background is subtracted, because the article
        has none.

    Raises
    ------
    EnvLightsError
        If `image` is no picture, or an option is out of its range.

    See Also
    --------
    papers.loghin.detect : the same for maps.
    detect : with `EnvMap(image, layout=el.io.Layout.planar(fov=65))` the component tree for
        photographs, which is more exact on linear pictures.

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
    check_settings(settings, _OF_MAPS, "photograph")
    photograph = photograph_pixels(image, colour, part)
    camera, notes = _camera(photograph, fov)
    luminance = images.luminance(photograph.radiance)
    working = _working_image(luminance, working_side, settings)
    levels = _levels(working, photograph.clip_level, settings)
    steps = _steps(working, levels, settings)
    report = DetectionReport(
        method="loghin",
        threshold=levels.bright,
        reason=levels.reason,
        working_size=steps.size,
        details=steps.details,
        notes=(*black_note(luminance, "photograph"), *photograph.notes, *notes),
        seconds={"detect": time.perf_counter() - start},
    )
    found = _measure(photograph, camera, float(luminance.sum(dtype=np.float64)), steps, report)
    return found if lights is None else found[: count("lights", lights, least=1)]


def _steps(working: NDArray[np.float32], levels: _Levels, settings: Settings) -> Steps:
    """Results of steps 3 to 9."""
    points, reach = settings.points(working.size), settings.reach(max(working.shape))
    pixel = images.uv_to_pixel(points, *working.shape)
    samples = bright_samples(working, pixel, reach, levels.bright, settings)
    if settings.move_to_maximum:
        samples = climb(working, samples, reach, levels.peak)
    lines = _stops(working, levels.bright) if levels.unit is None else working
    rule = _rule(settings, max(working.shape) / REFERENCE_PX, levels.unit)
    merged = merged_samples(lines, samples, samples.pixel.astype(np.float64), rule, sphere=False)
    steps = Steps(working, points, samples, merged, reach, levels.bright)
    if settings.move_to_maximum:
        return replace(steps, merged=replace(merged, means=_means_of_all(steps)))
    return steps


def _rule(settings: Settings, scale: float, unit: float | None) -> MergeRule:
    """Merge rule with lengths in pixels of the working image."""
    cap = math.inf if settings.merge_cap_px is None else scale * settings.merge_cap_px
    limits = settings.tolerance_stops, _NO_LIMIT, _NO_LIMIT
    if unit is not None:
        limits = unit * settings.tolerance, unit * settings.ceiling, unit
    return MergeRule(scale * settings.suppression_px, cap, *limits)


def _stops(working: NDArray[np.float32], bright: float) -> NDArray[np.float32]:
    """Luminance in stops above a level below the threshold."""
    bright = max(bright, float(working.max()) * 2.0**-_MOST_STOPS, _TINY)
    floor = np.float32(max(bright * 2.0**-_STOPS_BELOW, float(np.finfo(np.float32).tiny)))
    stops: NDArray[np.float32] = np.log2(np.maximum(working, floor) / floor)
    return stops


def _means_of_all(steps: Steps) -> NDArray[np.float64]:
    """Mean position of each light, over its surviving maxima and the samples on it.

    Maxima alone miss the middle of a broad light, and samples alone miss a small one.
    """
    samples, merged, at_first = steps.samples, steps.merged, steps.first_luminance
    kept = np.unique(merged.survivor)
    own = np.where(at_first > steps.threshold, at_first, 0)
    points = np.concatenate([samples.pixel[kept], samples.first])
    weights = np.concatenate([samples.luminance[kept], own])
    light = np.concatenate([merged.light[kept], merged.light])
    return loghin.weighted_means(points, weights, light)


def _camera(
    photograph: PhotographPixels, fov: float | None
) -> tuple[PictureLayout | None, tuple[str, ...]]:
    """Layout for a horizontal field of view in degrees, or for that of the file, with a note."""
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
    luminance: NDArray[np.float32], side: int, settings: Settings
) -> NDArray[np.float32]:
    """Luminance reduced to at most `side` pixels on its longer side (steps 1 and 2)."""
    side = min(count("working_side", side, least=16), max(luminance.shape))
    height, width = (max(round(each * side / max(luminance.shape)), 1) for each in luminance.shape)
    image = luminance
    if (height, width) != luminance.shape and settings.reduction == "area":
        image = images.area_means(luminance, height, width).astype(np.float32)
    elif (height, width) != luminance.shape:
        image = images.resize_bilinear(luminance, height, width)
    return blur(image, settings, wrap=False)


def _levels(working: NDArray[np.float32], clip_level: float | None, settings: Settings) -> _Levels:
    """Levels of the article, levels relative to the clip level, or levels from the histogram."""
    bright, unit, rule = settings.threshold, 1.0, ""
    relative = settings.relative
    if relative and clip_level is not None and float(working.max()) > bright * clip_level:
        bright, unit, rule = bright * clip_level, clip_level, "relative to the clip level"
    elif relative:
        bright = _native.plane_threshold(np.ascontiguousarray(working))
        rule = "from the histogram of the picture"
        return _Levels(bright, settings.rise * bright, None, rule)
    return _Levels(bright, bright, unit, threshold_reason(rule, bright, clip_level))


def _measure(
    photograph: PhotographPixels,
    camera: PictureLayout | None,
    luminance: float,
    steps: Steps,
    report: DetectionReport,
) -> PhotographLights:
    """Lights measured from their samples, each at its first position."""
    radiance, samples, merged = photograph.radiance, steps.samples, steps.merged
    height, width, _ = shape = radiance.shape
    scale = np.array([height / steps.size[0], width / steps.size[1]])
    first = images.uv_to_pixel(steps.uv(samples.first), height, width)
    values = radiance[first[:, 0], first[:, 1]].astype(np.float64)
    each = height * width / max(len(steps.points), 1)
    flux = each * merged.sums(values)
    # A sample may cover more pixels than are bright around it.
    total = max(luminance, float((flux @ images.LUMINANCE).sum()))
    report = replace(report, notes=(*_uncertain(steps, flux, each), *report.notes))
    position = ((merged.means + 0.5) * scale)[:, ::-1]
    peaks, reach = steps.pixels_in(shape), steps.reach_in(shape)
    arrays: dict[str, Any] = {
        "position": position,
        "pixel_flux": flux,
        "peak_pixel": peaks,
        "peak_luminance": steps.peak_luminance,
        "flux_fraction": flux @ images.LUMINANCE / (total or 1.0),
        "is_clipped": _native.are_clipped(radiance, peaks, reach, False, photograph.clip_level),
    }
    if camera is not None:
        centres = ((samples.first + 0.5) * scale)[:, ::-1]
        weight = _solid_angles(camera, samples.first, steps.size, each)
        arrays["direction"] = _native.projection_directions(camera, np.ascontiguousarray(position))
        towards = _native.projection_directions(camera, np.ascontiguousarray(centres))
        sums, length = merged.flux(values, weight, towards)
        received = length / np.maximum(sums @ images.LUMINANCE, _TINY)
        arrays["irradiance"] = sums * received[:, None]
    places = samples.first, samples.pixel, samples.maximum
    return PhotographLights(
        **arrays,
        samples=PhotographSamples(*places, merged.survivor, merged.light),
        report=report,
        size=(height, width),
        field_of_view=None if camera is None else camera.field_of_view,
        picture=thumbnails.of_photograph(radiance, _PICTURE_PX, photograph.clip_level),
    )


def _uncertain(steps: Steps, flux: NDArray[np.float64], each: float) -> tuple[str, ...]:
    """Note on lights whose flux may be wrong by a factor of 2; a sample covers `each` pixels.

    The number of samples on a light scatters by its root, so 95 % are within two of those.
    """
    is_bright = steps.first_luminance > steps.threshold
    samples = np.bincount(steps.merged.light[is_bright], minlength=len(flux))
    texts = []
    for number, hits in enumerate(samples[brightest_first(flux)].tolist(), 1):
        factor = math.exp(2 / math.sqrt(hits)) if hits else math.inf
        by = f"a factor of {factor:.2g}" if hits else "unknown"
        texts += [f"light {number} {by} ({quantity(hits, 'sample')})"] if factor > 2 else []
    if not texts:
        return ()
    more = f"; and {len(texts) - MOST_ROWS} more" if len(texts) > MOST_ROWS else ""
    return (
        f"the irradiance and the flux of small lights are uncertain, with {each:.3g} pixels for one"
        f" sample: {'; '.join(texts[:MOST_ROWS])}{more}",
    )


def _solid_angles(
    camera: PictureLayout, pixel: NDArray[np.int64], size: tuple[int, int], each: float
) -> NDArray[np.float64]:
    """Solid angle of `each` pixels of the photograph, at positions in the working image.

    The working image is a photograph with square pixels and the same horizontal field of view.
    """
    angles = _native.projection_solid_angles(camera._replace(height=size[0], width=size[1]))
    pixels_of_photograph = (camera.width / size[1]) ** 2
    chosen: NDArray[np.float64] = angles[pixel[:, 0], pixel[:, 1]]
    return chosen * (each / pixels_of_photograph)
