"""Suns of one pixel: their true flux and direction in every layout, without the code under test.

The only thing taken from the package is the direction of a place. Flux and direction of a pixel are
integrals over its outline:

    first moment = 1/2 closed integral of d x dd,   solid angle = sum of spherical triangles.
"""

from typing import NamedTuple

import numpy as np
from scipy.sparse.csgraph import connected_components

from envlights import _native
from envlights.environment.layouts import picture_layout as layouts

#: Points on each side of an outline.
POINTS = 48
#: Distance from the outline at which places count as inside, in pixels.
INSIDE = 1e-9


class Sun(NamedTuple):
    """Pixel of a picture, as a light."""

    pixel: tuple[int, int]
    moment: np.ndarray
    solid_angle: float

    @property
    def direction(self):
        return self.moment / np.linalg.norm(self.moment)

    @property
    def side(self):
        """Side of the pixel, in radians."""
        return np.sqrt(self.solid_angle)


def suns_of(layout):
    """Truth of all pixels as suns, without those that show nothing."""
    pixels = np.ndindex(layout.height, layout.width)
    return [sun for pixel in pixels if (sun := sun_of(layout, pixel))]


def sun_of(layout, pixel):
    """Truth of one pixel; None if it shows nothing."""
    corners = outline(layout, pixel)
    if len(corners) < 3:
        return None
    ends = np.roll(corners, -1, axis=0)
    steps = (0.5 - 0.5 * np.cos(np.pi * np.arange(POINTS) / POINTS))[:, None]
    places = np.concatenate([a + (b - a) * steps for a, b in zip(corners, ends, strict=True)])
    directions = _native.projection_directions(layout, places)
    assert np.isfinite(directions).all(), (layout, pixel)
    following = np.roll(directions, -1, axis=0)
    moment = np.cross(directions, following).sum(axis=0) / 2
    centre = directions.mean(axis=0)
    centre /= np.linalg.norm(centre)
    triple = np.cross(directions, following) @ centre
    below = 1 + directions @ centre + following @ centre + (directions * following).sum(axis=1)
    solid_angle = 2 * np.arctan2(triple, below).sum()
    return Sun(pixel, moment * np.sign(moment @ centre), abs(float(solid_angle)))


def outline(layout, pixel):
    """Corners of the part of a pixel that the layout covers, in pixels."""
    row, column = pixel
    x0, y0 = float(column), float(row)
    x1, y1 = x0 + 1, y0 + 1
    if layout.border_sampled:
        top = row // layout.width * layout.width if layout.kind == "cube" else 0
        height = layout.width if layout.kind == "cube" else layout.height
        x0, x1 = max(x0, 0.5), min(x1, layout.width - 0.5)
        y0, y1 = max(y0, top + 0.5), min(y1, top + height - 0.5)
    x0, y0, x1, y1 = x0 + INSIDE, y0 + INSIDE, x1 - INSIDE, y1 - INSIDE
    square = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
    return within_circle(square, layout) if layout.kind == "azimuthal" else square


def circle_of(layout):
    """Centre and radius of an azimuthal picture, in pixels."""
    height, width = layout.height, layout.width
    x, y, radius = layout.circle or (width / 2, height / 2, min(width, height) / 2)
    return np.array([x, y]), radius


def within_circle(square, layout):
    """Part of a square in the circle, as a polygon with many corners on the arc."""
    centre, radius = circle_of(layout)
    if (np.linalg.norm(square - centre, axis=1) < radius * (1 - 1e-9)).all():
        return square
    lowest, highest = square.min(axis=0), square.max(axis=0)
    angles = arc_of(square, centre, radius)
    if not len(angles):
        return np.empty((0, 2))
    arc = centre + radius * (1 - 1e-9) * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    is_on_arc = ((arc >= lowest) & (arc <= highest)).all(axis=1)
    points = [*arc[is_on_arc], *square[np.linalg.norm(square - centre, axis=1) < radius]]
    points += crossings(square, centre, radius * (1 - 1e-9))
    if len(points) < 3:
        return np.empty((0, 2))
    points = np.array(points)
    middle = points.mean(axis=0)  # the part is convex
    return points[np.argsort(np.arctan2(*(points - middle).T[::-1]))]


