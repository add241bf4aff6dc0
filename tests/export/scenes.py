"""What all exporters are tried with."""

import numpy as np

import envlights as el
from tests.helpers import NORMALS

_DIRECTIONS = [[0.6, 0.8, 0.0], [-0.48, 0.6, 0.64], [0.0, -0.28, -0.96]]
_IRRADIANCE = [[3.0, 2.0, 1.0], [0.2, 0.5, 0.9], [0.1, 0.05, 0.3]]
LIGHTS = el.Lights(_DIRECTIONS, _IRRADIANCE, [0.02, 0.3, 0.0])
POINTS = el.Lights(_DIRECTIONS, _IRRADIANCE)

_HARMONICS = np.zeros((9, 3))
_HARMONICS[0], _HARMONICS[1], _HARMONICS[3], _HARMONICS[6] = (
    1.0,
    [0.2, 0.3, 0.4],
    0.1,
    [0, 0.1, 0.2],
)

#: Without an error: nothing was fitted.
RIGS = {
    "points": el.Rig([0.1, 0.2, 0.3], POINTS, 0.0),
    "discs": el.Rig([0.1, 0.2, 0.3], LIGHTS, 0.0),
    "dark": el.Rig([0, 0, 0], LIGHTS, 0.0),
    "harmonics": el.Rig(_HARMONICS, LIGHTS, 0.0),
    "floor": el.Rig([0.1, 0.2, 0.3], POINTS, 0.0, floor=True),
    "ambient": el.Rig([0.1, 0.2, 0.3], POINTS[:0], 0.0),
}

#: Red from +x, green from +y, blue from +z.
AXES_LIGHTS = el.Lights(np.eye(3), np.eye(3))


def environment():
    """A map that has no symmetry."""
    return el.EnvMap(el.synthetic.hall(64).radiance)


def irradiance_of_points(direction, irradiance, normals=NORMALS):
    """Of lights in one direction each."""
    return np.maximum(normals @ np.transpose(direction), 0) @ np.asarray(irradiance)


def relative(seen, wanted):
    """Norm of the difference over the norm of what is wanted."""
    return np.linalg.norm(seen - wanted) / np.linalg.norm(wanted)
