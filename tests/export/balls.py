"""Two balls under three lamps and a map of them: a picture that shows both, and its check."""

import numpy as np

import envlights as el
from tests.export.rigs import AXES as LAMPS

#: Axes of the camera in our frame: right, up, and towards the eye, which sees all three lamps.
_BACK = np.ones(3) / np.sqrt(3)
_RIGHT = np.array([1, 0, -1]) / np.sqrt(2)
CAMERA = np.stack([_RIGHT, np.cross(_BACK, _RIGHT), _BACK])
#: Columns and rows of the picture, and the width that it shows; balls have a radius of 1.
SIZE, WIDTH = (256, 128), 4.2


def environment():
    """The lamps as discs in a dim map."""
    return el.Rig(
        [0.02] * 3, el.Lights(LAMPS.direction, 0.3 * LAMPS.irradiance, [0.15] * 3), 0.0
    ).to_map(128)


def check_balls(image):
    """Each lamp lights the matte ball on the left from its side; each disc is in the mirror."""
    for channel, towards in enumerate(np.eye(3)):
        normal, is_ball = _normals(-1.05)
        others = [k for k in range(3) if k != channel]
        share = image[..., channel] - image[..., others].max(axis=2)
        brightest = normal[is_ball][np.argsort(share[is_ball])[-20:]].mean(axis=0)
        assert brightest @ towards > 0.8 * np.linalg.norm(brightest)
        # A mirror shows what is in the direction r where its normal halves the angle to the eye.
        normal, is_ball = _normals(1.05)
        seen = 2 * (normal @ _BACK)[..., None] * normal - _BACK
        brightest = np.argmax(np.where(is_ball, share, -np.inf))
        assert np.degrees(np.arccos(seen.reshape(-1, 3)[brightest] @ towards)) < 12


#: Sides of a ball that together show all of it: right, up, and towards the eye, in our frame.
SIDES = np.stack([CAMERA, CAMERA * [[-1], [1], [-1]]])
#: Pixels of a square picture of one ball, and the width that it shows.
SIDE, SQUARE = 192, 2.1


def normals_of(side):
    """Normals of a ball of radius 1 in the square picture from a side, and where it is."""
    steps = ((np.arange(SIDE) + 0.5) / SIDE - 0.5) * SQUARE
    x, y = np.meshgrid(steps, -steps)
    is_ball = x**2 + y**2 < 0.96
    z = np.sqrt(np.where(is_ball, 1 - x**2 - y**2, 0))
    return np.stack([x, y, z], axis=-1)[is_ball] @ side, is_ball


def rays():
    """Origins and directions of the rays of an orthographic camera, (n, 3) each, row by row."""
    x, y = _plane()
    origin = 20 * _BACK + x.reshape(-1, 1) * CAMERA[0] + y.reshape(-1, 1) * CAMERA[1]
    return origin, np.broadcast_to(-_BACK, origin.shape)


def _plane():
    """Centre of each pixel along the camera's right and up."""
    columns, rows = SIZE
    x = ((np.arange(columns) + 0.5) / columns - 0.5) * WIDTH
    y = (0.5 - (np.arange(rows) + 0.5) / rows) * WIDTH * rows / columns
    return np.meshgrid(x, y)


def _normals(middle):
    """Normals of the ball around `middle` on the camera's right axis, and where it is."""
    x, y = _plane()
    x = x - middle
    is_ball = x**2 + y**2 < 0.98
    z = np.sqrt(np.where(is_ball, 1 - x**2 - y**2, 0))
    return np.stack([x, y, z], axis=-1) @ CAMERA, is_ball
