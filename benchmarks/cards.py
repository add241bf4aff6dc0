"""Shapes, corners and flux of light cards on generated maps.

Each map has one light: a rectangle that faces the centre, an oblique window, a tube or a disc, at
any place and turn, with a texture of up to 30 % in half of the maps, and 5 % noise. One in five
lies at a pole, one in five on the seam. A tenth as many maps have a window with a view: a bright
sky above a ragged garden that is 2.2 to 4 times as bright as the wall. Run with

    python -m benchmarks.cards [MAPS] [SEED]
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import envlights as el
from envlights.kernels.sphere import pixel_directions, pixel_solid_angles

#: Columns of the maps.
WIDTH = 512
#: Samples along each side of a pixel.
SAMPLES = 4
KINDS = ("rectangle", "oblique", "tube", "disc")


class Truth(NamedTuple):
    """Map with one card."""

    radiance: NDArray[np.float32]
    shape: str
    matrix: NDArray[np.float64]
    irradiance: NDArray[np.float64]
    thickness: float
    """Shorter side in pixels."""

    kind: str


def _unit(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    return vector / np.linalg.norm(vector)


def _place(rng: np.random.Generator, number: int) -> NDArray[np.float64]:
    """Direction of a card: a pole, the seam, or any."""
    if number % 5 == 0:
        return _unit(np.append(rng.normal(0, 0.15, 2), rng.choice([-1, 1]))[[0, 2, 1]])
    if number % 5 == 1:
        return _unit(np.array([rng.normal(0, 0.1), rng.uniform(-0.7, 0.7), -1]))
    return _unit(rng.normal(size=3))


def _matrix(rng: np.random.Generator, kind: str, number: int) -> NDArray[np.float64]:
    """Matrix of a card at a random place, with U x V away from the origin."""
    centre = _place(rng, number)
    first = _unit(np.cross(centre, _unit(rng.normal(size=3))))
    second = np.cross(centre, first)
    size = np.exp(rng.uniform(np.log(0.05), np.log(1.0)))
    aspect = rng.uniform(8, 15) if kind == "tube" else rng.uniform(1, 2 if kind == "disc" else 4)
    if kind == "oblique":
        turn, about = rng.uniform(0.5, 1.05), rng.uniform(0, 2 * np.pi)
        axis = np.cos(about) * first + np.sin(about) * second
        first, second = (_rotate(vector, axis, turn) for vector in (first, second))
    sides = np.array([1, 1 / aspect]) * 2 * np.tan(size / 2)
    u, v = sides[0] * first, sides[1] * second
    return np.stack([u, v, centre - (u + v) / 2], axis=1)


def _rotate(
    vector: NDArray[np.float64], axis: NDArray[np.float64], turn: float
) -> NDArray[np.float64]:
    along = axis * (axis @ vector)
    return along + np.cos(turn) * (vector - along) + np.sin(turn) * np.cross(axis, vector)


def draw(matrix: NDArray[np.float64], is_disc: bool, texture: float) -> NDArray[np.float64]:
    """Luminance of a card of radiance 1 with a ripple of this depth, (height, width)."""
    height = WIDTH // 2 * SAMPLES
    places = pixel_directions(height, 2 * height) @ np.linalg.inv(matrix).T
    depth = np.where(places[..., 2] > 1e-6, places[..., 2], np.inf)
    a, b = places[..., 0] / depth, places[..., 1] / depth
    if is_disc:
        inside = ((a - 0.5) ** 2 + (b - 0.5) ** 2 <= 0.25) & (places[..., 2] > 1e-6)
    else:
        inside = (a >= 0) & (a <= 1) & (b >= 0) & (b <= 1) & (places[..., 2] > 1e-6)
    value = inside * (1 + texture * np.sin(7 * a + 1) * np.cos(5 * b))
    return value.reshape(WIDTH // 2, SAMPLES, WIDTH, SAMPLES).mean(axis=(1, 3))


def maps(number: int, seed: int) -> Iterator[Truth]:
    """Generated maps."""
    rng = np.random.default_rng(seed)
    weights = pixel_solid_angles(WIDTH // 2, WIDTH)
    towards = pixel_directions(WIDTH // 2, WIDTH)
    for i in range(number):
        kind = KINDS[rng.integers(len(KINDS))]
        matrix = _matrix(rng, kind, i)
        value = draw(matrix, kind == "disc", 0.3 * (rng.random() < 0.5))
        light = value[..., None] * np.array([40.0, 35.0, 25.0])
        noise = 1 + 0.05 * rng.standard_normal(light.shape)
        radiance = (light + 0.5) * noise
        centre = _unit(matrix @ [0.5, 0.5, 1])
        irradiance = np.einsum("hwc,hw,hw->c", light, weights, towards @ centre)
        sides = el.cards.geometry.sizes(matrix[None])[0]
        shape = {"oblique": "rectangle"}.get(kind, kind)
        if shape == "rectangle" and sides.max() / sides.min() > 6:
            shape = "tube"
        thickness = sides.min() * WIDTH / (2 * np.pi)
        yield Truth(radiance.astype(np.float32), shape, matrix, irradiance, thickness, kind)


def views(number: int, seed: int) -> Iterator[tuple[NDArray[np.float32], NDArray[np.float64]]]:
    """Maps of a wall with a window, sky above a ragged garden, and the matrices of the windows."""
    rng = np.random.default_rng(seed)
    height = WIDTH
    directions = pixel_directions(2 * height, 4 * height)
    for _ in range(number):
        azimuth = rng.uniform(0, 2 * np.pi)
        wall = np.array([np.sin(azimuth), 0, -np.cos(azimuth)])
        right, up = np.cross(wall, [0, 1, 0]), np.array([0, 1, 0])
        half = rng.uniform(0.25, [0.7, 0.5])
        x, y = rng.uniform([-0.7, -0.1], [0.7, 0.3])
        corner = wall + (x - half[0]) * right + (y + half[1]) * up
        matrix = np.stack([2 * half[0] * right, -2 * half[1] * up, corner], axis=1)
        p = directions @ np.linalg.inv(matrix).T
        depth = np.where(p[..., 2] > 1e-6, p[..., 2], np.inf)
        a, b = p[..., 0] / depth, p[..., 1] / depth
        inside = (a >= 0) & (a <= 1) & (b >= 0) & (b <= 1) & (p[..., 2] > 1e-6)
        skyline = np.interp(a, np.linspace(0, 1, 9), rng.uniform(0.25, 0.75, 9))
        dim, sky = rng.uniform(0.3, 0.8), rng.uniform(15, 30)
        garden = dim * rng.uniform(2.2, 4) * (1 + 0.3 * np.sin(23 * a) * np.sin(17 * b))
        around = dim * (1 + 0.3 * directions[..., 1])
        value = np.where(inside, np.where(b < skyline, sky, garden), around)
        value = value.reshape(height, 2, 2 * height, 2).mean(axis=(1, 3))
        value *= 1 + 0.03 * rng.standard_normal(value.shape)
        yield np.repeat(value[..., None], 3, axis=2).astype(np.float32), matrix


def corner_error(cards: el.Cards, matrix: NDArray[np.float64], width: int = WIDTH) -> float:
    """Largest distance of a corner from the true one, in pixels, for the best order."""
    true = el.cards.geometry.corners(matrix[None])[0]
    turns = [np.roll(cards.corners[0], k, axis=0) for k in range(4)]
    errors = [np.linalg.norm(turn - true, axis=1).max() for turn in turns]
    return float(min(errors)) * width / (2 * np.pi)


def main() -> None:
    """Print the figures."""
    number = int(sys.argv[1]) if len(sys.argv) > 1 else 400
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    rows = []
    for i, truth in enumerate(maps(number, seed)):
        cards, _ = el.split(el.EnvMap(truth.radiance), shapes=True)
        if not len(cards):
            print(f"map {i}: no card, {truth.kind}, {truth.thickness:.1f} pixels")
            continue
        error = corner_error(cards, truth.matrix)
        flux = abs(cards.irradiance[0, 1] / truth.irradiance[1] - 1)
        right = cards.shape[0] == truth.shape
        rows.append((truth.kind, truth.thickness, right, error, flux))
        if truth.thickness >= 5 and (not right or (truth.kind != "disc" and error > 1)):
            print(
                f"map {i}: {truth.kind} {truth.shape} -> {cards.shape}, {truth.thickness:.1f}"
                f" pixels, corners {error:.2f}, overlap {cards.overlap[0]:.2f}"
            )
    for kind in KINDS:
        for low, high in ((0, 5), (5, np.inf)):
            part = [row for row in rows if row[0] == kind and low <= row[1] < high]
            if part:
                _, _, right, error, flux = zip(*part, strict=True)
                print(
                    f"{kind:10} {low}+ pixels: {sum(right)} of {len(part)} named right, corners"
                    f" {np.median(error):.3f} / {np.quantile(error, 0.95):.3f} pixels,"
                    f" flux {100 * np.median(flux):.2f} %"
                )
    thick = [row for row in rows if row[1] >= 5]
    boxes = [row[3] for row in thick if row[0] != "disc"]
    print(
        f"all from 5 pixels: {100 * np.mean([row[2] for row in thick]):.1f} % named right,"
        f" corners {np.median(boxes):.3f} / {np.quantile(boxes, 0.95):.3f} pixels,"
        f" flux {100 * np.median([row[4] for row in thick]):.2f} %"
    )
    found = [
        corner_error(cards, matrix, 2 * WIDTH)
        for radiance, matrix in views(number // 10, seed)
        if (cards := el.split(radiance, shapes=True)[0]).shape[0] == "rectangle"
    ]
    print(
        f"windows with a view: {len(found)} of {number // 10} are rectangles, corners"
        f" {np.median(found):.3f} / {np.quantile(found, 0.95):.3f} pixels of 1024"
    )


if __name__ == "__main__":
    main()
