"""An open courtyard for Mitsuba, and random outdoor rigs for it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import kernels
from envlights._common.check import count
from envlights.rigs.lights import Lights
from envlights.rigs.rig import Rig
from envlights.scene.mitsuba.renderer import mitsuba

#: Largest number of rigs, whose pairs take days to bake.
_MOST_RIGS = 20_000
#: Metres: half of the yard's width, the height of its walls, and that of the canopy.
_HALF, _WALL, _CANOPY = 4.0, 3.0, 2.2
#: Corners of the boxes, in metres.
_BOXES = {
    "low": ((-2.8, 0.0, 0.4), (-0.8, 1.0, 2.4)),
    "tall": ((0.8, 0.0, -2.6), (2.0, 2.4, -1.4)),
}
_ALBEDO = {
    "floor": (0.50, 0.46, 0.40),
    "wall_east": (0.65, 0.62, 0.55),
    "wall_north": (0.70, 0.68, 0.62),
    "wall_south": (0.60, 0.30, 0.22),
    "wall_west": (0.25, 0.45, 0.60),
    "canopy": (0.75, 0.72, 0.65),
    "low": (0.35, 0.55, 0.25),
    "tall": (0.70, 0.60, 0.30),
}


#: Centre of a rectangle, and half of each of two sides, whose cross product is the normal.
_Face = tuple[ArrayLike, NDArray[np.float64], NDArray[np.float64]]


def courtyard() -> dict[str, Any]:
    """A yard of 8 by 8 metres: a floor, four walls, two boxes and a canopy over one corner.

    Sixteen rectangles, diffuse, each with UV coordinates of its own. Needs Mitsuba.

    Returns
    -------
    dict
        Argument of `MitsubaScene` and ``mitsuba.load_dict``. +y up; without lights.

    Examples
    --------
    >>> sorted(courtyard())[:3]
    ['box_low_east', 'box_low_north', 'box_low_south']
    """
    # List the rectangles of the yard.
    w, h = _HALF, _WALL
    x, y, z = np.eye(3)
    faces: dict[str, _Face] = {
        "floor": ((0, 0, 0), w * z, w * x),
        "wall_east": ((w, h / 2, 0), w * z, h / 2 * y),
        "wall_north": ((0, h / 2, w), -w * x, h / 2 * y),
        "wall_south": ((0, h / 2, -w), w * x, h / 2 * y),
        "wall_west": ((-w, h / 2, 0), -w * z, h / 2 * y),
        "canopy": ((-w / 2, _CANOPY, -w / 2), w / 2 * x, w / 2 * z),
    }
    # Describe them, and those of the boxes, to Mitsuba.
    scene: dict[str, Any] = {"type": "scene"}
    with mitsuba() as mi:
        for name, face in faces.items():
            scene[name] = _rectangle(mi, face, _ALBEDO[name])
        for box, corners in _BOXES.items():
            for side, face in _box(*np.array(corners)).items():
                scene[f"box_{box}_{side}"] = _rectangle(mi, face, _ALBEDO[box])
    return scene


def rigs(number: int, seed: int = 0) -> list[Rig]:
    """Random outdoor rigs: a smooth sky of random colours, and one to three lights.

    The lights are above the horizon; the sky is nowhere negative.

    Parameters
    ----------
    number : int
        Number of rigs, at most 20 000.
    seed : int
        Seed of the rigs; the same seed gives the same rigs.

    Returns
    -------
    list of Rig

    Examples
    --------
    >>> [len(rig.lights) for rig in rigs(4)]
    [3, 2, 3, 1]
    """
    rng = np.random.default_rng(count("seed", seed))
    return [_random_rig(rng) for _ in range(count("number", number, least=1, most=_MOST_RIGS))]


def _random_rig(rng: np.random.Generator) -> Rig:
    lights = rng.integers(1, 4)
    # The upper half of the sphere is the half of the unit square with u < 1/2.
    directions = kernels.uniform_sphere(rng.random((lights, 2)) * [0.5, 1])
    irradiance = rng.gamma(2.0, 1.0, (lights, 1)) * rng.uniform(0.5, 1.5, (lights, 3))
    return Rig(_smooth_sky(rng), Lights(directions, irradiance), error=0.0)


def _smooth_sky(rng: np.random.Generator) -> NDArray[np.float64]:
    """Harmonics of three lobes (1 + cos)^2 of random direction and colour: nowhere negative."""
    at, _ = kernels.icosphere(320)
    axes = kernels.uniform_sphere(rng.random((3, 2)))
    radiance = (1 + at @ axes.T) ** 2 @ rng.gamma(1.0, 0.1, (3, 3))
    # Such lobes are polynomials of the second degree: nine harmonics hold them exactly.
    return np.asarray(
        np.linalg.lstsq(kernels.harmonic_radiance(at), radiance, rcond=None)[0], np.float64
    )


def _box(least: NDArray[np.float64], most: NDArray[np.float64]) -> dict[str, _Face]:
    """Faces of a box, without the face on the floor."""
    centre, half = (least + most) / 2, np.diag((most - least) / 2)
    x, y, z = half
    return {
        "east": (centre + x, -z, y),
        "north": (centre + z, x, y),
        "south": (centre - z, -x, y),
        "top": (centre + y, z, x),
        "west": (centre - x, z, y),
    }


def _rectangle(mi: Any, face: _Face, albedo: tuple[float, float, float]) -> dict[str, Any]:
    """A rectangle with the same material on both sides."""
    centre, right, up = face
    normal = np.cross(right, up)
    placed = np.eye(4)
    placed[:3] = np.stack([right, up, normal / np.linalg.norm(normal), centre], axis=1)
    diffuse = {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(albedo)}}
    return {
        "type": "rectangle",
        "to_world": mi.ScalarTransform4f(placed),
        "bsdf": {"type": "twosided", "material": diffuse},
    }
