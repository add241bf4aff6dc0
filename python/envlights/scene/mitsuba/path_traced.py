"""Images of solids on a floor by Mitsuba, twice with independent noise."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights.environment.envmap import EnvMap
from envlights.kernels.solids import Ball, Box, Polyhedron, Solid
from envlights.rigs.rig import Rig
from envlights.scene.camera import Camera
from envlights.scene.mitsuba.emitters import emitters, environment
from envlights.scene.mitsuba.renderer import film, mitsuba

#: Paths under a map for each under a light: a map has more noise than a light alone.
_MAP_PATHS = 4
#: Half of the side of the floor, in units of the scene.
FLOOR_EXTENT = 40.0
#: Height of a textured square above the floor, so that rays meet it first.
_LIFT = 1e-4


class Still(NamedTuple):
    """An image, twice, with independent noise."""

    one: NDArray[np.float64]
    """Radiance, (height, width, 3)."""

    two: NDArray[np.float64]
    """Radiance from independent paths, (height, width, 3)."""

    def error(self, truth: Still) -> float:
        """Relative RMS difference from `truth`, without the noise of either.

        Noise cancels on average in the product of two differences from independent paths.
        """
        return float(np.sqrt(max(self.square_error(truth), 0.0)))

    def square_error(self, truth: Still) -> float:
        """Square of `error`; below zero if noise is larger than the difference."""
        difference = float(((self.one - truth.one) * (self.two - truth.two)).sum())
        size = float((truth.one * truth.two).sum())
        return difference / size if size > 0 else 0.0

    @property
    def image(self) -> NDArray[np.float64]:
        """The mean of both."""
        return (self.one + self.two) / 2

    @property
    def noise(self) -> float:
        """Relative standard error of the mean: the norm of the noise over that of the image."""
        size = np.linalg.norm(self.image)
        return float(np.linalg.norm(self.one - self.two) / 2 / size) if size else 0.0


class Texture(NamedTuple):
    """Reflectance of a square of the floor around the origin."""

    albedo: NDArray[np.float64]
    """Pixels, (n, n, 3): columns towards +x, rows towards +z."""

    half_width: float
    """Distance of the edges from the origin."""

    def at(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Reflectance at points of the square, (n, 3), by bilinear filtering."""
        last = len(self.albedo) - 1
        pixels = (points[:, [2, 0]] / self.half_width + 1) * len(self.albedo) / 2 - 0.5
        first = np.clip(np.floor(pixels), 0, last - 1).astype(int)
        weights = np.clip(pixels - first, 0, 1)
        total = np.zeros((len(points), 3))
        for row in (0, 1):
            for column in (0, 1):
                both = np.abs([1 - row, 1 - column] - weights).prod(axis=1)
                total += both[:, None] * self.albedo[first[:, 0] + row, first[:, 1] + column]
        return total

    def covers(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """True for each point within the square, (n,)."""
        within: NDArray[np.bool_] = np.abs(points[:, ::2]).max(axis=1) < self.half_width
        return within


class SolidsOnFloor(NamedTuple):
    """Diffuse solids on a diffuse floor at the height 0."""

    solids: tuple[Solid, ...]
    """Balls and convex polyhedra."""

    albedo: NDArray[np.float64]
    """Reflectance of each solid, (n, 3)."""

    floor_albedo: NDArray[np.float64]
    """Mean reflectance of the floor, (3,)."""

    texture: Texture | None = None
    """Reflectance of the floor around the origin, if it differs from the mean."""

    def albedo_at(self, points: NDArray[np.float64], own: NDArray[np.int64]) -> NDArray[np.float64]:
        """Reflectance at points of surfaces, (n, 3); `own` is -1 on the floor."""
        reflectance = np.concatenate([self.albedo, [self.floor_albedo]])[own]
        if self.texture is not None:
            textured = np.flatnonzero((own < 0) & self.texture.covers(points))
            reflectance[textured] = self.texture.at(points[textured])
        return reflectance


def path_traced(
    light: EnvMap | Rig,
    scene: SolidsOnFloor,
    camera: Camera,
    samples: int = 128,
    seed: int = 0,
    bounces: int = 8,
) -> Still:
    """Render solids on a floor under a map or a rig.

    `samples` are the paths through each pixel for each light, half of them for each of the two
    images; a map gets four times as many. One of `bounces` is the direct light alone.
    """
    with mitsuba() as mi:
        shapes = {**_shapes(mi, scene), "eye": _sensor(mi, camera)}
        return render(mi, light, shapes, samples, seed, bounces)


def render(
    mi: Any, light: EnvMap | Rig, shapes: dict[str, Any], samples: int, seed: int, bounces: int
) -> Still:
    """Render shapes, with a sensor among them.

    Lights and ambient term are rendered one at a time and added, because Mitsuba picks one emitter
    at random for each path, and that pick is most of the noise of many emitters.
    """
    seeds = iter(np.random.SeedSequence(seed).generate_state(2 * (2 + _lights(light))))
    images = [np.zeros(()), np.zeros(())]
    paths = mi.load_dict({"type": "path", "max_depth": 1 + bounces})
    for weight, lit, effort in _parts(light):
        scene = mi.load_dict({"type": "scene", **shapes, **lit}, optimize=False)
        # The sampler rounds up to a square, with a warning.
        spp = int(np.ceil(np.sqrt(effort * samples / 2))) ** 2
        for half in (0, 1):
            own = int(next(seeds))
            image = np.array(mi.render(scene, integrator=paths, spp=spp, seed=own))
            images[half] = images[half] + weight * image.astype(np.float64)
    return Still(*images)


def _lights(light: EnvMap | Rig) -> int:
    return len(light.lights) if isinstance(light, Rig) else 0


def _parts(light: EnvMap | Rig) -> list[tuple[float, dict[str, Any], int]]:
    """Weight, emitters and effort of each render."""
    if isinstance(light, EnvMap):
        return [(1.0, {"map": environment(light)}, _MAP_PATHS)]
    dark, lights = np.zeros(3), light.lights
    rigs = [Rig(dark, lights[j : j + 1], 0.0) for j in range(len(lights))]
    rigs.append(Rig(light.ambient, lights[:0], 0.0))
    return [(weight, lit, 1) for rig in rigs for weight, lit in emitters(rig)]


def _shapes(mi: Any, scene: SolidsOnFloor) -> dict[str, Any]:
    shapes = {"floor": _square(mi, FLOOR_EXTENT, diffuse(scene.floor_albedo))}
    if scene.texture is not None:
        # The rows of Mitsuba's images go towards -z.
        flipped = np.ascontiguousarray(scene.texture.albedo[::-1], np.float32)
        image = {"type": "bitmap", "bitmap": mi.Bitmap(flipped), "raw": True, "wrap_mode": "clamp"}
        material = {"type": "diffuse", "reflectance": image}
        shapes["texture"] = _square(mi, scene.texture.half_width, material, _LIFT)
    for row, (solid, albedo) in enumerate(zip(scene.solids, scene.albedo, strict=True)):
        shapes[f"solid_{row}"] = _shape(mi, solid, diffuse(albedo))
    return shapes


def _square(mi: Any, half: float, material: dict[str, Any], height: float = 0.0) -> dict[str, Any]:
    """A horizontal square around the origin."""
    place = mi.ScalarTransform4f().translate([0, height, 0]).scale(half).rotate([1, 0, 0], -90)
    return {"type": "rectangle", "to_world": place, "bsdf": material}


def diffuse(albedo: NDArray[np.float64]) -> dict[str, Any]:
    """A diffuse material of one reflectance."""
    return {"type": "diffuse", "reflectance": {"type": "rgb", "value": np.asarray(albedo).tolist()}}


def _shape(mi: Any, solid: Solid, material: dict[str, Any]) -> Any:
    if isinstance(solid, Ball):
        return {"type": "sphere", "center": solid.centre, "radius": solid.radius, "bsdf": material}
    return _polyhedron(mi, solid, material)


def _polyhedron(mi: Any, solid: Box | Polyhedron, material: dict[str, Any]) -> Any:
    """A mesh of the triangles between the first vertex of each face and its other edges."""
    vertices = np.asarray(solid.vertices, np.float32)
    fans = [(face[0], *edge) for face in solid.faces for edge in pairwise(face[1:])]
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict({"type": "twosided", "nested": material})
    mesh = mi.Mesh("solid", len(vertices), len(fans), props=properties)
    values = mi.traverse(mesh)
    values["vertex_positions"] = vertices.ravel()
    values["faces"] = np.array(fans, np.uint32).ravel()
    values.update()
    return mesh


def _sensor(mi: Any, camera: Camera) -> dict[str, Any]:
    looks = mi.ScalarTransform4f().look_at(list(camera.eye), list(camera.target), [0, 1, 0])
    return {
        "type": "perspective",
        "fov": camera.fov,
        "to_world": looks,
        "film": film(camera.width, camera.height),
        "sampler": {"type": "multijitter"},
    }
