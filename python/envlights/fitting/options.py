"""Options of the kernel's fit, as one object."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

#: Steps after which a descent gives up.
MAX_STEPS = 100


class FitOptions(NamedTuple):
    """Options of `_native.fit_map` and `_native.fit_samples`."""

    ambient: int
    """Number of ambient coefficients in each channel: 0, 1 or 9."""
    start: NDArray[np.float64]
    """Initial directions of the first lights, the fixed ones before the others."""
    fixed: int
    """Number of these that keep their directions."""
    lights: int
    """Greatest number of lights."""
    error: float | None = None
    """Relative RMS error that is good enough."""
    shadow_error: float | None = None
    """Relative RMS error with shadows that is good enough."""
    gloss_error: float | None = None
    """Relative RMS error of a shiny object that is good enough."""
    gloss_factors: Sequence[float] = ()
    """Factors of that object by degree."""
    sizes: str | None = None
    """Comparison that gives the lights their sizes; points if absent."""
    max_radius: float | None = None
    """Greatest angular radius of a light in radians; 75 degrees if absent."""
    max_steps: int = MAX_STEPS
    """Greatest number of steps of one descent."""
    floor: bool = False
    """True if a floor hides the light from below the horizon."""
    error_floor: float = 0.0
    """Error below which no light is added."""
    is_plain: bool = False
    """True for forward selection and eight plain starts: the comparison of benchmarks."""
