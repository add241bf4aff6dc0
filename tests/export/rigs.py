"""Rigs that test every exporter, and the normals at which they are compared."""

import numpy as np

import envlights as el
from tests.helpers import NORMALS

_DIRECTIONS = [[0.48, 0.8, 0.36], [-0.6, -0.64, 0.48], [0, 0.28, -0.96], [0, 0, 1], [0, -1, 0]]
_IRRADIANCES = [[3, 2, 1], [1, 1.5, 2], [0.5, 0.25, 0.125], [0.2, 0, 0], [0, 0, 0.1]]
POINTS = el.Lights(_DIRECTIONS, _IRRADIANCES)
#: The sun, lamps, a window and a wall: radii in radians.
DISCS = el.Lights(_DIRECTIONS, _IRRADIANCES, [0.00465, 0.05, 0.15, 0.3, 0.7])
#: Points and discs together.
MIXED = el.Lights(_DIRECTIONS[:3], _IRRADIANCES[:3], [0.0, 0.02, 0.3])
#: One lamp on each axis, red, green, blue.
AXES = el.Lights(np.eye(3), 3 * np.eye(3))

_HARMONICS = (
    np.array([[1, 2, 3]] * 9) * np.array([1, 0.2, -0.1, 0.15, 0.1, -0.1, 0.1, 0.05, -0.1])[:, None]
)
#: Each ambient term that there is.
AMBIENTS = {
    "none": {"ambient": [0, 0, 0]},
    "constant": {"ambient": [0.1, 0.2, 0.3]},
    "floor": {"ambient": [0.1, 0.2, 0.3], "floor": True},
    "harmonics": {"ambient": _HARMONICS},
}


def rigs(lights):
    """A rig with `lights` for each kind of ambient term, by its name."""
    return {name: el.Rig(lights=lights, error=0.0, **parts) for name, parts in AMBIENTS.items()}


def relative_error(irradiance, rig, normals=NORMALS):
    """Norm of the difference from `rig.probe` over its norm."""
    return relative(irradiance, rig.probe(normals))


def environment():
    """A map that has no symmetry."""
    return el.EnvMap(el.synthetic.hall(64).radiance)


def irradiance_of_points(direction, irradiance, normals=NORMALS):
    """Irradiance of point lights at each normal."""
    return np.maximum(normals @ np.transpose(direction), 0) @ np.asarray(irradiance)


def relative(seen, wanted):
    """Norm of the difference over the norm of what is wanted."""
    return np.linalg.norm(seen - wanted) / np.linalg.norm(wanted)
