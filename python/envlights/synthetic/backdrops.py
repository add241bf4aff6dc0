"""Backgrounds without lights: skies, walls, clouds, glare.

Each function draws random numbers from `rng` and returns the radiance of a whole map,
(height, 2 * height, 3), with the brightest luminance about 1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from envlights._common.blocks import blocks, in_blocks
from envlights.kernels import sampling, sphere
from envlights.kernels.image import LUMINANCE
from envlights.synthetic.shapes import Lamp, Rectangle, smoothstep


def constant(rng: np.random.Generator, height: int) -> NDArray[np.float64]:
    """Equal radiance in all directions."""
    return np.broadcast_to(tint(rng), (height, 2 * height, 3))


def gradient(rng: np.random.Generator, height: int) -> NDArray[np.float64]:
    """Clear sky above darker ground, without a horizon edge."""
    ground, steepness = rng.uniform(0.02, 0.3), rng.uniform(1, 3)
    colour = tint(rng)

    def radiance(directions: NDArray[np.float64]) -> NDArray[np.float64]:
        level = ground + (1 - ground) * ((1 + directions[..., 1]) / 2) ** steepness
        return level[..., None] * colour

    return sphere.over_map(height, radiance)


def white_wall(rng: np.random.Generator, height: int) -> NDArray[np.float64]:
    """Room with one bright wall."""
    phi, (broad, high) = rng.uniform(0, 2 * np.pi), rng.uniform([70, 50], [120, 90])
    wall = Rectangle((np.sin(phi), 0, -np.cos(phi)), broad, high, (1, 1, 1)).coverage(height)
    room = rng.uniform(0.1, 0.4)
    return _colour(lambda rows: room + (1 - room) * wall[rows], height, tint(rng))


def checker(rng: np.random.Generator, height: int) -> NDArray[np.float64]:
    """Tiles of two greys."""
    squares, dark = int(rng.integers(8, 20)), rng.uniform(0.1, 0.6)
    # Align tiles with pixels, with an even number of tiles around the horizon.
    row = np.arange(height) * squares // height
    column = np.arange(2 * height) * 2 * squares // (2 * height)

    def level(rows: slice) -> NDArray[np.float64]:
        return np.where((row[rows, None] + column) % 2, dark, 1.0)

    return _colour(level, height, tint(rng))


def clouds(rng: np.random.Generator, height: int) -> NDArray[np.float64]:
    """White clouds in a darker sky above still darker ground."""
    up = sphere.pixel_directions(height, 2)[:, :1, 1]
    noise, least = _waves(rng, height), rng.uniform(-0.2, 0.4)
    sky, ground = rng.uniform(0.15, 0.3), rng.uniform(0.03, 0.1)

    def radiance(rows: slice) -> NDArray[np.float64]:
        cover = smoothstep(noise[rows], least, 1.2)
        above = sky * np.array([0.7, 1.0, 1.5]) + (1 - sky) * cover[..., None]
        horizon = smoothstep(up[rows], -0.03, 0.03)[..., None]
        return horizon * above + (1 - horizon) * ground

    bright = in_blocks((height, 2 * height, 3), radiance)
    largest = max((bright[rows] @ LUMINANCE).max() for rows in blocks(bright.shape))
    return in_blocks(bright.shape, lambda rows: bright[rows] / largest)


def lit_walls(rng: np.random.Generator, height: int) -> NDArray[np.float64]:
    """Soft pools of light on the walls of a dim room, from hidden lamps."""
    dim = rng.uniform(0.12, 0.4)
    pools = [
        (centre, np.deg2rad(rng.uniform(12, 35)), rng.uniform(0.3, 1))
        for centre in sampling.uniform_sphere(rng.random((int(rng.integers(2, 5)), 2)))
    ]

    def level(directions: NDArray[np.float64]) -> NDArray[np.float64]:
        room = np.full(directions.shape[:2], dim)
        for centre, width, strength in pools:
            off = np.arccos(np.clip(directions @ centre, -1, 1)) / width
            room += strength * np.exp(-(off**2))
        return room

    room = sphere.over_map(height, level)
    largest = room.max()
    return _colour(lambda rows: room[rows] / largest, height, tint(rng))


def glare(rng: np.random.Generator, height: int, lamps: Sequence[Lamp]) -> NDArray[np.float64]:
    """Lens halos around lights, with a few per cent of the lights' radiance at the rim.

    A halo falls off as exp(-(angle from the rim) / width). Around a light smaller than this width
    it is fainter by the ratio of their solid angles, because a lens spreads flux and adds none.
    """
    drawn = []
    for lamp in lamps:
        width, strength = rng.uniform(1, 4), rng.uniform(0.02, 0.08)
        strength *= min(1.0, (_radius_deg(lamp, height) / width) ** 2)
        drawn.append((lamp, width, strength))

    def halos(directions: NDArray[np.float64]) -> NDArray[np.float64]:
        sum_of_all = np.zeros(directions.shape)
        for lamp, width, strength in drawn:
            falloff = np.exp(-lamp.angle_deg(directions) / width)
            sum_of_all += strength * falloff[..., None] * np.asarray(lamp.radiance)
        return sum_of_all

    return sphere.over_map(height, halos)


def _colour(
    level: Callable[[slice], NDArray[np.float64]], height: int, colour: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Map of one colour from its level, computed in blocks of rows."""
    return in_blocks((height, 2 * height, 3), lambda rows: level(rows)[..., None] * colour)


def _radius_deg(lamp: Lamp, height: int) -> float:
    """Radius in degrees of a disc about as large as the light."""
    if isinstance(lamp, Rectangle):
        return float(np.sqrt(lamp.width_deg * lamp.height_deg / np.pi))
    return max(lamp.reach_deg, 90 / height)  # a one-pixel sun has the size of its pixel


def tint(rng: np.random.Generator) -> NDArray[np.float64]:
    """Slightly warm or cold white with luminance 1."""
    colour = np.array([1.0, 1.0, 1.0]) + rng.uniform(-0.25, 0.25) * np.array([1.0, 0.1, -1.0])
    white: NDArray[np.float64] = colour / (colour @ LUMINANCE)
    return white


def _waves(rng: np.random.Generator, height: int) -> NDArray[np.float64]:
    """Smooth noise without seam or poles: plane waves, in octaves of half amplitude each."""
    waves = [
        (octave, axis, rng.uniform(0, 2 * np.pi))
        for octave in range(4)
        for axis in sampling.uniform_sphere(rng.random((6, 2)))
    ]

    def level(directions: NDArray[np.float64]) -> NDArray[np.float64]:
        noise = np.zeros(directions.shape[:2])
        for octave, axis, phase in waves:
            noise += 0.5**octave * np.cos(4 * 2**octave * (directions @ axis) + phase)
        return noise

    noise = sphere.over_map(height, level)
    deviation = noise.std()
    return in_blocks(noise.shape, lambda rows: noise[rows] / deviation)
