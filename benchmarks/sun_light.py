"""Light of a sky with a disc, against its HDR map: on a white probe, and around a ball."""

from functools import cache

import numpy as np
from clipped_maps import reduce_width

from envlights.kernels.image import LUMINANCE, uv_to_pixel
from envlights.kernels.sphere import direction_to_uv, pixel_directions, pixel_solid_angles

#: Columns of the maps for light.
COLUMNS = 256


@cache
def matrices():
    """Weights of the pixels for 200 normals, and for points of a floor around a ball on it."""
    directions = pixel_directions(COLUMNS // 2, COLUMNS).reshape(-1, 3)
    solid_angles = pixel_solid_angles(COLUMNS // 2, COLUMNS).reshape(-1)
    normals = np.random.default_rng(1).normal(size=(200, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    probe = np.maximum(normals @ directions.T, 0) * solid_angles
    side = np.linspace(-3.5, 3.5, 22)
    points = np.array([(x, 0, z) for z in side for x in side if np.hypot(x, z) > 0.3])
    to_ball = np.array([0, 1.0, 0]) - points
    along = to_ball @ directions.T
    hidden = (along > 0) & ((to_ball**2).sum(axis=1)[:, None] - along**2 < 1)
    shadow = ~hidden * np.maximum(directions[:, 1], 0) * solid_angles
    return {"probe": probe.astype(np.float32), "shadow": shadow.astype(np.float32)}


def light_errors(env, repaired, sun, truth):
    """Relative RMS errors by ("probe" or "shadow", "raw", "repaired" or "disc")."""
    maps = {"raw": env.radiance, "repaired": repaired.radiance, "truth": truth}
    maps = {name: reduce_width(radiance, COLUMNS) @ LUMINANCE for name, radiance in maps.items()}
    disc = reduce_width(sun.sky(env.radiance), COLUMNS) @ LUMINANCE
    uv = direction_to_uv(sun.direction[None])
    row, column = uv_to_pixel(uv, *disc.shape)[0]
    disc[row, column] += sun.irradiance @ LUMINANCE / pixel_solid_angles(*disc.shape)[row, column]
    maps["disc"] = disc
    errors = {}
    for what, matrix in matrices().items():
        light = {name: matrix @ image.reshape(-1) for name, image in maps.items()}
        for name in ("raw", "repaired", "disc"):
            errors[what, name] = error(light[name], light["truth"])
    return errors


def error(one, truth):
    """Relative RMS error at the best common scale."""
    one = one * (one @ truth) / (one @ one)
    return float(np.linalg.norm(one - truth) / np.linalg.norm(truth))
