"""Arrays of detected lights, and the limits of their values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._check import reals
from envlights._light_arrays import LARGEST_LIGHT, amounts, axes_of_lights

#: Arrays of the file: vectors, numbers, and numbers that clipped maps alone have.
VECTORS = ("direction", "irradiance", "flux", "peak_direction", "orientation")
NUMBERS = ("solid_angle", "elongation", "peak_luminance", "flux_fraction")
OF_CLIPPED = ("weight", "direction_uncertainty")
#: Arrays that the constructor checks; `light_arrays` checks the first two.
_MEASURED = (*VECTORS[2:], *NUMBERS, *OF_CLIPPED)
#: Upper limits of numbers; the others are finite.
_MOST = {
    "flux": LARGEST_LIGHT,
    "peak_luminance": LARGEST_LIGHT,
    "solid_angle": 4 * np.pi * (1 + 1e-6),
    "direction_uncertainty": np.pi,
}


def check_measurements(arrays: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[np.float64]]:
    """Measurements among the `arrays` of lights, or a refusal of impossible ones."""
    return {name: _checked_one(name, arrays[name]) for name in _MEASURED if name in arrays}


def _checked_one(name: str, values: NDArray[Any]) -> NDArray[np.float64]:
    """Measurements of one kind, or a refusal of impossible ones."""
    if name in ("peak_direction", "orientation"):
        return axes_of_lights(name, reals(name, values, 2))
    return amounts(name, reals(name, values, values.ndim), _MOST.get(name, np.inf))
