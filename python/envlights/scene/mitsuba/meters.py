"""Irradiance meters of Mitsuba, one on each texel of a lightmap."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights.scene.surface import Surface, tangent_frames


class Meters(NamedTuple):
    """Sensors on the covered texels of a surface."""

    sensor: Any
    """Sensor of all meters, with a film of one row."""

    squares: list[Any]
    """Shapes of the meters, kept alive here because a sensor does not. No scene contains them."""


def meters(mi: Any, surface: Surface) -> Meters:
    """A small square above each covered texel, and a meter on it."""
    film = mi.load_dict(_film(1))
    # Place a square of the size of the lift in the tangent plane of each texel.
    origins, normals = surface.lifted()
    mounts = np.zeros((len(origins), 4, 4))
    mounts[:, :3, :3] = np.swapaxes(tangent_frames(normals), 1, 2) * [surface.lift, surface.lift, 1]
    mounts[:, :3, 3] = origins
    mounts[:, 3, 3] = 1
    # Load the squares, each with its meter.
    squares = [
        mi.load_dict(
            {
                "type": "rectangle",
                "to_world": mi.ScalarTransform4f(mount),
                "meter": {"type": "irradiancemeter", "film": film},
            }
        )
        for mount in mounts
    ]
    row = {"type": "batch", "film": _film(len(squares)), "sampler": {"type": "multijitter"}}
    # Batch the meters; Mitsuba takes them in the order of their names.
    named = {f"meter_{k:08}": square.sensor() for k, square in enumerate(squares)}
    return Meters(mi.load_dict({**row, **named}), squares)


def read(mi: Any, meters: Meters, scene: Any, samples: int, seed: int) -> NDArray[np.float64]:
    """Indirect irradiance of each texel, (n, 3): all bounces, without direct light."""
    paths = mi.load_dict({"type": "path", "hide_emitters": True})
    film = mi.render(scene, sensor=meters.sensor, integrator=paths, spp=samples, seed=seed)
    (row,) = np.array(film, np.float64)
    return np.asarray(row)


def _film(width: int) -> dict[str, Any]:
    box = {"type": "box"}
    return {"type": "hdrfilm", "width": width, "height": 1, "pixel_format": "rgb", "rfilter": box}
