"""Angle between the irradiance vectors of two maps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights.comparison.angles import degrees_between
from envlights.environment.envmap import EnvMap
from envlights.environment.reading import AnyMap, as_envmap
from envlights.kernels.image import LUMINANCE

#: Length relative to the map's flux below which vectors count as 0, because single precision makes
#: their direction random.
_LEAST_LENGTH = 1e-7


def vector_angle(truth: AnyMap, guess: AnyMap) -> float | None:
    r"""Angle between the irradiance vectors of two maps, in degrees.

    The irradiance vector points to where most light comes from. It needs no detection and no
    threshold, and it turns with the map, so it is the first number to look at: all that a map
    emits is in it, but one vector cannot separate two lamps.

    Parameters
    ----------
    truth, guess : EnvMap, path or array_like, shape (height, 2 * height, 3)
        The maps; their sizes and scales may differ. Unseen pixels count as black: use
        `EnvMap.filled` first.

    Returns
    -------
    float or None
        Degrees from 0 to 180; None if one of the vectors is 0, as for a black or a uniform map.

    Raises
    ------
    EnvLightsError
        If an argument is not a map.

    See Also
    --------
    compare_lights : light by light.

    Notes
    -----
    The vector is :math:`\int Y(\omega)\, \omega\, d\omega` of the luminance :math:`Y` (Gershun
    1939, "The light field"): the part of degree 1 of the map. Each pixel is a square of one
    radiance, over which :math:`\omega` is integrated in closed form. A rotation by whole columns
    is exact. On 19 real maps that `EnvMap.rotated` turned by 20 degrees about a tilted axis, the
    angle was off by at most 0.019 degrees, because lamps are resampled
    (`benchmarks/light_sets.py`).

    Examples
    --------
    >>> import envlights as el
    >>> env = el.synthetic.hall(64).radiance
    >>> el.comparison.vector_angle(env, env)
    0.0
    >>> lamp = el.Lights([[1, 0, 0]], [[3, 2, 1]]).to_map(64)
    >>> round(el.comparison.vector_angle(lamp, np.roll(lamp.radiance, 32, axis=1)), 6)
    90.0
    """
    one, other = (_irradiance_vector(as_envmap(env)) for env in (truth, guess))
    if one is None or other is None:
        return None
    return float(degrees_between(one, other))


def _irradiance_vector(env: EnvMap) -> NDArray[np.float64] | None:
    mean, y, z, x = (env.harmonics(1, fill="black") / np.sqrt([[1], [3], [3], [3]])) @ LUMINANCE
    length = np.linalg.norm([x, y, z])
    return np.array([x, y, z]) / length if length > _LEAST_LENGTH * mean else None
