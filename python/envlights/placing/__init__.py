"""Lights of a room in metres: positions by depth, by the size of the room, or by two maps.

| step                                                  | file               |
|-------------------------------------------------------|--------------------|
| planes in a depth map, and the meaning of its numbers | `planes.py`        |
| distance along the ray, from a file or a room         | `depth.py`         |
| light with a position                                 | `placed_light.py`  |
| position of a light by depth                          | `position.py`      |
| - by its light on the walls of a box                  | `shading.py`       |
| - by two maps                                         | `triangulate.py`   |
| remainder as surfaces at their depth                  | `patches.py`       |
| all lights, with irradiance, rig and map at a point   | `placed_lights.py` |
| the function that does it                             | `place.py`         |
"""

from envlights.placing.place import place
from envlights.placing.placed_light import PlacedLight
from envlights.placing.placed_lights import PlacedLights, PointErrors

__all__ = ["PlacedLight", "PlacedLights", "PointErrors", "place"]
