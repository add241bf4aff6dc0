"""Comparison of lightings by spheres and by lights, in closed form or as published.

| step                                           | file                      |
|------------------------------------------------|---------------------------|
| angles between vectors, and common rotations   | `angles.py`               |
| angle between the irradiance vectors of maps   | `vector_angle.py`         |
| difference of two sets of lights as a result   | `light_set_difference.py` |
| measurement of that difference                 | `light_sets.py`           |
| choices of a comparison, and the tone of maps  | `protocol.py`             |
| errors of pixels                               | `image_errors.py`         |
| harmonics of maps and discs                    | `harmonics.py`            |
| spectra of spheres                             | `spectra.py`              |
| map, rig or lights at one size                 | `lighting.py`             |
| normals and views of images of a ball          | `rays.py`                 |
| errors of one sphere                           | `spheres.py`              |
| notes                                          | `wording.py`              |
| comparison of two lightings                    | `compare.py`              |
| comparison of two folders                      | `folders.py`              |
"""

from envlights.comparison.compare import Comparison
from envlights.comparison.folders import FolderComparison
from envlights.comparison.image_errors import ImageErrors, image_errors
from envlights.comparison.light_set_difference import LightSetDifference
from envlights.comparison.light_sets import compare_lights
from envlights.comparison.protocol import PROTOCOLS, Camera, Material, Protocol
from envlights.comparison.vector_angle import vector_angle

__all__ = [
    "PROTOCOLS",
    "Camera",
    "Comparison",
    "FolderComparison",
    "ImageErrors",
    "LightSetDifference",
    "Material",
    "Protocol",
    "compare_lights",
    "image_errors",
    "vector_angle",
]


def __dir__() -> list[str]:
    return sorted(__all__)
