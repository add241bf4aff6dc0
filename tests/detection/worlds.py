"""Maps and lights that several tests of detection use."""

from functools import cache

import numpy as np

import envlights as el
from envlights.synthetic import Disc, scene, suite

SKY = np.array([0.2, 0.3, 0.4])


def world(shapes, height=128, background=SKY):
    """A map of shapes before an even sky."""
    return el.EnvMap(scene(height, background=background, shapes=shapes).radiance)


@cache
def three():
    """A map with three lamps of different radiance."""
    lamps = [((1, 0.4, 0.3), 90.0), ((0, 0.2, -1), 60.0), ((-1, 0.1, 0.2), 30.0)]
    return world([Disc(place, 3.0, (peak,) * 3) for place, peak in lamps])


@cache
def family(name):
    """Every fourth of the maps that no threshold was chosen by."""
    make = getattr(suite, name)
    return [make(seed) for seed in suite.EVALUATION[::4]]


def members(lights):
    """The pixels of each light."""
    pixels, light = lights.members.pixel, lights.members.light
    return [set(map(tuple, pixels[light == i].tolist())) for i in range(len(lights))]


def one_pixel_suns(count, seed):
    """Far enough apart for no gap; fluxes in a ratio of up to 1000."""
    rng = np.random.default_rng(seed)
    radiance = np.full((256, 512, 3), 1e-4, np.float32)
    cells = rng.choice(32 * 14, count, replace=False)
    rows, columns = 16 + cells // 32 * 16, cells % 32 * 16
    radiance[rows, columns] = 10 ** rng.uniform(0, 3, (count, 1))
    return radiance
