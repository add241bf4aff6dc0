"""Maps with exactly known lights, for the demo, tests and benchmarks.

Frame and units are those of `EnvMap`; pixels are cell-centred.

| content                                                              | file           |
|----------------------------------------------------------------------|----------------|
| outlines of lights on the sphere                                     | `shapes.py`    |
| shapes on a background; the truth is measured from the stored pixels | `scene.py`     |
| the hall of the demo                                                 | `hall.py`      |
| surroundings without lights                                          | `backdrops.py` |
| lights of random kind, size and direction                            | `lamps.py`     |
| two families of random maps for detectors                            | `suite.py`     |
| a clear sky with its sun                                             | `clear_sky.py` |
| openings behind bars and leaves, rows of lamps                       | `openings.py`  |
| comparison of detected and true lights                               | `score.py`     |
| direct and indirect images of a closed room                          | `room.py`      |
| an open courtyard for Mitsuba, and rigs for it                       | `courtyard.py` |
"""

from envlights.synthetic.clear_sky import clear_sky
from envlights.synthetic.courtyard import courtyard, rigs
from envlights.synthetic.hall import hall
from envlights.synthetic.openings import openings
from envlights.synthetic.room import Room, room, room_charts
from envlights.synthetic.scene import SyntheticMap, scene
from envlights.synthetic.score import Score, evaluate, match
from envlights.synthetic.shapes import Disc, PixelSun, Rectangle, Shape
from envlights.synthetic.suite import EVALUATION, TUNING, hard, plain

__all__ = [
    "EVALUATION",
    "TUNING",
    "Disc",
    "PixelSun",
    "Rectangle",
    "Room",
    "Score",
    "Shape",
    "SyntheticMap",
    "clear_sky",
    "courtyard",
    "evaluate",
    "hall",
    "hard",
    "match",
    "openings",
    "plain",
    "rigs",
    "room",
    "room_charts",
    "scene",
]


def __dir__() -> list[str]:
    return sorted(__all__)
