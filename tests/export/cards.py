"""Cards by hand that test every exporter: corners of four colours, a disc, an oblique window."""

import numpy as np

import envlights as el
from envlights import kernels
from envlights.cards import geometry

#: Colours of the corners: top left, top right, bottom left, bottom right as seen in the map.
CORNERS = np.array([[[8, 0, 0], [0, 8, 0]], [[0, 0, 8], [6, 6, 0]]], np.float32)


def facing(azimuth, elevation, width, height, turn=0.0):
    """Matrix of a rectangle that faces the origin at distance 1; all angles in degrees."""
    azimuth, elevation, turn = np.radians([azimuth, elevation, turn])
    towards = np.array(
        [
            np.cos(elevation) * np.sin(azimuth),
            np.sin(elevation),
            -np.cos(elevation) * np.cos(azimuth),
        ]
    )
    right = np.cross(towards, [0, 1, 0])
    right /= np.linalg.norm(right)
    down = np.cross(towards, right)
    right, down = (
        np.cos(turn) * right + np.sin(turn) * down,
        np.cos(turn) * down - np.sin(turn) * right,
    )
    sides = [2 * np.tan(np.radians(width) / 2) * right, 2 * np.tan(np.radians(height) / 2) * down]
    return np.stack([*sides, towards - sum(sides) / 2], axis=1)


def shear(matrix):
    """A parallelogram that is no rectangle."""
    u, v, start = matrix.T
    return np.stack([u, v + 0.4 * u, start - 0.2 * u], axis=1)


def card(shape, matrix, texture):
    """One card with the irradiance of its texture, by small pieces."""
    rows, columns, _ = texture.shape
    fine = texture.repeat(-(-256 // rows), axis=0).repeat(-(-256 // columns), axis=1)
    rows, columns, _ = fine.shape
    b, a = np.meshgrid(
        (np.arange(rows) + 0.5) / rows, (np.arange(columns) + 0.5) / columns, indexing="ij"
    )
    if shape == "disc":
        fine = fine * ((2 * a - 1) ** 2 + (2 * b - 1) ** 2 <= 1)[..., None]
    points = np.stack([a, b, np.ones_like(a)], axis=-1) @ matrix.T
    far = np.linalg.norm(points, axis=-1, keepdims=True)
    volume = abs(np.linalg.det(matrix))
    angle = volume / far**3 / (rows * columns)
    towards = points / far
    centre = matrix @ [0.5, 0.5, 1]
    cosine = towards @ centre / np.linalg.norm(centre)
    irradiance = np.einsum("yxc,yx->c", fine, angle[..., 0] * cosine)
    return el.Cards([shape], [matrix], [irradiance], [texture])


#: A window on the left with four colours, turned; wide enough for a texel of 10 degrees.
WINDOW = card("rectangle", facing(100, 15, 40, 24, turn=20), CORNERS.repeat(8, 0).repeat(8, 1))
#: The same colours in a window seen obliquely, as a parallelogram.
OBLIQUE = card("rectangle", shear(facing(200, 5, 30, 24)), CORNERS.repeat(8, 0).repeat(8, 1))
#: A lamp of one colour above.
LAMP = card("disc", facing(-60, 60, 20, 20), np.full((8, 8, 3), [3, 2, 1], np.float32))
ALL = {"window": WINDOW, "oblique": OBLIQUE, "lamp": LAMP}


#: Column and row in each quarter, row by row of `CORNERS`; off the diagonals of triangles.
QUARTERS = np.array([[0.3, 0.2], [0.7, 0.25], [0.2, 0.7], [0.7, 0.8]])


def directions(cards):
    """Directions of `QUARTERS`, (4, 3)."""
    return geometry.unit(geometry.points(cards.matrix, np.insert(QUARTERS, 2, 1, axis=1)))[0]


def irradiance(cards, normals, environment=None):
    """Irradiance of cards at infinity, and of a map around them that they do not hide."""
    around = 0 if environment is None else environment.probe(normals)
    return around + to_map(cards, 1024).probe(normals)


def to_map(cards, width):
    """Map of cards, by nearest texels."""
    sky = kernels.pixel_directions(width // 2, width)
    radiance = np.zeros((width // 2, width, 3), np.float32)
    for each in cards:
        p, q, r = np.moveaxis(sky @ np.linalg.inv(each.matrix).T, -1, 0)
        with np.errstate(all="ignore"):
            a, b = p / r, q / r
        inside = (r > 0) & (a >= 0) & (a < 1) & (b >= 0) & (b < 1)
        if each.shape == "disc":
            inside &= (2 * a - 1) ** 2 + (2 * b - 1) ** 2 <= 1
        rows, columns, _ = each.texture.shape
        there = (b[inside] * rows).astype(int), (a[inside] * columns).astype(int)
        radiance[inside] += each.texture[there]
    return el.EnvMap(radiance)
