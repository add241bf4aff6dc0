"""Lights, and rigs (an ambient term plus lights), with reports and tables.

| noun                                     | file                                       |
|------------------------------------------|--------------------------------------------|
| directional lights, and one of them      | `lights.py`, `light.py`                    |
| ambient term and lights, with an error   | `rig.py`                                   |
| report of a fit                          | `report.py`                                |
| checks of arrays of lights               | `light_arrays.py`                          |
| lights as spherical Gaussians            | `lobes.py`                                 |
| variations of rigs at random             | `vary.py`, `planck.py`, `portable.py`      |
"""

from envlights.rigs.light import Light
from envlights.rigs.report import FitReport, StopReason
from envlights.rigs.rig import rigs_to_frame
from envlights.rigs.vary import Variation

__all__ = [
    "FitReport",
    "Light",
    "StopReason",
    "Variation",
    "rigs_to_frame",
]
