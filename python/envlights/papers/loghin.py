"""Loghin (2021): detection of lights, its steps on arrays, and its settings.

`detect` runs the steps on a map, `envlights.detect_photograph` on a photograph, and
`envlights.plot.loghin_picture` draws them. The steps themselves are functions on arrays:
`neighbour_maximum` is step 5, the brightest pixel around each sample; `suppress` is step 7,
suppression near brighter samples; `bresenham_line` and `merge_along_lines` are step 8, lines
between samples and their merging; `weighted_means` is step 9.
"""

from __future__ import annotations

import time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._common.check import count
from envlights._common.former import former_settings
from envlights.detection.detect import detect as detect_tree
from envlights.detection.lights import DetectedLights, DetectionReport
from envlights.detection.members import Members
from envlights.environment.envmap import EnvMap
from envlights.environment.reading import AnyMap, as_envmap
from envlights.kernels import image as images
from envlights.kernels import sampling as sampling_kernels
from envlights.kernels.loghin import (
    bresenham_line,
    merge_along_lines,
    neighbour_maximum,
    suppress,
    weighted_means,
)
from envlights.kernels.sphere import direction_to_uv, pixel_solid_angles, uv_to_direction
from envlights.papers.loghin_steps import (
    PHOTOGRAPH,
    MergedSamples,
    MergeRule,
    Settings,
    Steps,
    blur,
    bright_samples,
    check_settings,
    merged_samples,
    threshold_reason,
)

__all__ = [
    "PHOTOGRAPH",
    "Settings",
    "bresenham_line",
    "detect",
    "merge_along_lines",
    "neighbour_maximum",
    "suppress",
    "weighted_means",
]

#: Default settings for maps, as in the article.
_MAP = Settings()
#: Settings that only photographs use.
_OF_PHOTOGRAPHS = ("rise", "suppression_px", "merge_cap_px", "tolerance_stops")
#: Divisor that replaces a flux of 0.
_TINY = np.finfo(float).tiny


class Detection(NamedTuple):
    """Detected lights, with the intermediate results."""

    lights: DetectedLights
    steps: Steps
    light: NDArray[np.int64]
    """Index of the light of each bright sample, (k,); dropped lights have the highest indices."""


@former_settings(max_lights="lights")
def detect(
    env: AnyMap,
    *,
    lights: int | None = None,
    working_width: int = 1024,
    settings: Settings = _MAP,
) -> DetectedLights:
    """Detect the lights of a map by the method of Loghin (2021).

    The sphere is sampled evenly. Samples near a bright pixel are retained, samples
    near a brighter sample are suppressed, and samples that a bright line joins are merged. The
    defaults are those of the article, with its errors corrected: 32-bit masks, a line check that
    ends, ``sum(w p) / sum(w)``, only survivors suppress and merge, pixel centres, the frame of
    `EnvMap`. The settings `relative`, `move_to_maximum`, `sphere` and `merge_cap_deg` improve on
    the article.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map.
    lights : int, optional
        Largest number of lights. The dimmest are dropped; nothing is merged.
    working_width : int
        Largest number of columns of the reduced map; a map is not enlarged.
    settings : papers.loghin.Settings
        Settings of the steps, by default those of the article.

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

    See Also
    --------
    detect_photograph : the same for photographs.
    plot.loghin_picture : a picture of the steps.

    Examples
    --------
    >>> import envlights as el
    >>> lamp = el.synthetic.Disc((1, 1, 0), 8.0, (1, 1, 1))
    >>> env = el.EnvMap(el.synthetic.scene(256, background=[0.1] * 3, shapes=[lamp]).radiance)
    >>> detect(env).direction.round(1) + 0.0
    array([[0.7, 0.7, 0. ]])
    """
    return detect_with_steps(env, lights, working_width, settings).lights


@former_settings(max_lights="lights")
def detect_with_steps(
    env: AnyMap,
    lights: int | None = None,
    working_width: int = 1024,
    settings: Settings = _MAP,
) -> Detection:
    """Lights of a map, with the intermediate results; see `detect`."""
    env = as_envmap(env)
    start = time.perf_counter()
    check_settings(settings, _OF_PHOTOGRAPHS, "map")
    unit = _unit_of_luminance(env, settings.threshold) if settings.relative else 1.0
    steps = _steps(env, _working_image(env, working_width, settings), unit, settings)
    rule = "chosen by the tree method's rule" if settings.relative else ""
    report = DetectionReport(
        method="loghin",
        threshold=steps.threshold,
        reason=threshold_reason(rule, steps.threshold, env.clip_level),
        working_size=steps.size,
        details=steps.details,
        notes=(*env.notes, *_registration_notes(env)),
        seconds={"detect": time.perf_counter() - start},
    )
    found = _lights(env, steps, report, settings.sphere)
    light = found.members.light
    kept = found if lights is None else found[: count("lights", lights, least=1)]
    return Detection(kept, steps, light)


