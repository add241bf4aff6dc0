"""Lights in a training loop: differentiable losses on arrays of NumPy, JAX, torch or CuPy.

| step                                            | file           |
|-------------------------------------------------|----------------|
| what differs between array libraries            | `arrays.py`    |
| record of lights, from rigs and labels and back | `lights.py`    |
| irradiance of discs, exact                      | `probe.py`     |
| pixels, and spherical Gaussians                 | `maps.py`      |
| harmonics of lights, distances between discs    | `products.py`  |
| arrays of a map, and errors of lights under it  | `errors.py`    |
| transport between two sets of lights            | `matching.py`  |

All functions run on NumPy; JAX and torch add derivatives. Lights are one row, or a batch with any
leading axes, which results have, too. The extra is `layers`.
"""

from envlights.layers.errors import MapTerms, gloss_error, lighting_error, map_terms
from envlights.layers.lights import Lights
from envlights.layers.maps import Gaussians, to_gaussians, to_map
from envlights.layers.matching import matching_loss
from envlights.layers.probe import probe

# fmt: off
__all__ = [
    "Gaussians", "Lights", "MapTerms", "gloss_error", "lighting_error", "map_terms",
    "matching_loss", "probe", "to_gaussians", "to_map",
]
