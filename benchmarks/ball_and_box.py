"""A ball and a box on a floor, as Mitsuba renders them under maps and lights.

The scene is turned several times, with its two views, as it is chance where a shadow falls in one.
Each image is rendered twice, and the squared error is the mean product of both differences, so that
noise, which they do not share, does not count.
"""

import numpy as np
from tests.reference.mitsuba_images import rgb

from envlights.scene.renderer import mitsuba

WIDTH, HEIGHT = 96, 64
VIEWS = ((1.2, 1.9, -3.6), (-1.2, 1.9, 3.6))
#: Turns of the scene, with its views, around the vertical, in degrees.
TURNS = (0, 90, 180, 270)
#: Paths for each pixel of an image: under a map, under the ambient term, under a point light, under
#: a disc.
MAP_PATHS, AMBIENT_PATHS, POINT_PATHS, DISC_PATHS = 256, 128, 16, 64
#: Segments of a path: to what the camera sees, to what lights that, and to its light.
DEPTH = 3


def error(both, truth):
    """Relative RMS error of two images of equal expectation against two others."""
    one, two = both - truth
    return np.sqrt(max(np.vdot(one, two), 0) / np.vdot(*truth))


def under_map(env):
    """Images under a map."""
    return images({"type": "envmap", "bitmap": as_mitsuba_takes_it(env)}, MAP_PATHS)


def under_ambient():
    """Images under an environment of radiance 1."""
    return images({"type": "constant", "radiance": rgb([1.0] * 3)}, AMBIENT_PATHS)


def under_rig(rig, under_one):
    """Images under a rig, each emitter alone: drawing one for each path would add noise.

    `under_one` are those of `under_ambient`.
    """
    lights = rig.lights
    total = under_one * rig.ambient
    for each in zip(lights.direction, lights.irradiance, lights.angular_radius, strict=True):
        total += under_light(*each)
    return total


def under_light(direction, irradiance, radius):
    """Images under a disc, or under a point where the `radius` is 0."""
    if radius == 0:
        light = {"type": "directional", "direction": list(-direction)}
        return images({**light, "irradiance": rgb(irradiance)}, POINT_PATHS)
    return images({"type": "envmap", "bitmap": disc(direction, irradiance, radius)}, DISC_PATHS)


def images(emitter, paths):
    """Two renders of all turns and views, (2, turns, views, HEIGHT, WIDTH, 3)."""
    with mitsuba() as mi:
        if "bitmap" in emitter:
            emitter = {**emitter, "bitmap": mi.Bitmap(emitter["bitmap"])}
        given = {"integrator": mi.load_dict({"type": "path", "max_depth": DEPTH}), "spp": paths}
        renders = []
        for turn in TURNS:
            turned = mi.ScalarTransform4f().rotate([0, 1, 0], turn)
            # Mitsuba 3.9.1 merges shapes of one material, and the bounds of its scene then leave
            # the floor out: light from below would pass through it.
            scene = mi.load_dict({**objects(turned), "emitter": emitter}, optimize=False)
            sensors = [sensor(mi, turned, view) for view in VIEWS]
            renders.append(
                [
                    [mi.render(scene, sensor=eye, seed=seed, **given) for eye in sensors]
                    for seed in (1, 2)
                ]
            )
        return np.array(renders, dtype=float).swapaxes(0, 1)


def objects(turned):
    """A ball and a box on a floor that hides what is below the horizon."""
    grey = {"type": "diffuse", "reflectance": rgb([0.7] * 3)}
    lying = turned.rotate([1, 0, 0], -90).scale(200)
    ball = turned.translate([-0.6, 0.5, 0.1]).scale(0.5)
    box = turned.translate([0.6, 0.35, -0.1]).rotate([0, 1, 0], 25).scale(0.35)
    return {
        "type": "scene",
        "floor": {"type": "rectangle", "to_world": lying, "bsdf": grey},
        "ball": {"type": "sphere", "to_world": ball, "bsdf": grey},
        "box": {"type": "cube", "to_world": box, "bsdf": grey},
    }


def sensor(mi, turned, origin):
    eye = mi.ScalarTransform4f().look_at(origin=list(origin), target=[0, 0.3, 0], up=[0, 1, 0])
    size = {"width": WIDTH, "height": HEIGHT, "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    film = {"type": "hdrfilm", **size}
    return mi.load_dict({"type": "perspective", "fov": 34, "to_world": turned @ eye, "film": film})


def as_mitsuba_takes_it(env):
    """Radiance with the first and the last row on the poles; columns are cell-centred for both."""
    height = env.height
    at = np.linspace(0, height, height) - 0.5
    before = np.clip(np.floor(at).astype(int), 0, height - 2)
    share = np.clip(at - before, 0, 1)[:, None, None].astype(np.float32)
    return (1 - share) * env.radiance[before] + share * env.radiance[before + 1]


def disc(direction, irradiance, radius, rows=512):
    """A disc of even radiance as a map of Mitsuba, whose first and last row lie on the poles.

    Its vector irradiance is that of the light: points on a grid of the disc are shared among the
    four pixels around each, which keeps sum and middle.
    """
    # Spread points evenly over the disc.
    count = 200_000
    i = np.arange(count) + 0.5
    cosine = 1 - (1 - np.cos(radius)) * i / count
    turn = np.pi * (3 - np.sqrt(5)) * i
    s = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    s /= np.linalg.norm(s)
    across = np.cos(turn)[:, None] * s + np.sin(turn)[:, None] * np.cross(direction, s)
    points = cosine[:, None] * direction + np.sqrt(1 - cosine**2)[:, None] * across
    # Add each to the four pixels around it.
    columns = 2 * rows
    x = np.arctan2(points[:, 0], -points[:, 2]) / (2 * np.pi) * columns - 0.5
    y = np.arccos(np.clip(points[:, 1], -1, 1)) / np.pi * (rows - 1)
    x0, y0 = np.floor(x).astype(int), np.minimum(np.floor(y).astype(int), rows - 2)
    flux = np.zeros((rows, columns))
    for dx, dy in np.ndindex(2, 2):
        share = np.abs(1 - dx - (x - x0)) * np.abs(1 - dy - (y - y0))
        np.add.at(flux, (y0 + dy, (x0 + dx) % columns), share)
    # Divide by the solid angle of each pixel: rows on the poles have half of a row.
    edges = np.clip((np.arange(rows + 1) - 0.5) * np.pi / (rows - 1), 0, np.pi)
    solid_angle = -np.diff(np.cos(edges))[:, None] * (2 * np.pi / columns)
    # Of radiance 1 / (pi sin^2 radius) the disc has the irradiance 1, and this flux.
    whole = 2 * np.pi * (1 - np.cos(radius)) / (np.pi * np.sin(radius) ** 2)
    return ((flux * whole / count / solid_angle)[..., None] * irradiance).astype(np.float32)