def _steps(env: EnvMap, image: NDArray[np.float32], unit: float, settings: Settings) -> Steps:
    """Results of steps 3 to 9, with `unit` replacing the luminance of 1 in the article."""
    height, width = image.shape
    reach, level = settings.reach(width), unit * settings.threshold
    points = direction_to_uv(sampling_kernels.uniform_sphere(settings.points(image.size)))
    pixel = images.uv_to_pixel(points, height, width)
    samples = bright_samples(image, pixel, reach, level, settings)
    if env.coverage is not None:
        uv = (samples.first[:, ::-1] + 0.5) / (width, height)
        samples = samples.of(
            env.coverage[tuple(images.uv_to_pixel(uv, env.height, env.width).T)] > 0
        )
    sphere, cap = settings.sphere, settings.merge_cap_deg
    rule = MergeRule(
        apart=_distance(settings.suppression_deg, width, sphere),
        farthest=np.inf if cap is None else _distance(cap, width, sphere),
        tolerance=unit * settings.tolerance,
        ceiling=unit * settings.ceiling,
        bright=unit,
    )
    where = _points(samples.pixel, image.shape, sphere)
    merged = merged_samples(image, samples, where, rule, sphere)
    return Steps(image, points, samples, merged, reach, level)


def _working_image(env: EnvMap, width: int, settings: Settings) -> NDArray[np.float32]:
    """Luminance in at most `width` columns (steps 1 and 2)."""
    width = min(count("working_width", width, least=16), env.width)
    if settings.reduction == "area":
        image = images.reduced_luminance(env.radiance, width, border_sampled=env.is_border_sampled)
    else:
        image = images.luminance(env.radiance)
        if width < env.width:
            image = images.resize_bilinear(image, width // 2, width, wrap=True)
    return blur(image, settings, wrap=True)


def _registration_notes(env: EnvMap) -> tuple[str, ...]:
    if env.registration == "cell-centred":
        return ()
    return (
        "the map is border-sampled, but the article treats pixels as cells, so directions may be"
        " wrong by up to half a pixel",
    )


def _unit_of_luminance(env: EnvMap, threshold: float) -> float:
    """Luminance that replaces the article's unit, so that its threshold equals that of `detect`."""
    level = detect_tree(env).report.threshold
    return level / threshold if level > 0 and threshold > 0 else 1.0


def _points(pixel: NDArray[np.int64], size: tuple[int, ...], sphere: bool) -> NDArray[np.float64]:
    """Positions of pixels: unit vectors on the sphere, otherwise rows and columns."""
    if not sphere:
        return pixel.astype(np.float64)
    return uv_to_direction((pixel[:, ::-1] + 0.5) / (size[1], size[0]))


def _distance(angle_deg: float, width: int, sphere: bool) -> float:
    """Distance between two `_points` with this angle between them."""
    return float(2 * np.sin(np.deg2rad(angle_deg) / 2)) if sphere else angle_deg * width / 360


def _lights(env: EnvMap, steps: Steps, report: DetectionReport, sphere: bool) -> DetectedLights:
    """Measure each light from its samples; each sample covers 4 pi / n steradians."""
    merged, each = steps.merged, 4 * np.pi / max(len(steps.points), 1)
    means = merged.means
    direction = uv_to_direction(steps.uv(means)) if means.shape[1] == 2 else _unit(means)
    # Measure each sample at its first position. All samples around a lamp may have moved to its
    # maximum, which would overestimate a lamp of 2 degrees by a factor of 4.
    first = uv_to_direction(steps.uv(steps.samples.first))
    pixel = images.uv_to_pixel(direction_to_uv(first), env.height, env.width)
    radiance = env.radiance[pixel[:, 0], pixel[:, 1]].astype(np.float64)
    sums, length = merged.flux(radiance, np.ones(len(first)), first)
    flux = each * sums
    luminance = flux @ images.LUMINANCE
    received = each * length / np.maximum(luminance, _TINY)
    is_bright = steps.first_luminance > steps.threshold
    bright = np.bincount(merged.light, is_bright, minlength=len(direction))
    elongation, orientation = _shapes(first, direction, merged)
    bands = pixel_solid_angles(steps.size[0], 2)[:, 0] * 2 / steps.size[1]
    # A sample may cover a much larger solid angle than its bright pixels, for example at a pole.
    total = max(float(steps.image.sum(axis=1) @ bands), float(luminance.sum())) or 1.0
    # As in `detect`, look for a flat top in the pixels of the full map.
    shape = env.radiance.shape
    peaks, reach = steps.pixels_in(shape), steps.reach_in(shape)
    return DetectedLights(
        direction,
        flux * received[:, None],
        flux=flux,
        peak_direction=uv_to_direction(steps.uv(merged.peak)),
        solid_angle=each * np.maximum(bright, 1.0),
        elongation=elongation,
        orientation=orientation,
        peak_luminance=steps.peak_luminance,
        flux_fraction=luminance / total,
        is_clipped=_native.are_clipped(env.radiance, peaks, reach, sphere, env.clip_level),
        members=Members(steps.samples.pixel, merged.light),
        report=report,
        units=env.units,
    )


def _shapes(
    first: NDArray[np.float64], direction: NDArray[np.float64], merged: MergedSamples
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Elongation and long axis of each light, from second moments of its samples."""
    offset = first - direction[merged.light]
    moments = (offset[:, :, None] * offset[:, None, :]).reshape(-1, 9)
    values, axes = np.linalg.eigh(merged.sums(moments).reshape(-1, 3, 3))
    with np.errstate(invalid="ignore", divide="ignore"):
        elongation = np.sqrt(values[:, 2] / values[:, 1])
    along = axes[:, :, 2]
    along = along - np.sum(along * direction, axis=1, keepdims=True) * direction
    return np.where(values[:, 1] > 1e-12, elongation, 1.0), _unit(along)


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    unit: NDArray[np.float64] = vectors / np.maximum(lengths, _TINY)
    return unit
