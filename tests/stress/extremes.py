"""Maps and lights at the limits of numbers and directions."""

from functools import cache, partial

import numpy as np

import envlights as el
from envlights import kernels
from tests.fitting import worst_cases
from tests.helpers import NORMALS, SOLID_ANGLES
from tests.reference import cells
from tests.stress.case import U32, U64, Case, cases_of, light_of, lights_apart

_FEW = NORMALS[::4]


@cache
def _room(height=16, stops=4, seed=5):
    rng = np.random.default_rng(seed)
    return np.exp2(rng.uniform(0, stops, (height, 2 * height, 3))).astype(np.float32)


def _probe(radiance):
    return el.EnvMap(radiance).probe(_FEW)


def _relative(found, wanted):
    return float(np.abs(found / wanted - 1).max())


def _scaled_probe(scale):
    radiance = _room(64)
    scaled = radiance.astype(float) * scale
    return _relative(_probe(scaled.astype(np.float32)) / scale, _probe(radiance))


def _scaled_fit(scale):
    """Change of directions, in radians, and of irradiance."""
    radiance = el.synthetic.hall(64).radiance.astype(float)
    one, other = (_fitted_points((radiance * s).astype(np.float32)) for s in (1, scale))
    return lights_apart(other, one.direction, scale * one.irradiance, in_order=True)


def _fitted_points(radiance):
    return el.fit(radiance, 2, sizes=False).lights


def _scaled_detection(scale):
    radiance = el.synthetic.hall(64).radiance.astype(float)
    one, other = (el.detect((radiance * s).astype(np.float32)) for s in (1, scale))
    return lights_apart(other, one.direction, scale * light_of(one), in_order=True)


def _range_probe(stops):
    """Against an integral over the cells, one by one."""
    radiance = _room(8, stops)
    return _relative(_probe(radiance), cells.irradiance(radiance, _FEW))


def _range_of_a_sun(stops):
    """The room behind a sun, on the side that the sun does not light."""
    room, at = _room(64).copy(), (20, 40)
    sunny = room.copy()
    room[at] = 0
    sunny[at] = 2.0**stops
    behind = NORMALS[NORMALS @ kernels.pixel_directions(64, 128)[at] < -0.1]
    seen, wanted = (el.EnvMap(each).probe(behind) for each in (sunny, room))
    return _relative(seen, wanted)


#: Row and column of a sun of one pixel, on a map of 64x128.
PLACES = {
    "the upper pole": (0, 77),
    "the lower pole": (63, 77),
    "the seam, left": (31, 0),
    "the seam, right": (32, 127),
    "the corner of seam and pole": (0, 0),
    "the other corner": (63, 127),
    "the middle": (32, 64),
}


def _sun(row, column, times=1):
    """A sun in a map that is `times` as large, in the pixel of the same place and border."""
    size = height, width = 64 * times, 128 * times
    row, column = row * (height - 1) // 63, column * (width - 1) // 127
    radiance = np.zeros((*size, 3), np.float32)
    radiance[row, column] = 1e6, 2e6, 3e6
    flux = radiance[row, column] * kernels.pixel_solid_angles(*size)[row, 0]
    return radiance, kernels.pixel_directions(*size)[row, column], flux


def _sun_of_the_probe(row, column):
    """Error of the probe at normals whose horizon does not cut the pixel."""
    radiance, towards, _ = _sun(row, column)
    normals = NORMALS[NORMALS @ towards > 0.1]
    vector = cells.vector_solid_angle(row, column, 64, 128)
    wanted = (normals @ vector)[:, None] * radiance[row, column]
    return _relative(el.EnvMap(radiance).probe(normals), wanted)


def _sun_that_is_detected(row, column):
    radiance, towards, flux = _sun(row, column)
    return lights_apart(el.detect(radiance), towards[None], flux[None])


