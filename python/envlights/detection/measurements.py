"""Array fields of detected lights, and their allowed ranges."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import reals
from envlights.rigs.light_arrays import LARGEST_LIGHT, amounts, axes_of_lights

#: Array fields in a file: vectors, scalars, and scalars that only clipped maps have.
VECTORS = ("direction", "irradiance", "flux", "peak_direction", "orientation")
NUMBERS = ("solid_angle", "elongation", "peak_luminance", "flux_fraction")
OF_CLIPPED = ("weight", "direction_uncertainty")
#: Array fields that the constructor checks here; `light_arrays` checks the first two.
_MEASURED = (*VECTORS[2:], *NUMBERS, *OF_CLIPPED)
#: Upper limits of scalars; all others must be finite.
_MOST = {
    "flux": LARGEST_LIGHT,
    "peak_luminance": LARGEST_LIGHT,
    "solid_angle": 4 * np.pi * (1 + 1e-6),
    "direction_uncertainty": np.pi,
}


def check_measurements(arrays: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[np.float64]]:
    """Measurements among the `arrays` of lights; raises an error for impossible values."""
    return {name: _checked_one(name, arrays[name]) for name in _MEASURED if name in arrays}


def _checked_one(name: str, values: NDArray[Any]) -> NDArray[np.float64]:
    """Measurements of one field; raises an error for impossible values."""
    if name in ("peak_direction", "orientation"):
        return axes_of_lights(name, reals(name, values, 2))
    return amounts(name, reals(name, values, values.ndim), _MOST.get(name, np.inf))
