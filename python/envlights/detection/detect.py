"""Detection of lights by the component tree."""

from __future__ import annotations

import inspect
import math
import time
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._common.check import LARGEST_COUNT, amount, count, named_arguments, positive
from envlights._common.notes import black_note
from envlights.detection import wording
from envlights.detection.colour_casts import colour_cast_notes
from envlights.detection.lights import DetectedLights, DetectionReport
from envlights.detection.members import Members
from envlights.environment.envmap import EnvMap
from envlights.environment.light import mean_radiance
from envlights.environment.open import doubts_of_array
from envlights.environment.reading import AnyMap, apply_to_map

#: Smallest number of columns of the reduced map.
_LEAST_COLUMNS = 16


class TreeOptions(NamedTuple):
    """Options of the kernel; for defaults see the signature of `detect`."""

    working_columns: int
    threshold: float | None
    rise: float
    prominence: float
    extent: float
    gap: float
    min_flux_fraction: float
    min_worth: float
    max_lights: int
    clip_level: float | None


@named_arguments()
def detect(
    env: AnyMap,
    *,
    lights: int | None = None,
    max_lights: int | None = None,
    min_flux_fraction: float = 0.0,
    min_worth: float = 0.0005,
    threshold: float | None = None,
    rise: float = 2.5,
    prominence: float = 4.0,
    gap_deg: float = 0.8,
    extent: float = 0.1,
    working_width: int = 1024,
    clip_level: float | None = None,
) -> DetectedLights:
    r"""Detect the lights of a map, as branches of its component tree.

    Pixels above a threshold, which is chosen from the map's histogram, are connected from the
    brightest down, across the seam and the poles. Where two regions meet, the dimmer one stays a
    light of its own if its peak is `prominence` times the level at which they meet. Each light is
    then measured in the map's own pixels. The method goes back to Loghin (2021).
    Loghin tests the straight line between two samples; the tree finds the brightest path.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map.
    lights : int, optional
        Largest number of lights, the brightest first. The others are left where they are, in the
        remainder of the report.
    max_lights : int, optional
        The same by merging: neighbours are merged until it is reached, the pair with the least cost
        first (Ward 1963); no flux is dropped.
    min_flux_fraction : float
        Lights with a smaller fraction of the map's flux are dropped.
    min_worth : float
        Least product of a light's fraction of the map's flux and its contrast, the ratio of its
        peak to the local background. 0 lists all lights. Clipped maps have a rule of their own;
        see Notes.
    threshold : float, optional
        Luminance above which a pixel is bright. By default it is chosen from the map. To use the
        threshold of another map, give ``other.report.threshold``.
    rise : float
        Least ratio of a light's peak to the threshold. A light extends down to the threshold.
    prominence : float
        Least ratio of a light's peak to its saddle; 1 keeps every local maximum apart.
    gap_deg : float
        Dark gaps of up to this many degrees do not divide a light. Wider window bars do not divide
        a window, see Notes; 0 keeps all panes apart.
    extent : float
        A light ends where its luminance has fallen to this fraction of its peak.
    working_width : int
        Largest number of columns of the reduced map in which lights are searched. A clipped map is
        reduced to half of them, and further if more than 12 % of the sphere is bright.
    clip_level : float, optional
        Largest value that the map can hold, in place of `EnvMap.clip_level`. Without either, the
        flat top of floats that are decoded 8-bit codes of sRGB.

    Returns
    -------
    DetectedLights
        Brightest first; `report` holds the threshold with its reason, and what was dropped.

    Raises
    ------
    EnvLightsError
        If `env` is not a map or an option is out of its range.

    Notes
    -----
    Two lights that do not touch are panes of one window if the bar between them

    - is at most 2.5 degrees wide, and at most half as wide as the panes,
    - lies along at least a quarter of their sides, and
    - has at most 0.8 of their luminance,

    and if their mean luminances differ by at most a factor of 4. The joined light has the flux of
    its panes. The rule is ours.

    The threshold is the same everywhere in the map. A window that is three times as bright as the
    wall around it is missed if the sky is brighter.

    Clipped maps, such as 8-bit pictures, have rules of their own, because their threshold would
    often lie above the clip level. Luminance :math:`y`, in units of the clip level, is expanded to
    :math:`y / (1.02 - y)` first, so that the clip level becomes 50. Pixels of 0.985 and more form
    clipped regions; the depth of a pixel is its angle to the rim. A light is divided where its
    clipped region has a neck of less than half its depth, and points to the centroid of its region,
    weighted by the square of the depth. Clipping makes the fluxes of lights similar, so lights are
    ordered by `DetectedLights.weight` instead: the expanded flux, divided by the 3/4 power of the
    solid angle, times :math:`e^{1.5 \sin}` of the elevation. Lights with less than 1 % of the
    total weight are dropped; clipped regions on the floor are dropped too. The
    `direction_uncertainty` is calibrated on pictures of HDR maps. Irradiance and flux are lower
    bounds. The rules are ours; the expansion inverts that of Schlick (1994).

    Of a map that shows a part of the sphere (`EnvMap.coverage`), only this part has lights, and
    only it counts for the threshold and for the background of a light. Lights that touch its border
    are flagged by `DetectedLights.is_cut`.

    Some pictures are tone-mapped so that their brightest pixels pile up between 0.7 of the largest
    possible value and that value. This pile is then the clip level. Other pictures whose
    maximum is below the largest possible value are not clipped, and are treated as any other map.

    Examples
    --------
    Two lamps, the second across the seam:

    >>> import envlights as el
    >>> lamps = [el.synthetic.Disc((1, 1, 0), 4.0, (9, 9, 9)),
    ...          el.synthetic.Disc((0, 0, -1), 2.0, (9, 6, 3))]
    >>> lights = detect(el.synthetic.scene(256, background=[0.1] * 3, shapes=lamps).radiance)
    >>> lights.direction.round(2) + 0.0
    array([[ 0.71,  0.71,  0.  ],
           [ 0.  ,  0.  , -1.  ]])
    """
    arguments = {**locals()}
    return detect_with_luminance(**arguments)[0]