def _sun_that_is_fitted(row, column):
    """The light of a pixel comes from its middle azimuth, and from the mean of its row."""
    radiance, _, flux = _sun(row, column, times=4)
    (row,), (column,) = np.nonzero(radiance[..., 0])
    towards = cells.mean_of_row(row, column, *radiance.shape[:2])
    found = el.fit(radiance, 1, ambient="none", sizes=False).lights
    return lights_apart(found, towards[None], flux[None])


def _probe_error(case, lights):
    """The error of a probe that those lights explain, and infinite where the answer is unusable."""
    irradiance = worst_cases.cases()[case]
    rig = el.fit_probe(NORMALS, irradiance, lights, weights=SOLID_ANGLES)
    usable = np.isfinite(rig.lights.direction).all() and (rig.lights.irradiance >= 0).all()
    return rig.error if usable else np.inf


def _detected_apart(degrees):
    """Flux of two suns on adjacent pixels or opposite each other, for any number of lights."""
    radiance = np.zeros((512, 1024, 3), np.float32)
    radiance[200, 300] = 1e5
    beside = (200, 301) if degrees < 1 else (311, 812)
    radiance[beside] = 1e5
    wanted = (radiance * kernels.pixel_solid_angles(512, 1024)[..., None]).sum(axis=(0, 1))
    lights = el.detect(radiance)
    right = 1 if degrees < 1 else 2
    found = lights.flux.sum(axis=0)
    return _relative(found, wanted) if len(lights) == right else np.inf


_ROUNDED = 8 * U32
SCALES = {f"{s:g}": (s,) for s in (1e-38, 1e-20, 1e20, 1e35)}
_AGAIN = "bound 5: samples in float32, rounded anew"

CASES = [
    *cases_of("scale", "probe of a map times ", _ROUNDED, _AGAIN, _scaled_probe, SCALES),
    *cases_of(
        "scale",
        "fit to a map times ",
        1e-5,
        "samples rounded anew, and the step's end",
        _scaled_fit,
        SCALES,
    ),
    *cases_of("scale", "detection on a map times ", _ROUNDED, _AGAIN, _scaled_detection, SCALES),
    Case(
        "scale",
        "probe of denormals, a map times 1e-42",
        120 * 2.0**-150 / (1e-42 * np.pi / 2),
        "bound 4: the last digit of a denormal is 2^-149",
        partial(_scaled_probe, 1e-42),
    ),
    Case(
        "range",
        "probe, 30 stops in every pixel",
        1e-4,
        "strips of a map of few rows",
        partial(_range_probe, 30),
    ),
    Case(
        "range",
        "room behind a sun 30 stops above it",
        8 * 2.0**30 * U64,
        "bound 6: prefix sums in float64",
        partial(_range_of_a_sun, 30),
    ),
    Case(
        "range",
        "fit, 22 stops between lights",
        1e-8,
        "the error is a root of a rounded square",
        partial(_probe_error, "22 stops between the lights", 4),
    ),
    *cases_of(
        "place",
        "probe, a sun of one pixel at ",
        1e-6,
        "four nodes across a strip integrate its latitudes",
        _sun_of_the_probe,
        PLACES,
    ),
    *cases_of(
        "place",
        "detection, a sun of one pixel at ",
        1e-9,
        "one pixel is one direction",
        _sun_that_is_detected,
        PLACES,
    ),
    *cases_of(
        "place",
        "fit, a sun of one pixel at ",
        1e-9,
        "one pixel of 512 columns is one direction",
        _sun_that_is_fitted,
        PLACES,
    ),
    Case(
        "close",
        "fit, two lights 0.01 degrees apart",
        1e-8,
        "one light explains both to 1e-8",
        partial(_probe_error, "two lights 0.01 degrees apart", 4),
    ),
    Case(
        "close",
        "fit, opposite lights",
        1e-8,
        "rounding of the squared error",
        partial(_probe_error, "opposite lights", 4),
    ),
    Case(
        "close",
        "detection, suns on two adjacent pixels",
        _ROUNDED,
        "flux is kept",
        partial(_detected_apart, 0.35),
    ),
    Case(
        "close", "detection, opposite suns", _ROUNDED, "flux is kept", partial(_detected_apart, 180)
    ),
]
