"""Lights of a room in metres: positions by depth, by the size of the room, or by two maps.

| step                                                  | file              |
|-------------------------------------------------------|-------------------|
| planes in a depth map, and the meaning of its numbers | `reading.py`      |
| distance along the ray, from a file or a room         | `depth.py`        |
| surface at and around a light                         | `surface.py`      |
| light with a position                                 | `placed_light.py` |
| position of a light by depth                          | `position.py`     |
| - by two maps                                         | `triangulate.py`  |
| remainder as diffuse patches                          | `patches.py`      |
| remainder as another point sees it                    | `warp.py`         |
| lights as another point sees them                     | `seen.py`         |
| errors at points                                      | `errors.py`       |
| all lights, with irradiance, rig and map at a point   | `placed.py`       |
| the function that does it                             | `place.py`        |
"""

from envlights.placing.errors import PointErrors
from envlights.placing.patches import Patches
from envlights.placing.place import place
from envlights.placing.placed import PlacedLights
from envlights.placing.placed_light import PlacedLight

__all__ = ["Patches", "PlacedLight", "PlacedLights", "PointErrors", "place"]