def arc_of(square, centre, radius):
    """Angles of many points of the circle around a square."""
    middle = square.mean(axis=0) - centre
    if abs(np.linalg.norm(middle) - radius) > 1:
        return np.empty(0)
    spread = min(1.5 / radius, np.pi)
    return np.arctan2(middle[1], middle[0]) + np.linspace(-spread, spread, 400)


def crossings(square, centre, radius):
    """Points where the circle crosses the sides of a square."""
    found = []
    for a, b in zip(square, np.roll(square, -1, axis=0), strict=True):
        along, start = b - a, a - centre
        roots = np.roots([along @ along, 2 * start @ along, start @ start - radius**2])
        found += [a + t * along for t in roots.real[abs(roots.imag) < 1e-12] if 0 <= t <= 1]
    return found


class Grid(NamedTuple):
    """Pixels of a new picture: what a measurement needs."""

    layout: layouts.PictureLayout
    moments: np.ndarray
    solid_angles: np.ndarray


def grid_of_map(width):
    """Cells of an equirectangular map, by closed forms."""
    height = width // 2
    theta, phi = np.pi * np.arange(height + 1) / height, 2 * np.pi * np.arange(width + 1) / width
    across, up = np.diff(theta / 2 - np.sin(2 * theta) / 4), np.diff(np.sin(theta) ** 2 / 2)
    columns = np.stack([-np.diff(np.cos(phi)), np.diff(phi), -np.diff(np.sin(phi))], axis=1)
    rows = np.stack([across, up, across], axis=1)
    angles = -np.diff(np.cos(theta))[:, None] * np.diff(phi)
    return Grid(layouts.equirectangular(height), rows[:, None] * columns, angles)


def grid_of(layout):
    """Pixels of any layout, by their outlines."""
    moments = np.zeros((layout.height, layout.width, 3))
    for sun in suns_of(layout):
        moments[sun.pixel] = sun.moment
    return Grid(layout, moments, _native.projection_solid_angles(layout))


class Measurement(NamedTuple):
    """A sun after a conversion."""

    flux: float
    """Flux over the true one; 0 for a sun that is lost."""

    offset: float
    """Angle from the true direction, in sides of the source pixel."""

    blobs: int
    """Number of connected regions of pixels with more than 1e-7 of the brightest one's flux."""


def measure(channel, grid, sun, flux):
    """Flux, direction and blobs of one sun in one channel of a new picture."""
    pixels = np.argwhere(channel > 0)
    shares = channel[tuple(pixels.T)].astype(float)
    centre = shares @ grid.moments[tuple(pixels.T)]
    shares *= grid.solid_angles[tuple(pixels.T)]
    if not shares.any():
        return Measurement(0.0, np.inf, 0)
    chord = np.linalg.norm(centre / np.linalg.norm(centre) - sun.direction)
    kept = pixels[shares > 1e-7 * shares.max()]
    return Measurement(float(shares.sum() / flux), chord / sun.side, regions(kept, grid))


def regions(pixels, grid):
    """Number of connected regions of pixels."""
    if grid.layout.kind == "equirectangular":
        return regions_of_map(pixels, *grid.solid_angles.shape)
    at = grid.moments[tuple(pixels.T)]
    lengths = np.linalg.norm(at, axis=1)
    at, sides = at / lengths[:, None], np.sqrt(lengths)
    chords = np.linalg.norm(at[:, None] - at, axis=-1)
    return connected_components(chords < 2 * np.maximum(sides[:, None], sides))[0]


def regions_of_map(pixels, height, width):
    """Number of connected regions in an equirectangular map, across its seam and its poles."""
    rows, columns = pixels.T
    far = abs(columns[:, None] - columns)
    is_near = (abs(rows[:, None] - rows) <= 1) & (np.minimum(far, width - far) <= 1)
    for pole in (rows == 0, rows == height - 1):
        is_near |= pole[:, None] & pole
    return connected_components(is_near)[0]
