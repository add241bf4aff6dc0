"""The start of a page as a path-traced picture under the map itself."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.srgb import encode_srgb
from envlights.environment.envmap import EnvMap
from envlights.fitting.fit import fit
from envlights.kernels.solids import Ball, Box
from envlights.scene.camera import Camera
from envlights.scene.mitsuba.path_traced import SolidsOnFloor, Still
from envlights.scene.mitsuba.renderer import mitsuba
from envlights.scene.panorama_floor import CAMERA_HEIGHT, DOME_RADIUS
from envlights.scene.view_image import true_view
from envlights.viewer import data

#: Pixels of the picture; its shorter side has the angle of the page.
_WIDTH, _HEIGHT = 480, 270
#: Radiance of the largest code over that of a white pixel of the page: two stops.
_HEADROOM = 4.0
#: Paths through each pixel, in two images of 100 each.
_PATHS = 200
#: Lights that tell the floor from the things in pixels at outlines.
_LIGHTS = 4


def check_renderer() -> None:
    """Refuse where Mitsuba is missing."""
    with mitsuba():
        pass


def with_truth(content: dict[str, Any], env: EnvMap) -> dict[str, Any]:
    """Data of a page with a path-traced picture of its start, which the data then fix."""
    start = start_of(content["state"]["azimuth"])
    still = still_of(env, np.array(content["floor"]), start)
    truth = {**picture(still, content["exposure"]), "start": start}
    return {**content, "state": {**content["state"], **start}, "truth": truth}


def start_of(azimuth: float) -> dict[str, Any]:
    """Camera, ground, and a diffuse ball and box: all that changes the picture but exposure."""
    cos, sin = np.cos(azimuth), np.sin(azimuth)
    ball, box = ([cos * x + sin * z, cos * z - sin * x] for x, z in ((-0.62, 0.12), (0.62, -0.1)))
    turn = (30 + np.rad2deg(azimuth)) % 90
    camera = {"azimuth": azimuth, "elevation": 0.3, "distance": 4.6, "look": [0.0, 0.42, 0.0]}
    things = {"ball": [*ball, 0.5], "box": [*box, 0.42, 0.42, 0.42, turn], "only": 0}
    surfaces = {"albedo": 0.7, "shine": 0.0, "cameraHeight": CAMERA_HEIGHT, "dome": DOME_RADIUS}
    return {**camera, "fov": 36.0, **things, **surfaces}


def still_of(env: EnvMap, floor: NDArray[np.float64], start: dict[str, Any]) -> Still:
    """Radiance of the start under a map, twice."""
    left, back, radius = start["ball"]
    x, z, *half_sides, turn = start["box"]
    ball = Ball((left, radius, back), radius)
    box = Box((x, half_sides[1], z), tuple(half_sides), np.deg2rad(turn))
    scene = SolidsOnFloor((ball, box), np.full((2, 3), start["albedo"]), floor)
    # A map gets four paths for each sample.
    return true_view(env, fit(env, _LIGHTS, floor=True), scene, camera_of(start), _PATHS // 4)


def camera_of(start: dict[str, Any]) -> Camera:
    """Camera of a start; its angle is that of the shorter side."""
    azimuth, elevation = start["azimuth"], start["elevation"]
    level = np.cos(elevation)
    away = np.array([np.sin(azimuth) * level, np.sin(elevation), np.cos(azimuth) * level])
    eye = start["look"] + start["distance"] * away
    across = np.tan(np.deg2rad(start["fov"]) / 2) * _WIDTH / _HEIGHT
    angle = float(2 * np.rad2deg(np.arctan(across)))
    return Camera(tuple(eye), tuple(start["look"]), angle, _WIDTH, _HEIGHT)


def picture(still: Still, exposure: float) -> dict[str, Any]:
    """A picture at the exposure of a page: its headroom, paths for each pixel and noise."""
    codes = np.round(255 * encode_srgb(still.image * exposure / _HEADROOM)).astype(np.uint8)
    address = data.address(codes)
    return {"picture": address, "headroom": _HEADROOM, "paths": _PATHS, "noise": still.noise}
