"""The fit of Madsen et al. (2003) by scipy: all 3 + 5M unknowns, bounded, analytic Jacobian.

Slow and plain. Unknowns: ambient radiance (3), then for each light irradiance (3), theta, phi.
"""

import numpy as np
from scipy.optimize import least_squares


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
