"""Images of spheres by sums over all pixels of a map, with the formulas term by term."""

import numpy as np
from scipy.stats import qmc


def pixels(height):
    """Directions, (n, 3), and solid angles, (n,), of the cells of a map."""
    width = 2 * height
    theta = (np.arange(height) + 0.5) / height * np.pi
    phi = (np.arange(width) + 0.5) / width * 2 * np.pi
    edges = np.cos(np.arange(height + 1) / height * np.pi)
    directions = np.stack(
        [
            np.sin(theta)[:, None] * np.sin(phi),
            np.repeat(np.cos(theta)[:, None], width, axis=1),
            -np.sin(theta)[:, None] * np.cos(phi),
        ],
        axis=-1,
    )
    angles = np.repeat((edges[:-1] - edges[1:]) * 2 * np.pi / width, width)
    return directions.reshape(-1, 3), angles


def ggx(normal, view, light, roughness, specular):
    """Reflectance of microfacets: Walter et al. 2007 with half vectors, Fresnel by Schlick."""
    alpha = roughness**2
    half = light + view
    half /= np.linalg.norm(half, axis=-1, keepdims=True)
    n_l, n_v, n_h = light @ normal, view @ normal, half @ normal
    tangent = lambda cosine: (1 - cosine**2) / cosine**2  # noqa: E731, as in the paper
    facets = alpha**2 / (np.pi * n_h**4 * (alpha**2 + tangent(n_h)) ** 2)
    masking = lambda cosine: 2 / (1 + np.sqrt(1 + alpha**2 * tangent(cosine)))  # noqa: E731
    fresnel = specular + (1 - specular) * (1 - half @ view) ** 5
    return fresnel * facets * masking(n_l) * masking(n_v) / (4 * n_l * n_v)


def image(radiance, normals, views, *, base, specular, roughness):
    """Radiance that each point of a sphere reflects to its view, (n, 3)."""
    directions, angles = pixels(len(radiance))
    light = radiance.reshape(-1, 3).astype(float) * angles[:, None]
    out = np.zeros((len(normals), 3))
    for i, (normal, view) in enumerate(zip(normals, views, strict=True)):
        before = directions @ normal > 0
        reflectance = base / np.pi
        if specular:
            reflectance = reflectance + ggx(normal, view, directions[before], roughness, specular)
        out[i] = (reflectance * (directions[before] @ normal)) @ light[before]
    return out


def sides(count, seed=0):
    """Even pixels of a ball from all sides: normals and views."""
    height, azimuth, square, turn = qmc.Halton(4, seed=seed).random(count).T[:, :, None]
    z, phi = 2 * height - 1, 2 * np.pi * azimuth
    flat = np.sqrt(1 - z**2)
    normals = np.hstack([flat * np.cos(phi), flat * np.sin(phi), z])
    east = np.hstack([-np.sin(phi), np.cos(phi), 0 * phi])
    aside = np.cos(2 * np.pi * turn) * east + np.sin(2 * np.pi * turn) * np.cross(normals, east)
    # The image of a ball is a disc: the square of the sine of the incidence is uniform.
    return normals, np.sqrt(1 - square) * normals + np.sqrt(square) * aside


def numbers(truth, guess):
    """RMSE, scale-invariant RMSE and mean angle in degrees of images, (n, 3)."""
    scale = (truth * guess).sum() / (guess * guess).sum()
    lengths = np.linalg.norm(truth, axis=1) * np.linalg.norm(guess, axis=1)
    cosine = np.clip((truth * guess).sum(axis=1) / lengths, -1, 1)
    rms = [np.sqrt(((factor * guess - truth) ** 2).mean()) for factor in (1, scale)]
    return (*rms, np.degrees(np.arccos(cosine)).mean())
