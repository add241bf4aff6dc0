"""Irradiance of a map at 320 normals: run time against error.

The settings are columns of a reduced map, the order of harmonics, and for Monte Carlo and Mitsuba
the samples at each normal. Mitsuba uses an irradiance meter on each normal, its scalar variant, and
a scene that is loaded before. The reference is a sum over all pixels, each in 4x4 parts, at every
fourth normal.
"""

import os
from functools import partial
from importlib.util import find_spec

import numpy as np
from curves.peers_of_lights import projected_harmonics, sphere
from curves.results import point, run_times, warm_up
from tests.helpers import NORMALS, SOLID_ANGLES

from envlights import kernels
from envlights.kernels.image import LUMINANCE

TITLE = "The probe of a map"
READ = ": left is faster, down is more accurate"
ERRORS = {"probe": "error at 320 normals"}
COUNTED = None
OURS = ("exact", "working map")
COLUMNS = (32, 64, 128, 256, 512, 1024)
SAMPLES = (16, 256, 4096)
#: Normals at which errors are measured: the reference takes seconds for each map.
_COMPARED = slice(None, None, 4)


def exact(radiance, _):
    return kernels.irradiance(radiance, NORMALS)


def working(radiance, columns):
    return kernels.working_irradiance(radiance, NORMALS, columns=columns)[0]


def brute_force(radiance, columns):
    """All pixels of a reduced map at all normals, as products of matrices, row by row.

    One product would take 335 MB at 512 columns: fresh pages, which cost from once to four times
    the arithmetic, and never the same.
    """
    step = max(1, radiance.shape[1] // columns)
    small = radiance.reshape(len(radiance) // step, step, -1, step, 3).mean(axis=(1, 3))
    directions, solid_angles = sphere(len(small))
    flux = small * solid_angles[..., None]
    rows = zip(directions, flux, strict=True)
    return sum(np.maximum(NORMALS @ towards.T, 0) @ row for towards, row in rows)


def harmonics(radiance, order):
    return projected_harmonics(radiance, order).ambient.irradiance(NORMALS)


def monte_carlo(radiance, samples):
    """Monte Carlo: pixels drawn by their flux, the same for all normals."""
    directions, solid_angles = sphere(len(radiance))
    weights = ((radiance @ LUMINANCE) * solid_angles).ravel().astype(float)
    share = weights.cumsum()
    at = np.searchsorted(share, np.random.default_rng(0).random(samples) * share[-1])
    flux = (radiance * solid_angles[..., None]).reshape(-1, 3)[at]
    flux = flux * (share[-1] / (samples * weights[at]))[:, None]
    return np.maximum(NORMALS @ directions.reshape(-1, 3)[at].T, 0) @ flux


METHODS = {
    "exact": ((None,), exact),
    "working map": (COLUMNS, working),
    "all pixels": (COLUMNS[:5], brute_force),
    "harmonics": ((2, 4), harmonics),
    "Monte Carlo": (SAMPLES, monte_carlo),
}


def are_comparable(our, their):
    """True for every pair of settings, because a setting guarantees nothing."""
    return our.case == their.case


def points(maps, effort):
    """Yield a point for each map, method and setting; halve the pixels to check `exact`."""
    has_mitsuba = find_spec("mitsuba") is not None
    for name, env in maps.items():
        work = {
            (method, setting): partial(find, env.radiance, setting)
            for method, (settings, find) in METHODS.items()
            for setting in settings
        }
        if has_mitsuba:
            from curves.mitsuba_probe import Probe

            # Its scene is made beforehand: only rendering counts.
            render = Probe(env.radiance, NORMALS, int(os.environ["RAYON_NUM_THREADS"])).render
            work |= {("Mitsuba", count): partial(render, count) for count in SAMPLES}
        if effort.is_judged:
            errors = errors_of(env, work, parts=2 if effort.is_quick else 4)
        else:
            errors = warm_up(work, env.radiance.shape)
        seconds = run_times(work, effort)
        for key in work:
            yield point("probe", name, *key, errors[key], call=[seconds[key]])


def errors_of(env, work, parts):
    """The error of each method."""
    wanted, weights = reference(env.radiance, parts), SOLID_ANGLES[_COMPARED]
    return {
        key: {"probe": kernels.relative_rms(find()[_COMPARED], wanted, weights)}
        for key, find in work.items()
    }


def reference(radiance, parts):
    """Each pixel in parts x parts pieces, which sums over the pixels of their own tend to."""
    height = parts * len(radiance)
    normals = NORMALS[_COMPARED]
    total = np.zeros((len(normals), 3))
    rows = 8 * parts
    width = 2 * height
    for top in range(0, height, rows):
        directions, solid_angles = _rows(height, width, slice(top, top + rows))
        part = radiance[top // parts : (top + rows) // parts]
        flux = part.repeat(parts, axis=0).repeat(parts, axis=1) * solid_angles
        total += np.maximum(normals @ directions.reshape(-1, 3).T, 0) @ flux.reshape(-1, 3)
    return total


def _rows(height, width, rows):
    """Directions and solid angles of some rows of a map."""
    edges = np.pi * np.arange(rows.start, rows.stop + 1) / height
    theta, phi = (edges[:-1] + edges[1:]) / 2, 2 * np.pi * (np.arange(width) + 0.5) / width
    uv = np.stack(np.meshgrid(phi / (2 * np.pi), theta / np.pi), axis=-1)
    directions = kernels.uv_to_direction(uv.reshape(-1, 2)).reshape(*uv.shape[:2], 3)
    solid_angles = -np.diff(np.cos(edges)) * 2 * np.pi / width
    return directions, solid_angles[:, None, None]
