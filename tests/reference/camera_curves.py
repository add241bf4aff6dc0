"""Response curves of cameras that are not sRGB: codes from 0 to 1 of linear exposures."""

import numpy as np

from envlights._common.srgb import encode_srgb


def rec709(x):
    x = np.clip(x, 0, 1)
    return np.where(x < 0.018, 4.5 * x, 1.099 * x**0.45 - 0.099)


def shoulder(x):
    """Gamma 1.8 with an S-shaped shoulder."""
    v = np.clip(x, 0, 1) ** (1 / 1.8)
    return 0.6 * v + 0.4 * v * v * (3 - 2 * v)


def filmic(x):
    """Hable's curve, with white at 6."""

    def hable(x):
        return (x * (0.15 * x + 0.05) + 0.004) / (x * (0.15 * x + 0.5) + 0.06) - 1 / 15

    return encode_srgb(hable(np.clip(x, 0, 1) * 6) / hable(6.0))
