"""Tone of maps before they are compared."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights.comparison.protocol import Protocol


def tone(radiance: NDArray[np.float32], protocol: Protocol) -> tuple[NDArray[np.float32], float]:
    """Toned map, and the factor that follows the exponent.

    The factor brings the median of the samples above 0 to `Protocol.median`, as in the code of
    StyleLight.
    """
    values = np.maximum(radiance, 0).astype(np.float64)
    if protocol.gamma is not None:
        values **= 1 / protocol.gamma
    factor = 1.0
    if protocol.median is not None and (values > 0).any():
        factor = protocol.median / float(np.median(values[values > 0]))
    return (factor * values).astype(np.float32), factor
