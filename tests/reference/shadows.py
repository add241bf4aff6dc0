"""The error of a rig where things stand in the way, from its definition."""

import numpy as np

from envlights import kernels


def shadow_error(
    radiance,
    ambient,
    direction,
    irradiance,
    angular_radius,
    *,
    normals=5120,
    planes=320,
    border=False,
):
    """Relative RMS error of the irradiance at normals, all that is behind a plane hidden.

    Sums over the pixels of the map, over points of each disc, over normals and over planes. The
    ambient term is one radiance, or nine harmonics.
    """
    height, width, _ = radiance.shape
    towards = kernels.pixel_directions(height, width, border_sampled=border).reshape(-1, 3)
    solid_angles = kernels.pixel_solid_angles(height, width, border_sampled=border).reshape(-1, 1)
    flux = radiance.reshape(-1, 3) * solid_angles
    ambient = np.atleast_2d(ambient)
    if len(ambient) == 9:
        surroundings = kernels.harmonic_radiance(towards) @ ambient
    else:
        surroundings = np.broadcast_to(ambient.sum(axis=0), flux.shape)
    points = [
        points_of_disc(*disc) for disc in zip(direction, irradiance, angular_radius, strict=True)
    ]
    sources = np.concatenate([towards, *(place for place, _ in points)])
    difference = np.concatenate(
        [flux - surroundings * solid_angles, *(-share for _, share in points)]
    )
    whole = np.concatenate([flux, np.zeros((len(sources) - len(flux), 3))])
    at, weights = kernels.icosphere(normals)
    fronts, plane_weights = kernels.icosphere(planes)
    is_in_front = (sources @ fronts.T > 0).astype(np.float32)
    sums = np.zeros(2)
    for start in range(0, normals, 256):
        part = slice(start, start + 256)
        lit = np.maximum(at[part] @ sources.T, 0).astype(np.float32)
        for i, light in enumerate((difference, whole)):
            for channel in range(3):
                seen = (lit * light[:, channel].astype(np.float32)) @ is_in_front
                sums[i] += weights[part] @ (seen.astype(float) ** 2) @ plane_weights
    return np.sqrt(sums[0] / sums[1])


def points_of_disc(direction, irradiance, radius, rings=32):
    """Points on rings of equal area that stand for a disc of one radiance, and the flux of each."""
    direction = np.asarray(direction)
    if radius == 0:
        return direction[None], np.asarray(irradiance)[None]
    cosines = 1 - (1 - np.cos(radius)) * (np.arange(rings) + 0.5) / rings
    count = 48
    turns = 2 * np.pi * (np.arange(count) + 0.5 * (np.arange(rings) % 2)[:, None]) / count
    axis = np.eye(3)[np.argmin(np.abs(direction))]
    across = np.cross(direction, axis)
    across /= np.linalg.norm(across)
    sines = np.sqrt(1 - cosines**2)[:, None, None]
    round_it = np.cos(turns)[..., None] * across + np.sin(turns)[..., None] * np.cross(
        direction, across
    )
    points = (cosines[:, None, None] * direction + sines * round_it).reshape(-1, 3)
    # The flux of a disc is its irradiance at normal incidence over the mean cosine.
    return points, np.tile(irradiance / ((1 + np.cos(radius)) / 2) / len(points), (len(points), 1))
