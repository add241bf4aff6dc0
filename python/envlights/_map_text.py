"""Text of a map."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from envlights._blocks import in_blocks
from envlights.kernels.image import LUMINANCE


def paragraph(
    radiance: NDArray[np.float32],
    layout: str,
    clipping: str,
    notes: Iterable[str],
    unit: str,
) -> str:
    """Lines on the layout, the luminance, the clip level and the notes of a map."""
    weights = LUMINANCE.astype(np.float32)
    luminance = in_blocks(radiance.shape, lambda rows: radiance[rows] @ weights)
    lines = [
        layout,
        f"luminance{unit}: median {np.median(luminance):.3g}, largest {luminance.max():.3g}",
        clipping,
        *(f"note: {note}" for note in notes),
    ]
    return "\n".join(filter(None, lines))


def clipped(share: float, flux_fraction: float) -> str:
    """Clipped fractions of the sphere and of the flux, or nothing if no pixel is clipped."""
    if not share:
        return ""
    return (
        f", {100 * share:.2g} % of the sphere is clipped and holds"
        f" {100 * flux_fraction:.2g} % of the flux"
    )
