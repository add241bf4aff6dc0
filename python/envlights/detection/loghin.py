"""Detection by the steps of Loghin (2021)."""

from __future__ import annotations

import math
import time

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._check import amount, check_choice, count, flag
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
from envlights.detection.component_tree import detect_tree
from envlights.detection.lights import DetectedLights, DetectionReport
from envlights.detection.members import Members
from envlights.envmap import AnyMap, EnvMap, as_envmap
from envlights.kernels import image as images
from envlights.kernels import sampling as sampling_kernels
from envlights.kernels.sphere import direction_to_uv, pixel_solid_angles, uv_to_direction

#: Divisor in place of a flux of 0.
_TINY = np.finfo(float).tiny


def detect_article(
    env: AnyMap,
    *,
    max_lights: int | None = None,
    working_width: int = 1024,
    reduction: str = "bilinear",
    blur_px: float = 0.0,
    samples_per_pixel: float = 0.006,
    window_px: int = 12,
    threshold: float = 0.8,
    suppression_deg: float = 5.0,
    tolerance: float = 0.15,
    ceiling: float = 1.25,
    merge_cap_deg: float | None = None,
    relative: bool = False,
    move_to_maximum: bool = False,
    sphere: bool = False,
    sampling: str = "hammersley",
) -> DetectedLights:
    """Lights of a map by the steps of Loghin (2021).

    The sphere is sampled evenly. Samples near a bright pixel are retained, samples
    near a brighter sample are suppressed, and samples that a bright line joins are merged. The
    defaults are those of the article, with its errors corrected: 32-bit masks, a line check that
    ends, ``sum(w p) / sum(w)``, only survivors suppress and merge, pixel centres, the frame of
    `EnvMap`. `relative`, `move_to_maximum`, `sphere` and `merge_cap_deg` improve on the article.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map.
    max_lights : int, optional
        Largest number of lights. The dimmest are dropped; nothing is merged.
    working_width : int
        Largest number of columns of the reduced map; a map is not enlarged.
    reduction : {"bilinear", "area"}
        Reduction of the map. Bilinear, as in the article, skips pixels.
    blur_px : float
        Standard deviation of a blur; optional in the article, with 1 to 2.
    samples_per_pixel : float
        Number of samples divided by the number of pixels of the reduced map.
    window_px : int
        Width of the window around a sample, less one, in a map of 1024 columns.
    threshold : float
        Luminance that the brightest pixel of a window must exceed. It is linear: 8-bit pictures
        are decoded from sRGB when they are opened, so 0.8 is the code 231 of 255.
    suppression_deg : float
        Samples closer to a brighter sample are suppressed. The article gives no number; the
        default is 1.5 times the distance between samples.
    tolerance, ceiling : float
        Limits of the line check; see `kernels.merge_along_lines`.
    merge_cap_deg : float, optional
        Samples farther apart are not merged. The article has no such limit.
    relative : bool
        If true, the threshold is that of `detect_tree`, from the map's histogram, and the levels of
        the line check are relative to it. In the article all are absolute.
    move_to_maximum : bool
        If true, a sample moves to the brightest pixel of its window. In the article it stays.
    sphere : bool
        If true, windows, distances, lines and means are those on the sphere, across the seam. In
        the article they are those on the image.
    sampling : {"hammersley", "halton"}
        Sequence of points, mapped to the sphere at equal solid angles.

    Returns
    -------
    DetectedLights
        Brightest first. Each of n samples has ``4 pi / n`` steradians at its first position. The
        flux of a light is the sum over its samples: right on average, and inaccurate for lights
        smaller than the distance between samples (3.6 degrees at 1024 columns). The irradiance
        comes from the same samples, without subtraction of a background, because the article has
        none. The solid angle is that of the samples above the threshold, at least one. If the
        lights have more flux than the map, their `flux_fraction` is that of their own sum.

    Raises
    ------
    EnvLightsError
        If `env` is not a map or an option is out of its range.

    Examples
    --------
    >>> import envlights as el
    >>> lamp = el.synthetic.Disc((1, 1, 0), 8.0, (1, 1, 1))
    >>> env = el.EnvMap(el.synthetic.scene(256, background=[0.1] * 3, shapes=[lamp]).radiance)
    >>> detect_article(env).direction.round(1) + 0.0
    array([[0.7, 0.7, 0. ]])
    """
    env = as_envmap(env)
    start = time.perf_counter()
    relative = flag("relative", relative)
    move_to_maximum = flag("move_to_maximum", move_to_maximum)
    threshold = amount("threshold", threshold)
    unit = _unit_of_luminance(env, threshold) if relative else 1.0
    level = unit * threshold
    image = _working_image(env, working_width, reduction, blur_px)
    height, width = image.shape
    reach = int(count("window_px", window_px) * width / 1024) // 2
    uv = direction_to_uv(
        sampling_kernels.uniform_sphere(square_points(sampling, image, samples_per_pixel))
    )
    pixel = images.uv_to_pixel(uv, height, width)
    samples = bright_samples(image, pixel, reach, level, move_to_maximum, sphere)
    samples = _seen_samples(env, image.shape, samples)
    farthest = np.inf
    if merge_cap_deg is not None:
        farthest = _distance("merge_cap_deg", merge_cap_deg, width, sphere)
    rule = MergeRule(
        apart=_distance("suppression_deg", suppression_deg, width, sphere),
        farthest=farthest,
        tolerance=unit * amount("tolerance", tolerance),
        ceiling=unit * amount("ceiling", ceiling),
        bright=unit,
    )
    merged = merged_samples(
        image, samples, _points(samples.pixel, image.shape, sphere), rule, sphere
    )
    report = DetectionReport(
        method="article",
        threshold=level,
        reason=_reason(env, level, relative),
        working_size=(height, width),
        details=(f"{samples.total - len(samples.pixel)} of {samples.total} samples are dark",),
        notes=(*env.notes, *_registration_notes(env)),
        seconds={"detect": time.perf_counter() - start},
    )
    lights = _lights(env, image, samples, merged, report, reach, sphere)
    return lights if max_lights is None else lights[: count("max_lights", max_lights, least=1)]


