"""Each kernel against the same formula in extended precision, and in float32."""

from functools import cache

import numpy as np

import envlights as el
from envlights import _native, kernels
from tests.helpers import NORMALS, SOLID_ANGLES
from tests.stress.case import U32, U64, Case

#: Extended precision: a mantissa of 64 bits, where the processor has one.
LONG = np.longdouble
_HEIGHT = 64


@cache
def _noisy():
    """Radiance in 20 stops, and a sun of one pixel."""
    radiance = np.exp2(np.random.default_rng(1).uniform(-10, 10, (_HEIGHT, 2 * _HEIGHT, 3)))
    radiance[20, 30] = 1e7
    return radiance.astype(np.float32)


def _worst(found, wanted):
    """Largest error relative to the largest value wanted."""
    return float(np.abs(found - wanted).max() / np.abs(wanted).max())


def _cosines(a, b, dtype):
    """Dot products of all rows; `matmul` has no extended precision."""
    return sum(a[:, None, i].astype(dtype) * b[None, :, i].astype(dtype) for i in range(3))


def _solid_angles(dtype):
    edges = (np.arange(_HEIGHT + 1, dtype=dtype) / _HEIGHT) * _pi(dtype)
    return (np.cos(edges[:-1]) - np.cos(edges[1:])) * (_pi(dtype) / _HEIGHT)


def _pi(dtype):
    return 4 * np.arctan(dtype(1))


def _solid_angle_error(found):
    wanted = _solid_angles(LONG)
    return float(np.max(np.abs(found / wanted - 1)))


def _sum_sources(dtype):
    """Equations 1 to 3 of the paper over all pixels."""
    directions = kernels.pixel_directions(_HEIGHT, 2 * _HEIGHT).reshape(-1, 3)
    areas = kernels.pixel_solid_angles(_HEIGHT, 2 * _HEIGHT).reshape(-1, 1).astype(dtype)
    flux = _noisy().reshape(-1, 3).astype(dtype) * areas
    lobes = np.maximum(_cosines(NORMALS[::16], directions, dtype), 0)
    return np.stack([(lobes * channel).sum(axis=1) for channel in flux.T], axis=1)


def _ours_summed():
    directions = kernels.pixel_directions(_HEIGHT, 2 * _HEIGHT).reshape(-1, 3)
    areas = kernels.pixel_solid_angles(_HEIGHT, 2 * _HEIGHT).ravel()
    return kernels.sum_over_sources(NORMALS[::16], directions, _noisy().reshape(-1, 3), areas)


def _blob():
    """A disc of noise on black."""
    radiance = np.zeros((256, 512, 3), np.float32)
    rows, columns = np.mgrid[100:110, 300:310]
    inside = (rows - 104.5) ** 2 + (columns - 304.5) ** 2 < 25
    values = np.random.default_rng(2).uniform(50, 100, inside.sum())
    radiance[rows[inside], columns[inside]] = values[:, None]
    return radiance


def _centroid(dtype):
    radiance = _blob().astype(dtype)
    directions = kernels.pixel_directions(256, 512).astype(dtype)
    areas = kernels.pixel_solid_angles(256, 512).astype(dtype)
    vector = (directions * (radiance[..., :1] * areas[..., None])).sum(axis=(0, 1))
    return vector / np.sqrt((vector**2).sum())


@cache
def _images():
    """Noise, and walls of one colour, whose products are all rounded alike; (6, 128, 128, 3)."""
    noise = np.random.default_rng(3).gamma(0.3, 1, (3, 128, 128, 3))
    walls = np.broadcast_to([[[[0.1, 0.3, 0.7]]]], noise.shape)
    return np.concatenate([noise, walls]).astype(np.float32)


def _gram(dtype):
    """Sums of one product after the other; those of `sum` would be of pairs."""
    rows = np.moveaxis(_images(), -1, 1).reshape(18, -1).astype(dtype)
    return np.array([[np.cumsum(one * other)[-1] for other in rows] for one in rows])


def _ours_gram():
    # The kernel fills the lower half.
    lower = np.tril(_native.transfer_gram(_images().reshape(6, -1, 3), np.ones(6, np.float32))[0])
    return lower + np.tril(lower, -1).T


def _gram_error(found):
    """Largest of all terms, each relative to itself: all are sums of one sign."""
    return float(np.abs(found / _gram(LONG) - 1).max())


