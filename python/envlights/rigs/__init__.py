"""Lights, and rigs: an ambient term and lights, with their report and tables.

| noun                                     | file                                       |
|------------------------------------------|--------------------------------------------|
| directional lights, and one of them      | `lights.py`, `light.py`                    |
| ambient term and lights, with an error   | `rig.py`                                   |
| report of a fit                          | `report.py`                                |
| checks of arrays of lights               | `light_arrays.py`                          |
| lights as spherical Gaussians            | `lobes.py`                                 |
"""

from envlights.rigs.light import Light
from envlights.rigs.report import FitReport, StopReason
from envlights.rigs.rig import rigs_to_frame

__all__ = [
    "FitReport",
    "Light",
    "StopReason",
    "rigs_to_frame",
]
