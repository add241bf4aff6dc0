"""Other ways to a few lights for a map, each as one would write it with NumPy and its library."""

import heapq
import os
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from curves.errors_of_rigs import Surroundings
from scipy.special import sph_harm_y
from tests.helpers import NORMALS, SOLID_ANGLES
from tests.reference import peers

import envlights as el
from envlights import kernels
from envlights.kernels.image import LUMINANCE

#: Rows that k-means works on: more take longer than a minute.
_ROWS = 64
#: Of `mksource`: its own is 2; below 1 it takes what is darker than the mean, too.
THRESHOLDS = (0.5, 2.0, 8.0)


@cache
def sphere(height):
    """Directions and solid angles of pixels, computed once for all maps."""
    return kernels.pixel_directions(height, 2 * height), kernels.pixel_solid_angles(
        height, 2 * height
    )


def points(direction, flux):
    """Point lights, and no ambient term."""
    length = np.linalg.norm(direction, axis=1, keepdims=True)
    lit = (length[:, 0] > 0) & (flux > 0).any(axis=1)
    lights = el.Lights(direction[lit] / length[lit], flux[lit])
    return SimpleNamespace(lights=lights, ambient=np.zeros(3))


def median_cut(radiance, count):
    """Debevec (2005), "A median cut algorithm for light probe sampling": halves of equal flux."""
    return _by_cuts(radiance, count, _half_of_the_flux, _flux_of)


def variance_cuts(radiance, count):
    """Viriyothai and Debevec (2009), "Variance minimization light probe sampling".

    Always the region of the greatest spread is cut, where both parts together have the least.
    """
    return _by_cuts(radiance, count, _least_spread, _spread_of)


def _by_cuts(radiance, count, cut, urgency):
    """Cut the map into `count` regions, always the most urgent one; a light for each."""
    directions, solid_angles = sphere(len(radiance))
    weights = (radiance @ LUMINANCE).astype(float) * solid_angles
    moments = np.concatenate([weights[..., None], weights[..., None] * directions], axis=2)
    whole = (0, len(radiance), 0, 2 * len(radiance))
    regions = [(-urgency(moments, whole), whole)]
    while len(regions) < count:
        _, region = heapq.heappop(regions)
        for part in cut(moments, region):
            size = (part[1] - part[0]) * (part[3] - part[2])
            heapq.heappush(regions, (-urgency(moments, part) if size > 1 else 0.0, part))
        if regions[0][0] == 0:
            break
    parts = [(slice(*region[:2]), slice(*region[2:])) for _, region in regions]
    flux = [(radiance[part] * solid_angles[part][..., None]).sum(axis=(0, 1)) for part in parts]
    return points(np.array([moments[p].sum(axis=(0, 1))[1:] for p in parts]), np.array(flux))


def _flux_of(moments, region):
    top, bottom, left, right = region
    return moments[top:bottom, left:right, 0].sum()


def _spread_of(moments, region):
    top, bottom, left, right = region
    return _spread(moments[top:bottom, left:right].sum(axis=(0, 1)))


def _spread(sums):
    """Sum of weight times squared distance from the mean, from the weight and the vector sum."""
    weight, vector = sums[..., 0], sums[..., 1:]
    return weight - (vector**2).sum(axis=-1) / np.maximum(weight, 1e-300)


def _half_of_the_flux(moments, region):
    top, bottom, left, right = region
    # Meridians draw together towards the poles.
    breadth = (right - left) * np.sin(np.pi * (top + bottom) / 2 / len(moments))
    is_across = bottom - top > 1 and (bottom - top >= breadth or right - left == 1)
    along = moments[top:bottom, left:right, 0].sum(axis=1 if is_across else 0).cumsum()
    return _parts(region, is_across, 1 + int(np.searchsorted(along[:-2], along[-1] / 2)))


def _least_spread(moments, region):
    top, bottom, left, right = region
    found = []
    for is_across in (True, False):
        sums = moments[top:bottom, left:right].sum(axis=1 if is_across else 0)
        if len(sums) > 1:
            before = sums.cumsum(axis=0)
            both = _spread(before[:-1]) + _spread(before[-1] - before[:-1])
            found.append((both.min(), is_across, 1 + int(both.argmin())))
    return _parts(region, *min(found)[1:])


def _parts(region, is_across, at):
    top, bottom, left, right = region
    if is_across:
        return [(top, top + at, left, right), (top + at, bottom, left, right)]
    return [(top, bottom, left, left + at), (top, bottom, left + at, right)]


