"""Errors of shading and of shadows of any lights for a map, by sums over points."""

from typing import NamedTuple

import numpy as np
from tests.reference.shadows import points_of_disc

from envlights import kernels

#: Normals and planes of the error of shadows, and rows of the grid that it sums over. Irradiance is
#: smooth in the normal, but not in the plane: with 320 of them the error was 8 % too large.
_NORMALS, _PLANES, _ROWS = 80, 1280, 128
#: Cells with a larger share of the flux are cut into this many parts along each side.
_BRIGHT, _PARTS = 3e-4, 8
#: Directions that are summed together; all at once would take half a gigabyte.
_AT_ONCE = 1024


class Surroundings(NamedTuple):
    """Ambient light of a peer: functions for its radiance and its irradiance."""

    radiance: object
    irradiance: object


class Evaluation:
    """Evaluation of rigs under one map."""

    def __init__(self, env):
        self.normals, self.weights = kernels.icosphere(5120)
        self.wanted = env.probe(self.normals)
        self.places, self.flux, self.solid_angles = _cells(env)
        self.at, self.at_weights = kernels.icosphere(_NORMALS)
        self.fronts, self.front_weights = kernels.icosphere(_PLANES)
        self.shaded = self._behind_planes(self.places, self.flux)
        #: Behind a sky of radiance 1.
        self.even = self._behind_planes(self.places, self.solid_angles)

    def probe_error(self, rig):
        """Relative RMS error of the irradiance at 5120 normals."""
        lights = rig.lights
        if isinstance(rig.ambient, Surroundings):
            seen = rig.ambient.irradiance(self.normals)
        else:
            given = lights.direction, lights.irradiance, lights.angular_radius
            seen = kernels.rig_irradiance(self.normals, rig.ambient, *given)
        return kernels.relative_rms(seen, self.wanted, self.weights)

    def shadow_error(self, rig):
        """Relative RMS error of the irradiance with everything behind a plane hidden."""
        lights = rig.lights
        rows = zip(lights.direction, lights.irradiance, lights.angular_radius, strict=True)
        discs = [points_of_disc(*row, rings=8) for row in rows]
        seen = self._behind_planes(
            np.concatenate([np.zeros((0, 3)), *(place for place, _ in discs)]),
            np.concatenate([np.zeros((0, 3)), *(flux for _, flux in discs)]),
        )
        seen = seen + self._sky_behind_planes(rig.ambient)
        weights = self.at_weights[:, None, None] * self.front_weights[:, None]
        difference, whole = (
            (weights * values**2).sum() for values in (seen - self.shaded, self.shaded)
        )
        return float(np.sqrt(difference / whole))

    def _sky_behind_planes(self, ambient):
        if isinstance(ambient, Surroundings):
            radiance = ambient.radiance(self.places)
        elif ambient.ndim == 2:
            radiance = kernels.harmonic_radiance(self.places) @ ambient
        else:
            return self.even * ambient
        return self._behind_planes(self.places, radiance * self.solid_angles)

    def _behind_planes(self, places, flux):
        """Irradiance at each normal from what is in front of each plane, (normals, planes, 3)."""
        seen = np.zeros((len(self.at), len(self.fronts), flux.shape[1]))
        for start in range(0, len(places), _AT_ONCE):
            some = places[start : start + _AT_ONCE]
            cosines = np.maximum(self.at @ some.T, 0).astype(np.float32)
            in_front = (some @ self.fronts.T > 0).astype(np.float32)
            for i, channel in enumerate(flux[start : start + _AT_ONCE].astype(np.float32).T):
                seen[..., i] += (cosines * channel) @ in_front
        return seen


def _cells(env):
    """Places, fluxes and solid angles of the parts of a map, pixels being squares of one radiance.

    Blocks of pixels with much of the flux are cut finely: at a plane's edge each part is seen whole
    or not at all.
    """
    rows = min(env.height, _ROWS)
    coarse = _grid(env, np.arange(rows), np.arange(2 * rows), rows)
    share = coarse[1].sum(axis=1) / coarse[1].sum()
    bright = np.flatnonzero(share > _BRIGHT)
    row, column = np.unravel_index(bright, (rows, 2 * rows))
    inside = np.arange(_PARTS)
    fine = [
        _grid(env, _PARTS * r + inside, _PARTS * c + inside, _PARTS * rows)
        for r, c in zip(row, column, strict=True)
    ]
    rest = [np.delete(each, bright, axis=0) for each in coarse]
    return [np.concatenate(parts) for parts in zip(rest, *fine, strict=True)]


def _grid(env, rows, columns, height):
    """Places, fluxes and solid angles of cells of a grid with `height` rows."""
    edges = np.pi * np.stack([rows, rows + 1]) / height
    theta, phi = edges.mean(axis=0), 2 * np.pi * (columns + 0.5) / (2 * height)
    u, v = np.meshgrid(phi / (2 * np.pi), theta / np.pi)
    places = kernels.uv_to_direction(np.stack([u.ravel(), v.ravel()], axis=1))
    areas = -np.diff(np.cos(edges), axis=0)[0] * np.pi / height
    areas = np.repeat(areas, len(columns))[:, None]
    radiance = _means(env.radiance, rows, columns, height)
    return places, radiance * areas, areas


def _means(radiance, rows, columns, height):
    """Mean radiance of cells; the pixel's own in cells that are finer than pixels."""
    step = len(radiance) / height
    if step <= 1:
        return radiance[np.ix_((rows * step).astype(int), (columns * step).astype(int))].reshape(
            -1, 3
        )
    size = round(step)
    top, left = size * rows[0], size * columns[0]
    part = radiance[top : top + size * len(rows), left : left + size * len(columns)]
    return part.reshape(len(rows), size, len(columns), size, 3).mean(axis=(1, 3)).reshape(-1, 3)
