"""Worlds as functions of direction, and their cubes, without the code under test."""

import numpy as np

#: Forward, right and up of each upright face, in the order front right back left up down.
BASES = np.array(
    [
        [(0, 0, 1), (-1, 0, 0), (0, 1, 0)],
        [(-1, 0, 0), (0, 0, -1), (0, 1, 0)],
        [(0, 0, -1), (1, 0, 0), (0, 1, 0)],
        [(1, 0, 0), (0, 0, 1), (0, 1, 0)],
        [(0, 1, 0), (-1, 0, 0), (0, 0, -1)],
        [(0, -1, 0), (-1, 0, 0), (0, 0, 1)],
    ],
    float,
)


def grid(n, border=False):
    """Coordinates from -1 to 1 of the samples of a face: to the right, and up."""
    at = np.linspace(-1, 1, n) if border else (np.arange(n) + 0.5) * 2 / n - 1
    return np.meshgrid(at, -at)


def upright_directions(n, border=False):
    """Unit vectors of the pixels of six upright faces, (6, n, n, 3)."""
    a, b = grid(n, border)
    forward, right, up = BASES.transpose(1, 0, 2)[:, :, None, None]
    directions = forward + a[..., None] * right + b[..., None] * up
    return directions / np.linalg.norm(directions, axis=-1, keepdims=True)


def opengl_directions(n):
    """Unit vectors in our frame of the six faces of OpenGL, by table 8.19 of its specification.

    The table gives s, t and the major axis for each face; t is 0 in the first row.
    """
    s, t = grid(n)[0], -grid(n)[1]
    one = np.ones_like(s)
    faces = [(one, -t, -s), (-one, -t, s), (s, one, t), (s, -one, -t), (s, -t, one), (-s, -t, -one)]
    x, y, z = np.moveaxis(np.array(faces), 1, 0)
    directions = np.stack([-x, y, z], axis=-1)
    return directions / np.linalg.norm(directions, axis=-1, keepdims=True)


def smooth(directions, seed=0):
    """Radiance of a smooth world without symmetry, (..., 3)."""
    rng = np.random.default_rng(seed)
    waves = rng.normal(size=(12, 3)) * rng.uniform(1, 6, (12, 1))
    phases, weights = rng.uniform(0, 6, 12), rng.normal(size=(12, 3)) / 4
    return np.exp(np.sin(directions @ waves.T + phases) @ weights).astype(np.float32)


def looked_up(radiance, directions):
    """Bilinear samples of an equirectangular map, cell-centred."""
    height, width, _ = radiance.shape
    x, y, z = np.moveaxis(directions, -1, 0)
    u = np.arctan2(x, -z) % (2 * np.pi) / (2 * np.pi) * width - 0.5
    v = (np.arccos(np.clip(y, -1, 1)) / np.pi * height - 0.5).clip(0, height - 1)
    left, top = np.floor(u).astype(int), np.floor(v).astype(int).clip(0, height - 2)
    u, v = (u - left)[..., None], (v - top)[..., None]
    rows = [
        radiance[row, left % width] * (1 - u) + radiance[row, (left + 1) % width] * u
        for row in (top, top + 1)
    ]
    return (rows[0] * (1 - v) + rows[1] * v).astype(np.float32)
