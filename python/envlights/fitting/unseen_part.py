"""Fill of the unseen part of a map for a fit, and how far it may change the probe."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from envlights import _unseen
from envlights._blocks import in_blocks
from envlights._unseen import PartialMap, Unseen
from envlights.envmap import EnvMap
from envlights.kernels.probe import relative_rms, working_irradiance
from envlights.kernels.sampling import icosphere
from envlights.kernels.sphere import pixel_directions

#: Normals at which the probes under two fills are compared.
_NORMALS = 320


class FilledMap(NamedTuple):
    """A map that shows the whole sphere, and what is known about its fill."""

    env: EnvMap
    """Map without a `seen` share."""

    coverage_fraction: float
    """Fraction of the sphere that was seen; over a floor, of its upper half."""

    unseen_spread: float
    """Relative RMS difference of the probe between a black and a harmonic fill."""


def fill_for_fit(env: EnvMap, floor: bool, unseen: Unseen) -> FilledMap:
    """Fill a map; a floor hides the lower half of the sphere, so nothing there is missing."""
    _unseen.checked_unseen(unseen)
    if env.seen is None:
        return FilledMap(env, 1.0, 0.0)
    part = PartialMap(env.radiance, env.seen, env.is_border_sampled)
    share = _unseen.share_above_horizon(part) if floor else part.share
    choice = _unseen.choice_of(unseen, share)
    harmonic = env.filled("harmonic")
    filled = harmonic if choice == "harmonic" else env.filled(choice)
    return FilledMap(filled, share, _difference(env.filled("black"), harmonic, floor))


def _difference(env: EnvMap, reference: EnvMap, floor: bool) -> float:
    """Relative RMS difference of the probes of two maps."""
    normals, solid_angles = icosphere(_NORMALS)
    probe, reference_probe = (
        working_irradiance(
            above_horizon(each).radiance if floor else each.radiance,
            normals,
            border_sampled=each.is_border_sampled,
        )[0]
        for each in (env, reference)
    )
    return relative_rms(probe, reference_probe, solid_angles)


def above_horizon(env: EnvMap) -> EnvMap:
    """`env`, black below the horizon."""
    # All columns have the same heights, so compute one.
    towards = pixel_directions(env.height, 2, border_sampled=env.is_border_sampled)[:, :1]
    radiance = in_blocks(
        env.radiance.shape,
        lambda rows: np.where(towards[rows, :, 1:2] < 0, np.float32(0), env.radiance[rows]),
    )
    return EnvMap(radiance, registration=env.registration, white=env.white, seen=env.seen)
