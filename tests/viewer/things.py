"""Ball, box and camera of a page as the kernel takes them."""

from types import SimpleNamespace

import numpy as np

_FACES = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]
FLOOR, BALL, BOX = -1, 0, 1


def rotation(angle):
    """Rotation about +y by degrees, as the page turns its box."""
    cos, sin = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
    return np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])


def solids(ball, box):
    """Solids of a page: ``ball`` is x, z, radius, ``box`` x, z, three half sides and degrees."""
    x, z, radius = ball
    signs = np.array([[1 if code >> axis & 1 else -1 for axis in range(3)] for code in range(8)])
    half, turn = np.array(box[2:5]), rotation(box[5])
    corners = (signs * half) @ turn.T + [box[0], half[1], box[1]]
    round_one = SimpleNamespace(centre=np.array([x, radius, z]), radius=radius)
    return [round_one, SimpleNamespace(vertices=corners, faces=_FACES)]


def stage(things, points, normals, own):
    """Stage of the kernel."""
    return SimpleNamespace(solids=things, points=points, normals=normals, own=own)


def rays(state, width, height):
    """Eye and directions of the pixels of a page, rows from below."""
    up, around = state["elevation"], state["azimuth"]
    away = np.array([np.sin(around) * np.cos(up), np.sin(up), np.cos(around) * np.cos(up)])
    right = np.array([np.cos(around), 0, -np.sin(around)])
    wide = np.tan(np.deg2rad(state["fov"]) / 2) * max(width / height, 1)
    x = (2 * (np.arange(width) + 0.5) / width - 1) * wide
    y = (2 * (np.arange(height) + 0.5) / height - 1) * wide * height / width
    towards = x[:, None] * right + y[:, None, None] * np.cross(right, -away) - away
    eye = np.array(state["look"]) + state["distance"] * away
    return eye, (towards / np.linalg.norm(towards, axis=2, keepdims=True)).reshape(-1, 3)


def visible(state, width, height):
    """Thing, point and normal of each pixel; the thing of the sky is -2."""
    eye, towards = rays(state, width, height)
    (x, z, radius), box = state["ball"], state["box"]
    with np.errstate(divide="ignore", invalid="ignore"):
        floor = np.where(towards[:, 1] < 0, -eye[1] / towards[:, 1], np.inf)
        away = eye - [x, radius, z]
        along = towards @ away
        root = along**2 - (away @ away - radius**2)
        ball = np.where(root > 0, -along - np.sqrt(np.maximum(root, 0)), np.inf)
        turn, half = rotation(box[5]), np.array(box[2:5])
        start, step = (eye - [box[0], half[1], box[1]]) @ turn, towards @ turn
        near, far = (-np.sign(step) * half - start) / step, (np.sign(step) * half - start) / step
        side = near.argmax(axis=1)
        cube = np.where(near.max(axis=1) < far.min(axis=1), near.max(axis=1), np.inf)
    first = np.stack([floor, ball, cube]).argmin(axis=0)
    length = np.stack([floor, ball, cube]).min(axis=0)
    own = np.where(np.isfinite(length), np.array([FLOOR, BALL, BOX])[first], -2)
    points = eye + np.where(np.isfinite(length), length, 0)[:, None] * towards
    normals = np.tile([0.0, 1.0, 0.0], (len(points), 1))
    on_ball = own == BALL
    normals[on_ball] = (points[on_ball] - [x, radius, z]) / radius
    faces = -np.sign(step)[:, :, None] * np.eye(3)
    normals[own == BOX] = faces[np.arange(len(side)), side][own == BOX] @ turn.T
    points[own == FLOOR, 1] = 0
    return own, points, normals


def inner(own, width):
    """False for pixels beside another thing, where rounding may decide which is seen."""
    image = own.reshape(-1, width)
    same = np.ones(image.shape, bool)
    for step in (-1, 1):
        for axis in (0, 1):
            same &= np.roll(image, step, axis) == image
    return same.ravel()
