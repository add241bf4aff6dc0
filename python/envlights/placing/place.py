"""`place`: the lights of a map where they hang."""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import ArrayLike

from envlights._common.notes import log
from envlights._native import EnvLightsError
from envlights.cards import CardSplit
from envlights.environment.envmap import AnyMap
from envlights.kernels.image import luminance
from envlights.placing.depth import read_depth, room_distance
from envlights.placing.patches import patches_of
from envlights.placing.placed import PlacedLights
from envlights.placing.position import place_card
from envlights.placing.reading import Reals
from envlights.splitting.split import Split, split

#: Most rows of the walls of a room that is given by its size.
_MOST_ROWS = 512


def place(
    env: AnyMap | CardSplit,
    depth: ArrayLike | str | os.PathLike[str] | None = None,
    *,
    reading: str | None = None,
    scale: float | None = None,
    room: ArrayLike | None = None,
    camera: ArrayLike | None = None,
) -> PlacedLights:
    distance, notes = _distances(depth, reading, scale, room, camera, parts.remainder.height)
