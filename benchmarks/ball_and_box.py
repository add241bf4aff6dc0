"""Scene of `plot.scene` from all sides, because the shadows from one side depend on chance."""

import numpy as np

from envlights.scene.mitsuba.path_traced import Still
from envlights.scene.still_life import still_life

#: From where the scene is seen, in radians.
AZIMUTHS = np.arange(8) * np.pi / 4
#: Paths through each pixel for each light; four times as many under a map.
SAMPLES = 128


def from_all_sides(light, samples=SAMPLES):
    """Images under a map or a rig, (sides, height, width, 3), twice with independent noise."""
    sides = [still_life(light, side, samples, seed) for seed, side in enumerate(AZIMUTHS)]
    return Still(*np.swapaxes(sides, 0, 1))


def of_side(stills, side):
    """The images from one side alone."""
    return Still(*(image[side] for image in stills))
