"""Comparison of lightings by spheres and by lights, exactly or as published."""

from envlights.comparison.compare import Comparison, compare
from envlights.comparison.folders import FolderComparison, compare_folders
from envlights.comparison.image_errors import ImageErrors, image_errors
from envlights.comparison.light_sets import LightSetDifference, compare_lights
from envlights.comparison.protocol import PROTOCOLS, Camera, Material, Protocol

__all__ = [
    "PROTOCOLS",
    "Camera",
    "Comparison",
    "FolderComparison",
    "ImageErrors",
    "LightSetDifference",
    "Material",
    "Protocol",
    "compare",
    "compare_folders",
    "compare_lights",
    "image_errors",
]


def __dir__() -> list[str]:
    return sorted(__all__)
