"""Both errors of any lights for a map, by sums over points: none of the package's closed forms."""

from typing import NamedTuple

import numpy as np
from tests.reference.shadows import points_of_disc

from envlights import kernels

#: Normals and planes of the error of shadows, and rows of the map that it sums over.
_NORMALS, _PLANES, _ROWS = 320, 320, 128


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
    """Places, fluxes and solid angles of blocks of pixels: each at the centroid of its light."""
    directions = kernels.pixel_directions(env.height, env.width)
    solid_angles = kernels.pixel_solid_angles(env.height, env.width)[..., None]
    flux = env.radiance * solid_angles
    step = max(1, env.height // _ROWS)
    place = _blocks(directions * flux.sum(axis=2, keepdims=True), step)
    centre = _blocks(directions * solid_angles, step)
    place = np.where(np.linalg.norm(place, axis=1, keepdims=True) > 0, place, centre)
    place /= np.linalg.norm(place, axis=1, keepdims=True)
    return place, _blocks(flux, step), _blocks(solid_angles, step)


def _blocks(values, step):
    """Sums over blocks, (blocks, channels)."""
    rows, columns = np.arange(0, values.shape[0], step), np.arange(0, values.shape[1], step)
    sums = np.add.reduceat(np.add.reduceat(values.astype(float), rows, axis=0), columns, axis=1)
    return sums.reshape(-1, values.shape[2])
