"""Both errors of any lights for a map, by sums over points: none of the package's closed forms."""

from typing import NamedTuple

import numpy as np
from tests.reference.shadows import points_of_disc

from envlights import kernels

#: Normals and planes of the error of shadows, and rows of the grid that it sums over. Irradiance is
#: smooth in the normal, but not in the plane: with 320 of them the error was 8 % too large.
_NORMALS, _PLANES, _ROWS = 80, 1280, 128
#: Cells with a larger share of the flux are cut into this many parts along each side.
_BRIGHT, _PARTS = 3e-4, 8


class Surroundings(NamedTuple):
    """Light from everywhere that is no rig's: what it is at directions, and its irradiance."""

    radiance: object
    irradiance: object


class Judge:
    """The probe and the shadows of one map."""

    def __init__(self, env):
        self.normals, self.weights = kernels.icosphere(5120)
        self.wanted = env.probe(self.normals)
        self.places, self.flux, self.solid_angles = _cells(env)
        self.at, self.at_weights = kernels.icosphere(_NORMALS)
        self.fronts, self.front_weights = kernels.icosphere(_PLANES)
        self.shaded = self._behind_planes(self.places, self.flux)

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
        """Relative RMS error of the irradiance at normals, all that is behind a plane hidden."""
        lights = rig.lights
        rows = zip(lights.direction, lights.irradiance, lights.angular_radius, strict=True)
        discs = [points_of_disc(*row, rings=8) for row in rows]
        around = self._radiance_of(rig.ambient) * self.solid_angles
        places = np.concatenate([self.places, *(place for place, _ in discs)])
        seen = self._behind_planes(places, np.concatenate([around, *(flux for _, flux in discs)]))
        weights = self.at_weights[:, None, None] * self.front_weights[:, None]
        difference, whole = (
            (weights * values**2).sum() for values in (seen - self.shaded, self.shaded)
        )
        return float(np.sqrt(difference / whole))

    def _radiance_of(self, ambient):
        if isinstance(ambient, Surroundings):
            return ambient.radiance(self.places)
        if ambient.ndim == 2:
            return kernels.harmonic_radiance(self.places) @ ambient
        return np.broadcast_to(ambient, self.places.shape)

    def _behind_planes(self, places, flux):
        """Irradiance at each normal from what is in front of each plane, (normals, planes, 3)."""
        cosines = np.maximum(self.at @ places.T, 0).astype(np.float32)
        in_front = (places @ self.fronts.T > 0).astype(np.float32)
        channels = flux.astype(np.float32).T
        return np.stack([(cosines * channel) @ in_front for channel in channels], axis=2)


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