def k_means(radiance, count):
    """scikit-learn's k-means on pixels of a reduced map, weighted by flux."""
    from sklearn.cluster import KMeans

    step = max(1, len(radiance) // _ROWS)
    small = radiance.reshape(len(radiance) // step, step, -1, step, 3).mean(axis=(1, 3))
    directions, solid_angles = sphere(len(small))
    flux = small * solid_angles[..., None]
    means = KMeans(count, n_init=1, max_iter=50, random_state=0)
    labels = means.fit_predict(directions.reshape(-1, 3), sample_weight=(flux @ LUMINANCE).ravel())
    luminous = directions * (flux @ LUMINANCE)[..., None]
    sums = [
        np.stack([np.bincount(labels, each, count) for each in array.reshape(-1, 3).T], axis=1)
        for array in (luminous, flux)
    ]
    return points(*sums)


def importance_samples(radiance, count):
    """Pixels sampled by their flux at evenly spaced numbers, all of equal flux."""
    directions, solid_angles = sphere(len(radiance))
    weights = ((radiance @ LUMINANCE) * solid_angles).astype(float)
    rows, columns = weights.sum(axis=1).cumsum(), weights.cumsum(axis=1)
    drawn = kernels.hammersley(count) + np.array([0.5 / count, 0])
    row = np.searchsorted(rows, drawn[:, 0] * rows[-1])
    column = [
        int(np.searchsorted(columns[i], share * columns[i, -1]))
        for i, share in zip(row, drawn[:, 1], strict=True)
    ]
    at = row, np.minimum(column, 2 * len(radiance) - 1)
    flux = radiance[at] * (solid_angles[at] * rows[-1] / (count * weights[at]))[:, None]
    return points(directions[at], flux)


def projected_harmonics(radiance, order):
    """Real spherical harmonics up to `order`, not constrained; Ramamoorthi and Hanrahan (2001)."""
    _, solid_angles = sphere(len(radiance))
    flux = (radiance * solid_angles[..., None]).reshape(-1, 3)
    coefficients = _pixel_harmonics(len(radiance), order).T @ flux
    return SimpleNamespace(
        lights=el.Lights(np.zeros((0, 3)), np.zeros((0, 3))),
        ambient=Surroundings(
            lambda at: _harmonics(at, order) @ coefficients,
            lambda at: (_harmonics(at, order) * _clamped_cosine(order)) @ coefficients,
        ),
    )


@cache
def _pixel_harmonics(height, order):
    return _harmonics(sphere(height)[0].reshape(-1, 3), order)


def _harmonics(directions, order):
    """SciPy's complex harmonics as real ones, (n, (order + 1)^2)."""
    theta = np.arccos(np.clip(directions[:, 2], -1, 1))
    phi = np.arctan2(directions[:, 1], directions[:, 0])
    columns = []
    for degree in range(order + 1):
        for m in range(-degree, degree + 1):
            value = sph_harm_y(degree, abs(m), theta, phi)
            part = value.imag if m < 0 else value.real
            columns.append(part * (np.sqrt(2) if m else 1))
    return np.stack(columns, axis=1)


def _clamped_cosine(order):
    """Factor of the clamped cosine for each degree: pi, 2 pi / 3, pi / 4, 0, -pi / 24."""
    factors = (np.pi, 2 * np.pi / 3, np.pi / 4, 0.0, -np.pi / 24)
    return np.repeat(factors[: order + 1], 2 * np.arange(order + 1) + 1)


def by_scipy(radiance, lights):
    """SciPy's bounded least squares on the paper's equations, from an even start."""
    return solve(
        el.EnvMap(radiance).probe(NORMALS),
        lights,
        lambda problem, start: peers.by_scipy(problem, start, has_bounds=True, tolerance=1e-8),
    )


def by_jaxopt(radiance, lights):
    """The Levenberg-Marquardt of JAXopt from the same start, compiled before it is timed."""
    probe = el.EnvMap(radiance).probe(NORMALS)
    return solve(probe, lights, lambda problem, start: peers.by_jaxopt(problem, start, 1e-8))


def solve(probe, lights, solver):
    """Points and an ambient term of a solver for a probe, from an even start."""
    scale = probe.max()
    problem = peers.Problem(NORMALS, SOLID_ANGLES, probe / scale, lights)
    even = peers.even(lights)
    start = kernels.pack_lights(np.full(3, 0.1), even, np.full((lights, 3), 0.5))
    ambient, direction, irradiance = kernels.unpack_lights(problem.whole(solver(problem, start)))
    # Without bounds a radiance may end below zero, which no renderer takes.
    found = points(direction, scale * np.maximum(irradiance, 0))
    return SimpleNamespace(lights=found.lights, ambient=scale * np.maximum(ambient, 0))


def by_mksource(radiance, threshold):
    """Radiance's `mksource`, with its sources as discs, and all other flux as an even ambient term.

    Larson, "mksource": sources for the bright parts of an environment, at most 10 degrees wide.
    """
    import pyradiance

    home = Path(pyradiance.__file__).parent
    with tempfile.TemporaryDirectory() as folder:
        path, octree = Path(folder, "map.rad"), Path(folder, "map.oct")
        nothing = el.Lights(np.zeros((0, 3)), np.zeros((0, 3)))
        nothing.save(path, environment=el.EnvMap(radiance))
        search = {"cwd": folder, "env": os.environ | {"RAYPATH": f".:{home / 'lib'}"}}
        with octree.open("wb") as file:
            subprocess.run([home / "bin/oconv", path], stdout=file, check=True, **search)
        command = [home / "bin/mksource", "-d", "20000", "-t", str(threshold), octree]
        text = subprocess.check_output(command, text=True, **search)
    return _with_the_rest(radiance, *_sources(text))


def _sources(text):
    """Directions, radiances and angular radii of the sources in a scene of Radiance."""
    rows = [line.split() for line in text.splitlines()]
    colours = [row[1:] for row in rows if row[:1] == ["3"]]
    places = np.array([row[1:] for row in rows if row[:1] == ["4"]], float).reshape(-1, 4)
    towards = el.export.AXES["radiance"].from_target(places[:, :3])
    return towards, np.array(colours, float).reshape(-1, 3), np.deg2rad(places[:, 3]) / 2


def _with_the_rest(radiance, towards, colours, radii):
    """Discs, and an ambient term with the remaining flux."""
    flux = colours * (np.pi * np.sin(radii) ** 2)[:, None]
    _, solid_angles = sphere(len(radiance))
    left = (radiance * solid_angles[..., None]).sum(axis=(0, 1)) - flux.sum(axis=0)
    ambient = np.maximum(left, 0) / (4 * np.pi)
    return SimpleNamespace(lights=el.Lights(towards, flux, radii), ambient=ambient)
