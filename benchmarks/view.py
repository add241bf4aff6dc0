"""Pictures of the view against Mitsuba: a ball and a box on the floor of a map.

The truth is path-traced under the map itself, with eight bounces. Figures are relative RMS errors
of linear radiance over four views, their worst view, and the noise of the truth, which is taken out
by two independent renders. The floor has the mean reflectance of the floor of the map, or its
picture as texture. Each pixel of the pictures is the mean of 6 by 6 points.

Half an hour. Usage: python benchmarks/view.py MAP... (`hall` is the generated hall); `--samples`
sets the paths through each pixel.
"""

import argparse
from typing import NamedTuple

import numpy as np

import envlights as el
from envlights.scene import closed_form as shadings
from envlights.scene.camera import Camera
from envlights.scene.closed_form import closed_form
from envlights.scene.mitsuba.path_traced import SolidsOnFloor, Still, path_traced
from envlights.scene.panorama_floor import floor_albedo, floor_texture

SOLIDS = (
    el.scene.Ball((-0.65, 0.5, 0.1), 0.5),
    el.scene.Box((0.65, 0.4, -0.1), (0.4, 0.4, 0.4), np.pi / 6),
)
ALBEDO = np.full((2, 3), 0.7)
#: Paths through each pixel; four times as many are traced, because the light is a map.
SAMPLES = 72
#: Points of a pixel along each side.
PER_SIDE = 6
VIEWS = 4


class Method(NamedTuple):
    """One way to draw the picture."""

    name: str
    shading: object
    floor: bool = True
    sizes: bool = True
    lights: int = 4

    def rig(self, env):
        """Rig that is drawn."""
        return el.fit(env, self.lights, floor=self.floor, sizes=self.sizes)


METHODS = [
    Method("no shadows", shadings.shade_without_shadows, floor=False, sizes=False),
    Method("hard shadows, no contact (paper)", shadings.shade_with_hard_shadows, False, False),
    Method("discs, contact", shadings.shade_directly, floor=False),
    Method("discs, contact", shadings.shade_directly),
    Method("points, contact, reflected light", shadings.shade, sizes=False),
    Method("discs, contact, reflected light", shadings.shade, floor=False),
    Method("discs, contact, reflected light", shadings.shade),
    Method("discs, contact, reflected light", shadings.shade, lights=1),
    Method("discs, contact, reflected light", shadings.shade, lights=8),
]


def views(env):
    """Cameras all around, the first beside the brightest light."""
    x, _, z = el.fit(env, 4, floor=True).lights.direction[0]
    azimuths = np.arctan2(x, z) + 1.9 + np.arange(VIEWS) * 2 * np.pi / VIEWS
    up, distance = 0.42, 4.6
    flat = distance * np.cos(up)
    eyes = [(flat * np.sin(a), 0.3 + distance * np.sin(up), flat * np.cos(a)) for a in azimuths]
    return [Camera(eye, (0.0, 0.3, 0.0), 40.0, 160, 90) for eye in eyes]


def errors(method, rig, scene, cameras, truths):
    """Mean square error over the views, and that of the worst view."""
    squares = []
    for camera, truth in zip(cameras, truths, strict=True):
        image = closed_form(rig, scene, camera, PER_SIDE, method.shading)
        squares.append(Still(image, image).square_error(truth))
    return max(np.mean(squares), 0), max(*squares, 0)


def table(name, samples):
    env = el.EnvMap(el.synthetic.hall(512).radiance) if name == "hall" else el.EnvMap.open(name)
    cameras = views(env)
    mean = SolidsOnFloor(SOLIDS, ALBEDO, floor_albedo(env))
    textured = mean._replace(texture=floor_texture(env))
    for scene, methods in ((mean, METHODS), (textured, METHODS[1:2] + METHODS[6:7])):
        truths = [path_traced(env, scene, c, samples, seed) for seed, c in enumerate(cameras)]
        noise = np.sqrt(np.mean([truth.noise**2 for truth in truths]))
        floor = "mean" if scene.texture is None else "texture"
        for method in methods:
            mean_square, worst = errors(method, method.rig(env), scene, cameras, truths)
            print(
                f"{name[-24:]:<26}{floor:<9}{method.name:<34}{method.lights:>2} lights, floor="
                f"{method.floor!s:<6}{100 * np.sqrt(mean_square):>7.2f} %, worst"
                f"{100 * np.sqrt(worst):>7.2f} %, noise{100 * noise:>6.2f} %",
                flush=True,
            )


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("maps", nargs="+")
    parser.add_argument("--samples", type=int, default=SAMPLES)
    asked = parser.parse_args()
    for each in asked.maps:
        table(each, asked.samples)