def _working_image(env: EnvMap, width: int, reduction: str, blur_px: float) -> NDArray[np.float32]:
    """Steps 1 and 2: luminance in at most `width` columns."""
    check_choice("reduction", reduction, ("bilinear", "area"))
    width = min(count("working_width", width, least=16), env.width)
    if reduction == "area":
        border_sampled = env.registration == "border-sampled"
        image = images.reduced_luminance(env.radiance, width, border_sampled=border_sampled)
    else:
        image = images.luminance(env.radiance)
        if width < env.width:
            image = images.resize_bilinear(image, width // 2, width, wrap=True)
    return images.blur(image, blur_px, wrap=True) if amount("blur_px", blur_px) > 0 else image


def _reason(env: EnvMap, level: float, relative: bool) -> str:
    """Rule that set the threshold."""
    rule = "chosen by the tree method's rule" if relative else ""
    share = 0.0 if env.white is None else min(level / env.white, 1.0)
    code = 255 * float(encode_srgb(np.array(share)))
    return wording.reason_of_article(rule, level, env.white, code)


def _registration_notes(env: EnvMap) -> tuple[str, ...]:
    if env.registration == "cell-centred":
        return ()
    return (
        "the map is border-sampled, but the article treats pixels as cells, so directions may be"
        " wrong by up to half a pixel",
    )


def _unit_of_luminance(env: EnvMap, threshold: float) -> float:
    """Luminance that replaces the article's 1, so that its threshold becomes the tree's."""
    level = detect_tree(env).report.threshold
    return level / threshold if level > 0 and threshold > 0 else 1.0


def _seen_samples(env: EnvMap, size: tuple[int, ...], samples: BrightSamples) -> BrightSamples:
    """Samples in the seen part of the map."""
    if env.seen is None:
        return samples
    uv = (samples.own_pixel[:, ::-1] + 0.5) / (size[1], size[0])
    row, column = images.uv_to_pixel(uv, env.height, env.width).T
    is_seen = env.seen[row, column] > 0
    return BrightSamples(
        samples.pixel[is_seen],
        samples.luminance[is_seen],
        samples.own_pixel[is_seen],
        samples.maximum[is_seen],
        samples.total,
    )


def _points(pixel: NDArray[np.int64], size: tuple[int, ...], sphere: bool) -> NDArray[np.float64]:
    """Positions of pixels: unit vectors on the sphere, else rows and columns."""
    if not sphere:
        return pixel.astype(np.float64)
    return uv_to_direction((pixel[:, ::-1] + 0.5) / (size[1], size[0]))


def _distance(name: str, angle_deg: float, width: int, sphere: bool) -> float:
    """Distance between two `_points` that are an angle apart."""
    angle = amount(name, angle_deg, most=180.0)
    return float(2 * np.sin(np.deg2rad(angle) / 2)) if sphere else angle * width / 360


def _directions(means: NDArray[np.float64], size: tuple[int, ...]) -> NDArray[np.float64]:
    """Unit vectors of `_points` or of their means."""
    if means.shape[1] == 2:
        return uv_to_direction((means[:, ::-1] + 0.5) / (size[1], size[0]))
    return _unit(means)


def _lights(
    env: EnvMap,
    image: NDArray[np.float32],
    samples: BrightSamples,
    merged: MergedSamples,
    report: DetectionReport,
    reach: int,
    sphere: bool,
) -> DetectedLights:
    """Measure each light on its samples; each has 4 pi / n steradians."""
    direction = _directions(merged.means, image.shape)
    lights, each = len(direction), 4 * np.pi / max(samples.total, 1)
    # Measure each sample at its first position. All samples around a lamp may have moved to its
    # maximum, where a lamp of 2 degrees would count four times.
    first = _points(samples.own_pixel, image.shape, sphere=True)
    place = images.uv_to_pixel(direction_to_uv(first), env.height, env.width)
    radiance = env.radiance[place[:, 0], place[:, 1]].astype(np.float64)
    flux = each * sums_of_lights(radiance, merged.light, lights)
    vectors = sums_of_lights((radiance @ images.LUMINANCE)[:, None] * first, merged.light, lights)
    towards = each * np.linalg.norm(vectors, axis=1) / np.maximum(flux @ images.LUMINANCE, _TINY)
    is_bright = image[samples.own_pixel[:, 0], samples.own_pixel[:, 1]] > report.threshold
    bright = np.bincount(merged.light, is_bright, minlength=lights)
    elongation, orientation = _shapes(first, direction, merged.light)
    bands = pixel_solid_angles(image.shape[0], 2)[:, 0] * 2 / image.shape[1]
    # A sample may stand for many times the solid angle of a bright pixel, as at a pole.
    total = max(float(image.sum(axis=1) @ bands), float((flux @ images.LUMINANCE).sum())) or 1.0
    return DetectedLights(
        direction,
        flux * towards[:, None],
        flux=flux,
        peak_direction=_points(merged.peak, image.shape, sphere=True),
        solid_angle=each * np.maximum(bright, 1.0),
        elongation=elongation,
        orientation=orientation,
        peak_luminance=image[merged.peak[:, 0], merged.peak[:, 1]].astype(np.float64),
        flux_fraction=flux @ images.LUMINANCE / total,
        is_clipped=_are_clipped(env, image.shape, merged, reach, sphere),
        members=Members(samples.pixel, merged.light),
        report=report,
        units=env.units,
    )


def _are_clipped(
    env: EnvMap, size: tuple[int, ...], merged: MergedSamples, reach: int, sphere: bool
) -> NDArray[np.bool_]:
    """True for each light with a flat top at the maximum, in the window of its brightest sample.

    As in `detect_tree`, the pixels of the full map count.
    """
    height, width = size
    uv = (merged.peak[:, ::-1] + 0.5) / (width, height)
    place = images.uv_to_pixel(uv, env.height, env.width)
    reach_in_map = math.ceil((reach + 0.5) * env.width / width)
    return _native.are_clipped(env.radiance, place, reach_in_map, sphere, env.white)


def _shapes(
    first: NDArray[np.float64], direction: NDArray[np.float64], light: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Elongation and long axis of each light, from the second moments of its samples."""
    offset = first - direction[light]
    moments = (offset[:, :, None] * offset[:, None, :]).reshape(-1, 9)
    matrices = sums_of_lights(moments, light, len(direction)).reshape(-1, 3, 3)
    values, axes = np.linalg.eigh(matrices)
    with np.errstate(invalid="ignore", divide="ignore"):
        elongation = np.sqrt(values[:, 2] / values[:, 1])
    along = axes[:, :, 2]
    along = along - np.sum(along * direction, axis=1, keepdims=True) * direction
    return np.where(values[:, 1] > 1e-12, elongation, 1.0), _unit(along)


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    unit: NDArray[np.float64] = vectors / np.maximum(lengths, _TINY)
    return unit
