"""Lights of a map.

| step                                                   | file                |
|--------------------------------------------------------|---------------------|
| lights with their measurements, and the report         | `lights.py`         |
| detection by the component tree                        | `detect.py` |
| pixels of the lights                                   | `members.py`        |
| lights whose colour may be damaged                     | `colour_casts.py`   |
| sentences of the reports                               | `wording.py`        |

The kernels are in `src/kernels/detect/` and `src/kernels/split/`.
"""

from envlights.detection.lights import DetectedLights, DetectionReport

__all__ = [
    "DetectedLights",
    "DetectionReport",
]
