"""Lights of a map or a photograph.

| step                                                   | file                |
|--------------------------------------------------------|---------------------|
| lights with their measurements, and the report         | `lights.py`         |
| detection by the component tree                        | `detect.py` |
| detection by the steps of Loghin (2021)                | `loghin.py`         |
| - steps 3 to 9, for maps and photographs               | `article_steps.py`  |
| detection in a photograph by these steps               | `photograph.py`     |
| pixels of the lights                                   | `members.py`        |
| lights whose colour may be damaged                     | `colour_casts.py`   |
| sentences of the reports                               | `wording.py`        |
| `detect`: one of them by name                          | `detect.py`         |
| lights that were removed from a map                    | `removed_lights.py` |
| `split`: lights, and the map without them              | `split.py`          |

The kernels are in `src/kernels/detect/` and `src/kernels/split/`.
"""

from envlights.detection.lights import DetectedLights, DetectionReport

__all__ = [
    "DetectedLights",
    "DetectionReport",
]
