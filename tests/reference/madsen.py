"""The equations of Madsen et al. (2003), and their fit by scipy: bounded, analytic Jacobian.

Slow and plain. Unknowns: ambient radiance (3), then for each light irradiance (3), theta, phi.
"""

import math

import numpy as np
from scipy.optimize import least_squares


def probe_as_written(x, normals, k_a, k_d, C):  # noqa: N803, the paper's name
    """Equations 4 to 6, one sum after the other."""
    probe = []
    for n in normals:
        for channel in range(3):
            value = k_a * C[channel] * x[channel]
            for at in range(3, len(x), 5):
                theta, phi = x[at + 3], x[at + 4]
                # The paper's vector, with its axes (x, y, z) called (-z, x, y) here.
                paper = (
                    math.sin(theta) * math.cos(phi),
                    math.sin(theta) * math.sin(phi),
                    math.cos(theta),
                )
                cosine = -n[2] * paper[0] + n[0] * paper[1] + n[1] * paper[2]
                value += k_d * C[channel] * x[at + channel] * max(0.0, cosine)
            probe.append(value)
    return np.reshape(probe, (len(normals), 3))


def cosines(x, normals, xp=np):
    """`n . l` of every normal with every light; `xp` is numpy or what writes like it."""
    lights = x[3:].reshape(-1, 5)
    theta, phi = lights[:, 3], lights[:, 4]
    direction = xp.stack([xp.sin(phi) * xp.sin(theta), xp.cos(theta), -xp.cos(phi) * xp.sin(theta)])
    return normals @ direction


def probe_of_lit(x, normals, k_a, k_d, C, lit, xp=np):  # noqa: N803, the paper's name
    """Equations 4 to 6 where it is given which normal is `lit` by which light.

    Analytic in `x`, so it takes complex steps and automatic derivatives.
    """
    cosine = xp.where(lit, cosines(x, normals, xp), 0)
    return k_a * C * x[:3] + k_d * C * (cosine @ x[3:].reshape(-1, 5)[:, :3])


def derivatives_by_complex_steps(function, x, step=1e-30):
    """Columns of the Jacobian of an analytic `function`, without a difference that cancels."""
    columns = []
    for i in range(len(x)):
        ahead = x.astype(complex)
        ahead[i] += 1j * step
        columns.append(function(ahead).imag.ravel() / step)
    return np.stack(columns, axis=-1)


def directions_and_derivatives(theta, phi):
    """Unit vectors (m, 3) in the frame of `EnvMap`, and their derivatives by theta and phi."""
    st, ct, sp, cp = np.sin(theta), np.cos(theta), np.sin(phi), np.cos(phi)
    zero = np.zeros_like(theta)
    direction = np.stack([sp * st, ct, -cp * st], axis=-1)
    by_theta = np.stack([sp * ct, -st, -cp * ct], axis=-1)
    by_phi = np.stack([cp * st, zero, sp * st], axis=-1)
    return direction, by_theta, by_phi


class Problem:
    """Residual and Jacobian of equations 7 to 9, in the shape that scipy expects."""

    def __init__(self, normals, weights, irradiance, lights):
        self.normals, self.irradiance, self.lights = normals, irradiance, lights
        self.root = np.sqrt(weights)[:, None]

    def split(self, x):
        lights = x[3:].reshape(self.lights, 5)
        return x[:3], lights[:, :3], lights[:, 3], lights[:, 4]

    def residual(self, x):
        ambient, strength, theta, phi = self.split(x)
        direction, _, _ = directions_and_derivatives(theta, phi)
        cosine = np.maximum(self.normals @ direction.T, 0)
        return (self.root * (np.pi * ambient + cosine @ strength - self.irradiance)).ravel()

    def jacobian(self, x):
        _, strength, theta, phi = self.split(x)
        direction, *derivatives = directions_and_derivatives(theta, phi)
        dot = self.normals @ direction.T
        out = np.zeros((len(self.normals), 3, len(x)))
        out[:, range(3), range(3)] = np.pi
        for j in range(self.lights):
            at = 3 + 5 * j
            out[:, range(3), range(at, at + 3)] = np.maximum(dot[:, j], 0)[:, None]
            for k, by in enumerate(derivatives):
                slope = np.where(dot[:, j] > 0, self.normals @ by[j], 0)
                out[:, :, at + 3 + k] = slope[:, None] * strength[j]
        return (self.root[..., None] * out).reshape(-1, len(x))

    def solve(self, start):
        low = np.tile([0, 0, 0, -np.inf, -np.inf], self.lights)
        bounds = (np.concatenate([np.zeros(3), low]), np.inf)
        return least_squares(self.residual, start, self.jacobian, bounds=bounds)

    def random_start(self, rng):
        uniform = rng.uniform(size=(self.lights, 2))
        strength = rng.uniform(0.1, 1.0, size=(self.lights, 3))
        angles = np.stack([np.arccos(1 - 2 * uniform[:, 0]), 2 * np.pi * uniform[:, 1]], axis=-1)
        lights = np.concatenate([strength, angles], axis=-1)
        return np.concatenate([rng.uniform(0.01, 0.3, size=3), lights.ravel()])


def best_of_random_starts(normals, weights, irradiance, lights, starts, seed):
    """Least relative RMS error that `starts` random starts reach."""
    problem = Problem(normals, weights, irradiance, lights)
    rng = np.random.default_rng(seed)
    cost = min(problem.solve(problem.random_start(rng)).cost for _ in range(starts))
    return np.sqrt(2 * cost / np.sum(weights[:, None] * irradiance**2))
