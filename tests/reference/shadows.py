"""The error of a rig with shadows, from its definition and from its kernel."""

from itertools import pairwise

import numpy as np
from numpy.polynomial.legendre import leggauss

from envlights import kernels


def shadow_error(
    radiance,
    ambient,
    direction,
    irradiance,
    angular_radius,
    *,
    normals=1280,
    planes=320,
    border=False,
):
    """Relative RMS error of the irradiance at normals, with everything behind a plane hidden.

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


def shadow_error_by_kernel(radiance, ambient, direction, irradiance, angular_radius):
    """Shadow error as a double sum of the kernel, for suns that 320 planes do not resolve.

    Each pixel counts as the square that it is: the brightest as small squares, all others in twos.
    Discs are integrated over circles, so that none of it is a series. The ambient term is one
    radiance.
    """
    height, width, _ = radiance.shape
    solid_angles = kernels.pixel_solid_angles(height, width)[..., None]
    flux = radiance * solid_angles
    whole = flux.sum(axis=(0, 1))
    is_bright = flux.sum(axis=-1) > 2e-3 * whole.sum()
    bright = small_squares(flux, np.sqrt(solid_angles[..., 0]), np.argwhere(is_bright))
    rest = in_twos(np.where(is_bright[..., None], 0, flux))
    rest_at = kernels.pixel_directions(*rest.shape[:2]).reshape(-1, 3)
    energy = energy_of_rows(rest, np.sqrt(in_twos(solid_angles)))
    rest = rest.reshape(-1, 3)
    places, lights, sides = bright
    energy = energy - (MEAN_DISTANCE / 3 * sides[:, None] * lights**2).sum(axis=0)
    for one, light in zip(places, lights, strict=True):
        energy += light * (kernel(places @ one) @ lights + 2 * kernel(rest_at @ one) @ rest)
    sky = np.pi * gauss(lambda g: kernel(np.cos(g)) * 2 * np.pi * np.sin(g), 0, np.pi)
    difference = energy + sky * (4 * np.pi * ambient**2 - 2 * ambient * whole)
    discs = list(zip(direction, irradiance, angular_radius, strict=True))
    for towards, strength, radius in discs:
        fluxes = strength / (0.5 * (1 + np.cos(radius)))
        blurred = over_disc(radius)
        explained = blurred(rest_at @ towards) @ rest + blurred(places @ towards) @ lights
        difference += 2 * fluxes * (sky * ambient - explained)
        for disc in discs:
            at, share = points_of_disc(*disc)
            difference += fluxes * (blurred(at @ towards) @ share)
    return np.sqrt(difference.sum() / energy.sum())


#: Mean distance of two points of a square, over its side.
MEAN_DISTANCE = 0.521405


def kernel(cosine):
    """The kernel of shadows; near 0 it falls by a third of the angle."""
    cosine = np.clip(cosine, -1, 1)
    angle = np.arccos(cosine)
    probe = 2 / 3 * (np.sqrt(1 - cosine**2) + (np.pi - angle) * cosine)
    return probe * (1 - angle / np.pi) / 2


NODES, WEIGHTS = leggauss(64)


def gauss(function, low, high):
    """The mean of a function between two ends."""
    return 0.5 * WEIGHTS @ function(low + 0.5 * (high - low) * (1 + NODES))


def over_disc(radius, count=200):
    """The kernel's mean over a disc as a function of the cosine to its middle.

    Around a place at the angle a from the middle, each circle of the angle g has an arc inside the
    disc, of the half angle p with cos p = (cos r - cos a cos g) / (sin a sin g).
    """
    far, near = np.linspace(0, np.pi, count), np.linspace(0, min(4 * radius, np.pi), count)
    angles = np.unique(np.concatenate([far, near]))

    def arc(g, a):
        sines = np.maximum(np.sin(a) * np.sin(g), 1e-300)
        return 2 * np.arccos(np.clip((np.cos(radius) - np.cos(a) * np.cos(g)) / sines, -1, 1))

    def mean(a):
        # Inside, and beyond the opposite place, whole circles lie in the disc or none does.
        ends = sorted([0, abs(a - radius), min(a + radius, 2 * np.pi - a - radius), np.pi])
        total = 0
        for low, high in pairwise(ends):

            def ring(t, low=low, high=high):
                # More nodes at the ends, where an arc grows like a root.
                g = low + (high - low) * 0.5 * (1 - np.cos(t))
                return kernel(np.cos(g)) * np.sin(g) * arc(g, a) * 0.5 * np.sin(t)

            total += (high - low) * np.pi * gauss(ring, 0, np.pi)
        return total / (2 * np.pi * (1 - np.cos(radius)))

    table = np.array([mean(a) for a in angles])
    return lambda cosine: np.interp(np.arccos(np.clip(cosine, -1, 1)), angles, table)


def small_squares(flux, sides, pixels, parts=6):
    """Directions, fluxes and sides of the parts of pixels."""
    height, width, _ = flux.shape
    step = (np.arange(parts) + 0.5) / parts
    row, column = (
        (pixels[:, axis, None, None] + step.reshape(shape)).repeat(parts, axis=2 - axis)
        for axis, shape in ((0, (1, -1, 1)), (1, (1, 1, -1)))
    )
    uv = np.stack([column / width, row / height], axis=-1).reshape(-1, 2)
    each = flux[tuple(pixels.T)] / parts**2
    side = sides[tuple(pixels.T)] / parts
    return kernels.uv_to_direction(uv), each.repeat(parts**2, axis=0), side.repeat(parts**2)


def in_twos(values):
    """Sums of two by two pixels."""
    height, width, _ = values.shape
    return values.reshape(height // 2, 2, width // 2, 2, -1).sum(axis=(1, 3))


def energy_of_rows(flux, sides):
    """The double sum over the pixels of a map: along rows by Fourier transforms."""
    height, width, _ = flux.shape
    theta = np.pi * (np.arange(height) + 0.5) / height
    turns = np.cos(2 * np.pi * np.arange(width) / width)
    spectrum = np.fft.rfft(flux, axis=1)
    counted = np.full(width // 2 + 1, 2.0)
    counted[[0, -1]] = 1
    energy = -(MEAN_DISTANCE / 3 * sides * flux**2).sum(axis=(0, 1))
    for row in range(height):
        cosine = np.cos(theta) * np.cos(theta[row])
        sine = np.sin(theta) * np.sin(theta[row])
        blur = np.fft.rfft(kernel(cosine[:, None] + sine[:, None] * turns), axis=1).real
        seen = np.einsum("jm,jmc->mc", blur, spectrum)
        energy += counted @ (spectrum[row].conj() * seen).real / width
    return energy
