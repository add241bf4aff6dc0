"""Geometry of cards: points O + a U + b V, as a matrix with the columns U, V, O."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights._native import EnvLightsError

#: Corners of a card as (a, b, 1), in the order of `corners`.
CORNERS = np.array([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
#: Number of vertices of an ellipse as a polygon; at equal area, the vector irradiance is accurate
#: to 1e-9.
_VERTICES = 720


def points(matrix: NDArray[np.float64], places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points on cards, (n, k, 3), at coordinates (a, b, 1), (k, 3)."""
    result: NDArray[np.float64] = np.einsum("nij,kj->nki", matrix, places)
    return result


def unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vectors normalised along the last axis."""
    result: NDArray[np.float64] = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return result


def one(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """First row of an array."""
    row: NDArray[np.float64] = rows[0]
    return row


def corners(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit directions of the corners O, O + U, O + U + V, O + V, (n, 4, 3)."""
    return unit(points(matrix, CORNERS))


def centres(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Centres of cards in space, (n, 3)."""
    return points(matrix, np.array([[0.5, 0.5, 1.0]]))[:, 0]


def sizes(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angles between midpoints of opposite edges along U and along V, in radians, (n, 2)."""
    middles = np.array([[0, 0.5, 1], [1, 0.5, 1], [0.5, 0, 1], [0.5, 1, 1]])
    ends = unit(points(matrix, middles))
    pairs = ends[:, ::2], ends[:, 1::2]
    chord = np.linalg.norm(pairs[0] - pairs[1], axis=2)
    angles: NDArray[np.float64] = 2 * np.arcsin(np.minimum(chord / 2, 1))
    return angles


def normals(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit normals of the emitting side, towards the origin, (n, 3)."""
    across: NDArray[np.float64] = np.cross(matrix[:, :, 1], matrix[:, :, 0])
    return unit(across)


def outline(matrix: NDArray[np.float64], is_ellipse: bool) -> NDArray[np.float64]:
    """Unit directions around a card, (k, 3): its corners, or a polygon for its ellipse."""
    if not is_ellipse:
        return one(corners(matrix[None]))
    angle = 2 * np.pi * np.arange(_VERTICES) / _VERTICES
    # Use a polygon with the area of the ellipse.
    radius = 0.5 * np.sqrt(2 * np.pi / _VERTICES / np.sin(2 * np.pi / _VERTICES))
    places = np.stack([0.5 + radius * np.cos(angle), 0.5 + radius * np.sin(angle)], axis=1)
    return one(unit(points(matrix[None], np.insert(places, 2, 1.0, axis=1))))


def vector_irradiance(outline: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vector irradiance of a polygon with radiance 1, (3,), by Lambert's formula.

    The vertices go around the polygon from the first axis of its card to the second.
    """
    following = np.roll(outline, -1, axis=0)
    across = np.cross(outline, following)
    sine = np.linalg.norm(across, axis=1)
    angle = np.arctan2(sine, np.einsum("ki,ki->k", outline, following))
    vector: NDArray[np.float64] = 0.5 * (angle / np.maximum(sine, 1e-300)) @ across
    return vector


def square_towards(direction: NDArray[np.float64], radius: float) -> NDArray[np.float64]:
    """Matrix of the facing square around a disc, with rows downwards in the map.

    At the zenith and the nadir, they go as in the middle column of the map. Radii above 1.4 rad are
    those of 1.4 rad, because the square of a half sphere is infinite.
    """
    up = np.array([0.0, 1.0, 0.0])
    right = np.cross(direction, up)
    if np.linalg.norm(right) < 1e-9:  # a pole
        right = np.array([-1.0, 0.0, 0.0])
    right = unit(right)
    down = np.cross(direction, right)
    half = np.tan(min(radius, 1.4))
    return np.stack([2 * half * right, 2 * half * down, direction - half * (right + down)], axis=1)


def tilt(matrix: NDArray[np.float64], normal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Matrix of the parallelogram closest to the card's outline, in a plane with another normal.

    The plane holds the centre. The corners move along their rays into the plane, and the nearest
    parallelogram in the sense of least squares replaces their quadrilateral.
    """
    centre = centres(matrix[None])[0]
    rays = corners(matrix[None])[0]
    slopes = rays @ normal
    if (slopes * (centre @ normal) <= 0).any():
        raise EnvLightsError(
            "normal must turn the card so that all its corners are seen from the origin; got"
            f" {normal.tolist()} for a card at {centre.tolist()}"
        )
    hit = rays * (centre @ normal / slopes)[:, None]
    first = (hit[1] + hit[2] - hit[0] - hit[3]) / 2
    second = (hit[2] + hit[3] - hit[0] - hit[1]) / 2
    parts = [first, second, centre - (first + second) / 2]
    matrix_in_plane: NDArray[np.float64] = np.stack(parts, axis=1)
    return matrix_in_plane


def nearest_rectangle(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Matrix of the rectangle nearest to a parallelogram, with the same centre and area."""
    lengths = np.linalg.norm(matrix[:, :2], axis=0)
    left, values, right = np.linalg.svd(matrix[:, :2] / lengths, full_matrices=False)
    sides = left @ right * lengths * np.sqrt(values.prod())
    return np.column_stack([sides, matrix @ [0.5, 0.5, 1] - sides.sum(axis=1) / 2])


def sources(
    matrix: NDArray[np.float64], texture: NDArray[np.float32], parts: int, *, is_disc: bool
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Unit directions and RGB fluxes, (k, 3) each, of `parts` x `parts` or more parts."""
    rows, columns = texture.shape[:2]
    tall, wide = -(-parts // rows), -(-parts // columns)
    b = (np.arange(rows * tall) + 0.5)[:, None] / (rows * tall)
    a = (np.arange(columns * wide) + 0.5) / (columns * wide)
    places = np.stack([*np.broadcast_arrays(a, b, 1.0)], axis=-1).reshape(-1, 3)
    radiance = texture.repeat(tall, axis=0).repeat(wide, axis=1).reshape(-1, 3)
    if is_disc:
        inside = ((2 * places[:, :2] - 1) ** 2).sum(axis=1) <= 1
        places, radiance = places[inside], radiance[inside]
    to_points = places @ matrix.T
    distance = np.linalg.norm(to_points, axis=1, keepdims=True)
    angle = np.linalg.det(matrix) / (rows * tall * columns * wide) / distance**3
    return to_points / distance, angle * radiance