def _lights(seed=4, count=5):
    rng = np.random.default_rng(seed)
    angles = np.stack([rng.uniform(0.1, 3.0, count), rng.uniform(0, 6.2, count)], axis=1)
    strength = 10.0 ** rng.uniform(-4, 4, (count, 3))
    return np.concatenate([rng.uniform(0, 1, 3), np.hstack([strength, angles]).ravel()])


def _jacobian(dtype):
    """Derivatives of the residual of equations 7 to 9, as `tests/reference/madsen.py` has them."""
    x, normals = _lights().astype(dtype), NORMALS.astype(dtype)
    root = np.sqrt(SOLID_ANGLES.astype(dtype))[:, None]
    out = np.zeros((len(normals), 3, len(x)), dtype)
    out[:, range(3), range(3)] = _pi(dtype)
    for at in range(3, len(x), 5):
        strength, (theta, phi) = x[at : at + 3], x[at + 3 : at + 5]
        st, ct, sp, cp = np.sin(theta), np.cos(theta), np.sin(phi), np.cos(phi)
        towards, by_theta, by_phi = (
            (normals * np.array(v, dtype)).sum(axis=1)
            for v in ([sp * st, ct, -cp * st], [sp * ct, -st, -cp * ct], [cp * st, 0, sp * st])
        )
        out[:, range(3), range(at, at + 3)] = np.maximum(towards, 0)[:, None]
        for k, slope in enumerate((by_theta, by_phi)):
            out[:, :, at + 3 + k] = np.where(towards > 0, slope, 0)[:, None] * strength
    return (-root[..., None] * out).reshape(-1, len(x))


def _ours_jacobian():
    nothing = np.zeros((len(NORMALS), 3))
    return kernels.probe_jacobian(_lights(), NORMALS, nothing, weights=SOLID_ANGLES)


def _hessian(jacobian):
    """J^T J of Gauss and Newton, scaled to a diagonal of 1."""
    sums = (jacobian[:, :, None] * jacobian[:, None, :]).sum(axis=0)
    root = np.sqrt(np.einsum("ii->i", sums))
    return sums / root[:, None] / root


def _from(ours, plain):
    """Errors of ours, and of the formula in float32."""
    return {
        "measure": lambda: _worst(ours(), plain(LONG)),
        "float32": lambda: _worst(plain(np.float32), plain(LONG)),
    }


_PIXELS = 2 * _HEIGHT**2

CASES = [
    Case(
        "precision",
        "solid angle of a pixel",
        3 * U64 / (1 - np.cos(np.pi / _HEIGHT)),
        "bound 1: a difference of cosines",
        lambda: _solid_angle_error(kernels.pixel_solid_angles(_HEIGHT, 2 * _HEIGHT)[:, 0]),
        lambda: _solid_angle_error(_solid_angles(np.float32)),
    ),
    Case(
        "precision",
        "probe, sum over pixels",
        (_PIXELS + 8) * U64,
        "bound 2: a sum of terms of one sign",
        **_from(_ours_summed, _sum_sources),
    ),
    Case(
        "precision",
        "centroid of a light",
        4 * U32 * np.deg2rad(3.6) + 8 * U64,
        "bound 3: weights in float32, over a light of 3.6 degrees in radius",
        **_from(lambda: el.detect(_blob()).direction[0], _centroid),
    ),
    Case(
        "precision",
        "Gram terms of transfer",
        (256 + 4 + 1) * U32,
        "bound 2 in float32: four sums of 256 products in a block of 1024 texels",
        measure=lambda: _gram_error(_ours_gram()),
        float32=lambda: _gram_error(_gram(np.float32)),
    ),
    Case(
        "precision",
        "Jacobian of the probe",
        16 * U64,
        "a product of two sines and an irradiance, and three sums",
        **_from(_ours_jacobian, _jacobian),
    ),
    Case(
        "precision",
        "Hessian of Gauss and Newton, diagonal 1",
        (3 * len(NORMALS) + 64) * U64,
        "bound 2 over the residuals",
        measure=lambda: _worst(_hessian(_ours_jacobian().astype(LONG)), _hessian(_jacobian(LONG))),
        float32=lambda: _worst(_hessian(_jacobian(np.float32)), _hessian(_jacobian(LONG))),
    ),
]
