"""Maps and rigs to compare."""

import numpy as np

import envlights as el


def rooms(height=64):
    """A hall, and another world of the same size, with colours that differ."""
    hall = el.synthetic.hall(height).radiance
    other = el.Rig([0.3, 0.4, 0.6], el.Lights([[0.6, 0.8, 0]], [[9, 7, 4]], [0.3]), error=0.0)
    return el.EnvMap(hall), other.to_map(height)


def even(colour, height=16):
    """Map of one colour."""
    return np.broadcast_to(np.float32(colour), (height, 2 * height, 3)).copy()