def detect_with_luminance(
    env: AnyMap, **options: Any
) -> tuple[DetectedLights, NDArray[np.float32]]:
    """Lights of `detect`, and the luminance of the reduced map."""
    start = time.perf_counter()
    arguments = inspect.signature(detect).bind(env, **options)
    arguments.apply_defaults()
    checked, most = _options(arguments.kwargs), arguments.kwargs["lights"]
    most = None if most is None else count("lights", most)

    def detection_in(world: EnvMap) -> _native.TreeDetection:
        clip_level = checked.clip_level
        clip_level = world._pixels.clip_level_of_picture if clip_level is None else clip_level
        options_of_map = checked._replace(clip_level=clip_level)
        return _native.detect_tree(
            world.radiance, world.is_border_sampled, options_of_map, world.coverage
        )

    world, detection = apply_to_map(arguments.args[0], detection_in)
    casts = colour_cast_notes(world, detection.peak_direction, detection.peak_luminance)
    notes = (*black_note(detection.luminance), *world.notes, *casts)
    if world is not env:
        overview = detection.luminance.reshape(*detection.working_size, 1)
        notes += doubts_of_array(world._pixels, overview)
    lights = _lights(detection, notes, time.perf_counter() - start, world)
    if most is not None and len(lights) > most:
        left, lights = len(lights) - most, lights[:most]
        skipped = (*lights.report.skipped, wording.left_out(left))
        rest = _remainder(world, lights.flux)
        lights = replace(lights, report=replace(lights.report, skipped=skipped, remainder=rest))
    return lights, detection.luminance


def _remainder(world: EnvMap, flux: NDArray[np.float64]) -> tuple[float, ...]:
    """Mean radiance of the map without the flux of its lights, at least 0."""
    seen = world.coverage_fraction
    mean = mean_radiance(world.radiance, world.is_border_sampled, seen)
    mean -= flux.sum(axis=0) / (4 * np.pi * (seen or 1.0))
    return tuple(np.maximum(mean, 0.0).tolist())


def _options(given: dict[str, Any]) -> TreeOptions:
    """Checked arguments of `detect`."""

    def number(name: str, least: float = 0.0, most: float = math.inf) -> float:
        return amount(name, given[name], least, most)

    threshold, lights, level = given["threshold"], given["max_lights"], given["clip_level"]
    return TreeOptions(
        working_columns=count("working_width", given["working_width"], least=_LEAST_COLUMNS),
        threshold=None if threshold is None else number("threshold"),
        rise=number("rise", least=1.0),
        prominence=number("prominence", least=1.0),
        extent=number("extent", most=1.0),
        gap=math.radians(number("gap_deg", most=90.0)),
        min_flux_fraction=number("min_flux_fraction", most=1.0),
        min_worth=number("min_worth"),
        max_lights=LARGEST_COUNT if lights is None else count("max_lights", lights, 1),
        clip_level=None if level is None else positive("clip_level", level),
    )


def _lights(
    detection: _native.TreeDetection, notes: tuple[str, ...], seconds: float, world: EnvMap
) -> DetectedLights:
    clipped = detection.clipped
    report = DetectionReport(
        method="tree",
        threshold=detection.threshold,
        reason=wording.reason_of_tree(detection),
        working_size=detection.working_size,
        clip_level=clipped and clipped.clip_level,
        skipped=wording.dropped_by_tree(detection),
        notes=(*wording.joined_panes(detection), *wording.cut_lights(detection), *notes),
        remainder=_remainder(world, detection.flux),
        details=wording.details_of_tree(detection),
        seconds={"detect": seconds},
    )
    return DetectedLights(
        detection.direction,
        detection.irradiance,
        flux=detection.flux,
        peak_direction=detection.peak_direction,
        solid_angle=detection.solid_angle,
        elongation=detection.elongation,
        orientation=detection.orientation,
        peak_luminance=detection.peak_luminance,
        flux_fraction=detection.flux_fraction,
        is_clipped=detection.is_clipped,
        members=Members(detection.pixel, detection.light_of_pixel),
        report=report,
        weight=clipped and clipped.weight,
        direction_uncertainty=clipped and clipped.direction_uncertainty,
        is_cut=detection.is_cut,
        units=world.units,
    )
