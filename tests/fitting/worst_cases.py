"""Worst cases of a fit, for its tests and its benchmark."""

import numpy as np

import envlights as el
from envlights import kernels
from tests.helpers import NORMALS
from tests.reference.closed_form import World

_UP, _EAST, _SOUTH = np.eye(3)[[1, 0, 2]]
_DIM = np.array([0.1, 0.15, 0.2])
#: A hundredth of a degree.
_CLOSE = np.deg2rad(0.01)


def points(directions, irradiance, ambient=_DIM):
    """Irradiance of a probe under point lights before an even environment."""
    directions = np.array(directions, float)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    irradiance = np.broadcast_to(np.reshape(irradiance, (-1, 1)), directions.shape)
    return World(directions, irradiance * [1.0, 0.9, 0.7], ambient).probe(NORMALS)


def hall():
    return el.EnvMap(el.synthetic.hall(128).radiance).probe(NORMALS)


def cases():
    """Name and irradiance of each, (320, 3)."""
    room, sun = hall(), points([(0.3, 0.8, 0.5)], 1.0, 0 * _DIM)
    return {
        "22 stops between the lights": points(
            [_UP, _EAST, _SOUTH, -_EAST], 2.0 ** np.array([22, 15, 7, 0]), _DIM
        ),
        "two lights 0.01 degrees apart": points([_UP, _UP + _CLOSE * _EAST], 3.0),
        "opposite lights": points([_EAST, -_EAST, _SOUTH, -_SOUTH], [3.0, 2.0, 1.0, 1.0]),
        "lights that crowd": points(_EAST + 0.2 * kernels.icosphere(80)[0], 0.1),
        "lights at the poles": points([_UP, -_UP], [2.0, 1.0]),
        "one sun over a dim room": room + 1e5 * room.max() * sun,
        "one light": points([_UP + _EAST], 2.0),
        "red alone": room * [1, 0, 0],
        "black": 0 * room,
        "even": np.ones_like(room),
    }


def known_rig():
    """An ambient term and three lights."""
    direction = np.array([[0.2, 0.9, 0.3], [-0.8, 0.1, 0.5], [0.4, -0.3, -0.8]])
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    return el.Rig(
        [0.3, 0.2, 0.1], el.Lights(direction, [[5, 4, 3], [1, 2, 3], [0.5, 0.5, 0.4]]), error=0.0
    )
