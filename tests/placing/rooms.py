"""Rooms in closed form: boxes whose walls have a known radiance, with lamps, seen from any point.

All surfaces are Lambertian, so that their radiance does not depend on the point from which they are
seen, and a panorama at any point is a matter of casting rays. Walls are lit by the lamps, once, and
have a texture. Coordinates are those of the camera: the frame of `EnvMap`, in metres.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from envlights import kernels
from envlights.synthetic.shapes import supersample

WARM, COLD, WHITE = np.array([1.0, 0.75, 0.5]), np.array([0.7, 0.85, 1.0]), np.ones(3)
ALBEDO = np.array([[0.6, 0.6, 0.58], [0.35, 0.28, 0.22], [0.6, 0.5, 0.4]])  # x, floor, z


@dataclass(frozen=True)
class Ball:
    """Lamp of uniform radiance."""

    centre: tuple
    radius: float
    radiance: np.ndarray

    def hit(self, origin, rays):
        """Distance along each ray, infinite beside the lamp."""
        to = np.asarray(self.centre) - origin
        along = rays @ to
        inside = self.radius**2 - (to @ to - along**2)
        is_hit = (inside > 0) & (along > 0)
        return np.where(is_hit, along - np.sqrt(np.maximum(inside, 0)), np.inf)

    def reach(self, origin):
        """Angle from the centre to the rim, in radians."""
        return np.arcsin(self.radius / np.linalg.norm(np.asarray(self.centre) - origin))

    def irradiance(self, points, normals):
        """Irradiance of (n, 3) points with (n, 3) normals, in closed form."""
        to = np.asarray(self.centre) - points
        distance = np.linalg.norm(to, axis=1)
        cosine = np.maximum((to * normals).sum(1), 0) / distance
        return (np.pi * self.radius**2 * cosine / distance**2)[:, None] * self.radiance

    def probe(self, point, normals):
        """Irradiance of a white ball at a point, in closed form."""
        to = np.asarray(self.centre) - point
        distance = np.linalg.norm(to)
        shine = np.pi * self.radiance * (self.radius / distance) ** 2
        light = [to / distance], [shine], [np.arcsin(self.radius / distance)]
        return kernels.rig_irradiance(normals, np.zeros(3), *light)


@dataclass(frozen=True)
class Panel:
    """Rectangle or ellipse of half axes `u` and `v`, which shines along u x v."""

    centre: tuple
    u: tuple
    v: tuple
    radiance: np.ndarray
    is_disc: bool = False
    is_window: bool = False

    @property
    def normal(self):
        across = np.cross(self.u, self.v)
        return across / np.linalg.norm(across)

    def hit(self, origin, rays):
        """Distance along each ray, infinite beside the panel."""
        to = np.asarray(self.centre) - origin
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = (to @ self.normal) / (rays @ self.normal)
            off = rays * distance[..., None] - to
            a = off @ np.asarray(self.u) / np.dot(self.u, self.u)
            b = off @ np.asarray(self.v) / np.dot(self.v, self.v)
            inside = a**2 + b**2 <= 1 if self.is_disc else (abs(a) <= 1) & (abs(b) <= 1)
        return np.where(inside & (distance > 0), distance, np.inf)

    def reach(self, origin):
        """Angle that holds the panel, in radians."""
        extent = np.linalg.norm(self.u) + np.linalg.norm(self.v)
        return np.arctan(extent / np.linalg.norm(np.asarray(self.centre) - origin)) + 0.1

    def parts(self, number):
        """Points of the panel, and the area of each."""
        steps = (np.arange(number) + 0.5) / number * 2 - 1
        a, b = (each.ravel() for each in np.meshgrid(steps, steps))
        inside = a**2 + b**2 <= 1 if self.is_disc else np.ones(len(a), bool)
        area = 4 * np.linalg.norm(np.cross(self.u, self.v)) * (np.pi / 4 if self.is_disc else 1)
        points = np.asarray(self.centre) + a[inside, None] * self.u + b[inside, None] * self.v
        return points, area / inside.sum()

    def irradiance(self, points, normals):
        """Irradiance of (n, 3) points with (n, 3) normals, by 3 x 3 parts."""
        total = np.zeros(len(points))
        centres, area = self.parts(3)
        for centre in centres:
            to = centre - points
            square = (to**2).sum(1)
            there = np.maximum(-(to @ self.normal), 0)
            total += np.maximum((to * normals).sum(1), 0) * there * area / (square**2 + area**2)
        return total[:, None] * self.radiance

    def probe(self, point, normals):
        """Irradiance of a white ball at a point, by 128 x 128 parts."""
        centres, area = self.parts(128)
        to = centres - point
        square = (to**2).sum(1)
        weight = np.maximum(-(to @ self.normal), 0) * area / square**2
        return (np.maximum(normals @ to.T, 0) @ weight)[:, None] * self.radiance


@dataclass(frozen=True)
class Room:
    """Box with lamps and furniture, around the camera."""

    low: np.ndarray
    high: np.ndarray
    lamps: tuple
    boxes: tuple = ()
    texture: float = 0.1

    def walls(self, origin, rays):
        """Distance, axis of the normal, and its sign, of the walls and the furniture."""
        with np.errstate(divide="ignore", invalid="ignore"):
            each = np.where(rays > 0, (self.high - origin) / rays, (self.low - origin) / rays)
        each[rays == 0] = np.inf
        axis = each.argmin(-1)
        distance = np.take_along_axis(each, axis[..., None], -1)[..., 0]
        for low, high in self.boxes:
            with np.errstate(divide="ignore", invalid="ignore"):
                first, last = (low - origin) / rays, (high - origin) / rays
            near, far = np.fmin(first, last), np.fmax(first, last)
            enter = near.max(-1)
            front = (enter > 0) & (enter < far.min(-1)) & (enter < distance)
            axis = np.where(front, near.argmax(-1), axis)
            distance = np.where(front, enter, distance)
        sign = -np.sign(np.take_along_axis(rays, axis[..., None], -1)[..., 0])
        return distance, axis, sign

    def wall_radiance(self, points, axis, sign):
        """Radiance of points on walls, (n, 3): the lamps once, an even part, and a texture."""
        normals = np.zeros(points.shape)
        normals[np.arange(len(axis)), axis] = sign
        light = sum(lamp.irradiance(points, normals) for lamp in self.lamps)
        place = (points - self.low) / (self.high - self.low)
        even = 0.6 + 0.3 * place @ [0.3, 0.5, 0.2]
        wave = np.sin(points @ [3.1, 1.7, 2.3]) * np.sin(points @ [-1.9, 4.2, 1.3])
        return ALBEDO[axis] / np.pi * (light + even[:, None]) * (1 + self.texture * wave)[:, None]

    def panorama(self, height, origin=(0, 0, 0), *, shine=1.0):
        """Map and distance at the centres of its pixels; `shine` multiplies the lamps."""
        origin = np.asarray(origin, float)
        rays = kernels.pixel_directions(height, 2 * height)
        distance, axis, sign = (each.ravel() for each in self.walls(origin, rays))
        points = origin + rays.reshape(-1, 3) * distance[:, None]
        radiance = self.wall_radiance(points, axis, sign).reshape(rays.shape)
        distance = distance.reshape(rays.shape[:2])
        for lamp in self.lamps:
            distance = self._draw(lamp, shine, origin, rays, radiance, distance)
        return radiance.astype(np.float32), distance

    def _draw(self, lamp, shine, origin, rays, radiance, distance):
        """Add a lamp by 4 x 4 samples of each pixel, and return the distance with it."""
        towards = np.asarray(lamp.centre) - origin
        cover = supersample(
            len(rays),
            towards / np.linalg.norm(towards),
            np.rad2deg(lamp.reach(origin)),
            lambda some: np.isfinite(lamp.hit(origin, some)),
        )[..., None]
        radiance += cover * (shine * lamp.radiance - radiance)
        hit = lamp.hit(origin, rays)
        shown = np.inf if getattr(lamp, "is_window", False) else hit
        return np.where(hit < distance + 1e-9, shown, distance)

    def probe(self, point, normals):
        """Irradiance of a white ball at a point: walls by a map, lamps in closed form."""
        radiance, _ = self.panorama(128, point, shine=0.0)
        return kernels.irradiance(radiance, normals) + sum(
            lamp.probe(np.asarray(point, float), normals) for lamp in self.lamps
        )


@cache
def room(kind):
    """One of five rooms of 6 x 3 x 5 m, with the camera in the middle."""
    pendants = (
        Ball((-1.6, 0.8, -1.3), 0.10, 60 * WARM),
        Ball((1.8, 0.7, 1.4), 0.12, 50 * COLD),
        Ball((1.6, -0.3, -1.6), 0.09, 40 * WARM),
        Ball((-2.2, -0.6, 1.1), 0.10, 30 * WHITE),
    )
    lamps = {
        "pendants": pendants,
        "panel": (
            Panel((1.2, 1.495, -0.5), (0.6, 0, 0), (0, 0, 0.3), 18 * WHITE),
            Panel((-2.995, 0.1, 0.1), (0, 0.6, 0), (0, 0, 0.7), 12 * COLD),
            Ball((1.9, -0.4, 1.7), 0.10, 50 * WARM),
            Ball((-0.8, 1.35, 1.5), 0.08, 40 * WHITE),
        ),
        "downlights": (
            *(
                Panel((x, 1.495, z), (0.1, 0, 0), (0, 0, 0.1), 70 * WHITE, is_disc=True)
                for x in (-2.0, 0.1, 2.0)
                for z in (-1.3, 1.3)
            ),
            Ball((2.2, -0.2, 0.1), 0.11, 35 * WARM),
        ),
        "hole": (
            Ball((1.8, 0.8, -1.3), 0.10, 25 * WARM),
            Ball((-1.0, -0.5, 1.8), 0.09, 25 * WARM),
            Panel((-2.998, 0.1, 0.0), (0, 0.6, 0), (0, 0, 0.9), 5 * COLD, is_window=True),
        ),
        "furnished": pendants,
    }[kind]
    boxes = (
        ((-1.0, -1.5, -2.1), (-0.2, 0.2, -1.6)),
        ((0.4, -0.8, 1.1), (1.6, -0.75, 1.9)),
        ((2.4, -1.5, -1.0), (2.95, 0.5, 0.1)),
    )
    solids = tuple((np.array(a), np.array(b)) for a, b in boxes) if kind == "furnished" else ()
    return Room(np.array([-3, -1.5, -2.5]), np.array([3, 1.5, 2.5]), lamps, solids)


@cache
def seen(kind, height=256):
    """Map and distance of a room at its camera, made once for all tests; read-only."""
    arrays = room(kind).panorama(height)
    for array in arrays:
        array.flags.writeable = False
    return arrays


#: Points 0.5, 1 and 2 m from the camera, two of each.
OFFSETS = [
    (0.5, 0, 0),
    (-0.3, 0.2, 0.35),
    (0.8, 0, 0.6),
    (-0.7, -0.5, -0.5),
    (1.9, 0, 0.62),
    (-1.7, -0.5, 0.93),
]
