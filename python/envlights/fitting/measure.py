"""Errors of any rig under any map, as reported for fits."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from envlights._native import GLOSS_DEGREE, EnvLightsError
from envlights.comparison import spectra
from envlights.comparison.harmonics import products
from envlights.comparison.lighting import Pair, lighting_of
from envlights.environment.envmap import EnvMap
from envlights.environment.fill import Fill
from envlights.environment.reading import AnyMap, as_envmap
from envlights.fitting import wording
from envlights.fitting.reduction import above_horizon, fill_for_fit
from envlights.kernels.sampling import icosphere
from envlights.rigs.report import FitReport
from envlights.rigs.rig import Rig


def measure(rig: Rig, env: AnyMap, fill: Fill = None) -> Rig:
    """Rig with its errors on a map; see `Rig.measured`."""
    given = as_envmap(env)
    if given.units != rig.units:
        raise EnvLightsError(
            f"rig and map must have the same units; the rig has {rig.units!r}, the map"
            f" {given.units!r}"
        )
    part = fill_for_fit(given, rig.floor, fill)
    world = above_horizon(part.env) if rig.floor else part.env
    if not world.radiance.any():
        raise EnvLightsError("the map must have light; it is black where the rig is measured")
    pair = Pair(*(lighting_of(each, world.height) for each in (world, rig)))
    truth, difference = pair.by_degree[0], pair.by_degree[3]
    probe, shadows = spectra.lambertian(), spectra.shadows()
    bands = (truth[: GLOSS_DEGREE + 1], difference[: GLOSS_DEGREE + 1])
    report = FitReport(
        measured_on=wording.measured_on("all", rig.floor),
        ambient="sh2" if rig.ambient.ndim == 2 else "constant" if rig.ambient.any() else "none",
        channel_errors=_channel_errors(pair, probe),
        max_error=partial(_max_error, rig, world),  # type: ignore[arg-type]
        shadow_error=_relative(difference, truth, shadows),
        gloss_bands=tuple(tuple(each.tolist()) for each in bands),  # type: ignore[arg-type]
        coverage_fraction=part.coverage_fraction,
        unseen_spread=part.unseen_spread,
    )
    return replace(rig, error=_relative(difference, truth, probe), report=report)


def _relative(
    difference: NDArray[np.float64], truth: NDArray[np.float64], factors: NDArray[np.float64]
) -> float:
    """Relative RMS error from energies by degree."""
    degrees = len(factors)
    cost, energy = (float(factors @ each[:degrees]) for each in (difference, truth))
    return float(np.sqrt(max(cost, 0.0) / energy)) if energy > 0 else 0.0


def _channel_errors(pair: Pair, factors: NDArray[np.float64]) -> tuple[float, ...]:
    """Relative RMS error of each channel."""
    one, other = (side.harmonics for side in pair.sides)
    difference = other - one
    return tuple(
        _relative(products(change, change), products(truth, truth), factors)
        for change, truth in ((difference[..., k::3], one[..., k::3]) for k in range(3))
    )


def _max_error(rig: Rig, world: EnvMap) -> float:
    """Largest error of any channel, relative to the RMS irradiance."""
    normals, weights = icosphere(5120)
    truth = world.probe(normals)
    mean = (weights @ truth**2).sum() / (3 * weights.sum())
    return float(np.abs(rig.probe(normals) - truth).max() / np.sqrt(mean))
