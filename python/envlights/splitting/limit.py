"""Separation of radiance above a maximum from a map, as lights."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import amount, named_arguments
from envlights._common.former import former_attributes
from envlights._common.words import percent
from envlights._native import EnvLightsError
from envlights.environment.envmap import EnvMap
from envlights.environment.peaks import PixelIntegrals, float32_at_most
from envlights.environment.reading import AnyMap, as_envmap
from envlights.kernels.connectivity import connected_regions
from envlights.kernels.image import LUMINANCE
from envlights.kernels.sphere import pixel_solid_angles
from envlights.rigs.lights import Lights


@former_attributes(rest="remainder")
class Limit(NamedTuple):
    """Map limited to a maximum, and the excess radiance as lights."""

    lights: Lights
    """Light per bright region, brightest first."""

    remainder: EnvMap
    """Map without the excess radiance, of the same size."""

    def __str__(self) -> str:
        return f"{self.lights}\n\n{self.remainder}"


@named_arguments()
def limit(env: AnyMap, maximum: float) -> Limit:
    r"""Limit the samples of a map, and return the excess as lights.

    For formats and displays with a largest value: half floats, LED walls, inputs of networks.
    `EnvMap.limited` spreads the excess over the map instead, and `split` removes whole lights.

    Parameters
    ----------
    env : EnvMap, path or array_like, shape (height, 2 * height, 3)
        The map.
    maximum : float
        Largest value of a sample of the remainder, such as 65504 for half floats.

    Returns
    -------
    lights : Lights
        One disc for each connected region above the maximum, with its excess.
    remainder : EnvMap
        The smaller one of the map and the maximum, in each sample. Its last note has the number of
        lights and their fraction of the flux.

    Raises
    ------
    EnvLightsError
        If `env` is not a map, `maximum` is not a number from 0 on, or a region is so wide that no
        disc holds it.

    Notes
    -----
    The excess X of a region is integrated exactly over its pixels. Its disc has the direction of
    the luminance Y of X, :math:`d \propto \int Y \omega\, d\omega`, the flux of X in each channel,
    :math:`2 E / (1 + \cos a)`, and the irradiance of Y at normal incidence; so the radius follows
    from :math:`(1 + \cos a) / 2 = |\int Y \omega\, d\omega| / \int Y d\omega`. On maps with suns,
    flux and vector irradiance of the luminance of remainder and lights together differ by less than
    1e-12 from those of the map.

    Examples
    --------
    >>> import envlights as el
    >>> sky = np.ones((64, 128, 3))
    >>> sky[20, 40] = 1e5
    >>> lights, rest = el.limit(sky, 65504)
    >>> len(lights), float(rest.radiance.max())
    (1, 65504.0)
    >>> rest.notes[-1]
    'limited to 65504: 32.5 % of the flux is in 1 light'
    """
    env, level = as_envmap(env), amount("maximum", maximum)
    most = float32_at_most(level)
    rows, columns = np.nonzero((env.radiance > most).any(axis=2))
    radiance = np.minimum(env.radiance, most)
    excess = env.radiance[rows, columns].astype(np.float64) - radiance[rows, columns]
    integrals = PixelIntegrals(env.height, env.width, env.is_border_sampled).of(rows, columns)
    regions = connected_regions(rows, columns, env.radiance.shape[:2])
    lights = _lights(excess, integrals, regions, level, env.units)
    notes: tuple[str, ...] = env.notes
    if len(lights):
        part = (excess * integrals[:, 3:]).sum() / _flux(env)
        note = f"limited to {level:g}: {percent(part)} of the flux is in {lights.in_short()}"
        notes = (*notes, note)
    return Limit(lights, env.with_radiance(radiance, notes))


def _flux(env: EnvMap) -> float:
    """Integral of the radiance of a map, summed over channels."""
    angles = pixel_solid_angles(env.height, env.width, border_sampled=env.is_border_sampled)
    return float(np.einsum("hwc,hw->", env.radiance, angles, dtype=np.float64))


def _lights(
    excess: NDArray[np.float64],
    integrals: NDArray[np.float64],
    regions: NDArray[np.intp],
    maximum: float,
    units: str,
) -> Lights:
    """Disc with the excess of each region."""
    count = int(regions.max(initial=-1)) + 1
    sums = np.zeros((count, 3, 4))
    np.add.at(sums, regions, excess[:, :, None] * integrals[:, None])
    vector, flux = np.einsum("nck,c->nk", sums[..., :3], LUMINANCE), sums[..., 3]
    length = np.linalg.norm(vector, axis=1)
    # Mean cosine of the angle to the direction; 0.5 for a hemisphere.
    cosine = length / (flux @ LUMINANCE)
    if (cosine < 0.5).any():
        raise EnvLightsError(
            f"the samples above maximum={maximum:g} form a region that is wider than half of the"
            " sphere, which is no light; give a larger maximum"
        )
    radius = np.arccos(np.minimum(2 * cosine - 1, 1))
    return Lights(vector / length[:, None], flux * cosine[:, None], radius, units=units)
