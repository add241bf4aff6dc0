"""A ball and a box on a floor, rendered by Mitsuba: error of the image under a rig.

The truth is the image under the map itself: shadows and one bounce, from two views. The scene is
turned four times, as it is chance where a shadow falls in one; `worst` is the ratio of the worst
turn. Each image is rendered twice, and the squared error is the mean product of both differences,
so that noise, which they do not share, does not count. `noise` is that of the mean of the two
images, relative RMS.

Some minutes. Usage: python benchmarks/fit_floor.py MAP...
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
from tests.reference.mitsuba_images import noise_of, rgb

import envlights as el
from envlights.scene.renderer import mitsuba

LIGHTS = (4, 8)
WIDTH, HEIGHT = 96, 64
VIEWS = ((1.2, 1.9, -3.6), (-1.2, 1.9, 3.6))
#: Turns of the scene, with its views, around the vertical, in degrees.
TURNS = (0, 90, 180, 270)
#: Paths for each pixel of an image: under a map, under the ambient term, under one light.
MAP_PATHS, AMBIENT_PATHS, LIGHT_PATHS = 256, 128, 16
#: Segments of a path: to what the camera sees, to what lights that, and to its light.
DEPTH = 3


def table(paths):
    under_one = images({"type": "constant", "radiance": rgb([1.0] * 3)}, AMBIENT_PATHS)
    print("relative RMS error of images, fitted without a floor and over one")
    columns = f"{'without':>10}{'over':>10}{'ratio':>8}{'worst':>8}{'noise':>8}"
    print(f"{'map':<28}{'noise':>8}{'lights':>8}{columns}")
    for path in paths:
        env = el.EnvMap.open(path)
        truth = images({"type": "envmap", "bitmap": as_mitsuba_takes_it(env)}, MAP_PATHS)
        for lights in LIGHTS:
            plain, over = (
                under(el.fit(env, lights, floor=floor), under_one) for floor in (False, True)
            )
            print(row(path.stem, lights, truth, plain, over), flush=True)


def row(name, lights, truth, plain, over):
    without, with_floor = error(plain, truth), error(over, truth)
    by_turn = [
        error(over[:, k], truth[:, k]) / error(plain[:, k], truth[:, k]) for k in range(len(TURNS))
    ]
    return (
        f"{name:<28}{100 * noise_of(*truth):>6.2f} %{lights:>8}"
        f"{100 * without:>8.2f} %{100 * with_floor:>8.2f} %{with_floor / without:>8.3f}"
        f"{max(by_turn):>8.3f}{100 * noise_of(*over):>6.2f} %"
    )


def error(both, truth):
    """Relative RMS error of two images of equal expectation against two others."""
    one, two = both - truth
    return np.sqrt(max(np.vdot(one, two), 0) / np.vdot(*truth))


def under(rig, under_one):
    """Images under a rig, each emitter alone: drawing one for each path would add noise."""
    total = under_one * rig.ambient
    for direction, irradiance in zip(rig.lights.direction, rig.lights.irradiance, strict=True):
        light = {"type": "directional", "direction": list(-direction)}
        total += images({**light, "irradiance": rgb(irradiance)}, LIGHT_PATHS)
    return total


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


if __name__ == "__main__":
    table([Path(argument) for argument in sys.argv[1:]])
