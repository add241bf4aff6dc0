"""Images of a rough metal ball as sums over the pixels of a map."""

import numpy as np

from envlights import kernels


def turns(count):
    """Directions towards the viewer and normals, evenly over all orientations of a ball's image.

    The image has as many pixels at each sin² of the incidence.
    """
    points = kernels.halton(count, (2, 3, 5, 7)) + 0.5 / count
    view = kernels.uniform_sphere(points[:, :2] % 1)
    sine, azimuth = np.sqrt(points[:, 2] % 1), 2 * np.pi * points[:, 3]
    side = np.cross(view, np.where(np.abs(view[:, :1]) < 0.6, [[1.0, 0, 0]], [[0, 1.0, 0]]))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    around = np.cos(azimuth)[:, None] * side + np.sin(azimuth)[:, None] * np.cross(view, side)
    return view, np.sqrt(1 - sine**2)[:, None] * view + sine[:, None] * around


def ggx(normal, view, light, alpha):
    """Lobe of metal times the cosine, (n, pixels); separable masking (Walter et al. 2007)."""
    square = alpha**2

    def masking(c):
        return 2 * c / (c + np.sqrt(square + (1 - square) * c * c))

    cosine, towards = np.maximum(normal @ light.T, 0), (normal * view).sum(axis=1)[:, None]
    # |l + v|² = 2 (1 + l.v), and n.(l + v) is the sum of both cosines.
    half = np.minimum((cosine + towards) ** 2 / (2 * (1 + view @ light.T) + 1e-6), 1)
    facets = square / (np.pi * (half * (square - 1) + 1) ** 2)
    return np.where(cosine > 0, facets * masking(cosine) * masking(towards) / (4 * towards), 0)


def pixels_of_ball(radiances, roughness, count, block=200):
    """Images under several maps of one size, (maps, count, 3), at pixels and sides of `turns`."""
    height, width, _ = np.shape(radiances[0])
    light = kernels.pixel_directions(height, width).reshape(-1, 3).astype(np.float32)
    solid_angles = kernels.pixel_solid_angles(height, width)[..., None]
    power = np.concatenate([(each * solid_angles).reshape(-1, 3) for each in radiances], axis=1)
    view, normal = (each.astype(np.float32) for each in turns(count))
    rows = [
        ggx(normal[i : i + block], view[i : i + block], light, roughness**2).astype(np.float64)
        @ power
        for i in range(0, count, block)
    ]
    return np.concatenate(rows).reshape(count, len(radiances), 3).transpose(1, 0, 2)


def gloss_error(env, rig, roughness, count, finer=1):
    """Relative RMS error of the images under a rig."""
    radiance = env.radiance.repeat(finer, axis=0).repeat(finer, axis=1)
    truth, seen = pixels_of_ball([radiance, rig.to_map(len(radiance)).radiance], roughness, count)
    return np.linalg.norm(seen - truth) / np.linalg.norm(truth)
