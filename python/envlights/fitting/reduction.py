"""Reduction of maps to few cells for a fit: arrays, and files that are read row by row."""

from __future__ import annotations

import os
from typing import NamedTuple, TypeGuard

import numpy as np

from envlights import _native
from envlights._common.blocks import in_blocks
from envlights._common.units import OWN_SCALE
from envlights._native import ReducedMap
from envlights.environment.envmap import EnvMap
from envlights.environment.fill import (
    Fill,
    PartialMap,
    checked_unseen,
    choice_of,
    share_above_horizon,
)
from envlights.environment.layouts.projections import Layout
from envlights.environment.reading import AnyMap
from envlights.environment.reduced_file import reduce_file
from envlights.kernels.probe import WORKING_COLUMNS, relative_rms, working_irradiance
from envlights.kernels.sampling import icosphere
from envlights.kernels.sphere import pixel_directions

#: Number of normals at which the irradiance under two fills is compared.
_NORMALS = 320


class FilledMap(NamedTuple):
    """Map with its uncovered part filled, and facts about the fill."""

    env: EnvMap
    """Map without `coverage`."""

    coverage_fraction: float
    """Covered fraction of the sphere; over a floor, of the upper hemisphere."""

    unseen_spread: float
    """Relative RMS difference of irradiance between a black and a harmonic fill."""


def fill_for_fit(env: EnvMap, floor: bool, fill: Fill) -> FilledMap:
    """Fill a map for a fit; over a floor, only the upper hemisphere needs to be covered."""
    checked_unseen(fill)
    if env.coverage is None:
        return FilledMap(env, 1.0, 0.0)
    part = PartialMap(env.radiance, env.coverage, env.is_border_sampled)
    fraction = share_above_horizon(part) if floor else part.fraction
    choice = choice_of(fill, fraction)
    harmonic = env.filled("harmonic")
    filled = harmonic if choice == "harmonic" else env.filled(choice)
    return FilledMap(filled, fraction, _difference(env.filled("black"), harmonic, floor))


def _difference(env: EnvMap, reference: EnvMap, floor: bool) -> float:
    """Relative RMS difference of irradiance between two maps."""
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
    """Map set to black below the horizon."""
    # Elevation depends only on the row, so two columns suffice.
    towards = pixel_directions(env.height, 2, border_sampled=env.is_border_sampled)[:, :1]
    radiance = in_blocks(
        env.radiance.shape,
        lambda rows: np.where(towards[rows, :, 1:2] < 0, np.float32(0), env.radiance[rows]),
    )
    layout = Layout.equirectangular(registration=env.registration)
    return EnvMap(radiance, layout=layout, clip_level=env.clip_level, coverage=env.coverage)


#: Fraction of the flux of a channel from which a cell of the reduced map is split into point
#: sources.
POINT_SHARE = 5e-3
#: Columns to which smaller maps are subdivided, because bright pixels of a reduced map become
#: points. A bright pixel of a map with 64 columns as a single point caused an error of 1.6 %, with
#: 512 columns 0.02 %.
LEAST_COLUMNS = 512


class Reduction(NamedTuple):
    """Reduced map, and facts about the whole map for the report."""

    cells: ReducedMap
    """Cells, with exact pixels of the bright ones."""

    width: int
    """Columns of the original map."""

    notes: tuple[str, ...]
    """Notes of the map."""

    clipped_flux_fraction: float
    """Fraction of the flux in clipped pixels; 0 for a map without a clip level.

    Such maps are not examined, because that takes a third of the time of a fit.
    `EnvMap.clipped_flux_fraction` examines any map.
    """

    coverage_fraction: float = 1.0
    """Covered fraction of the sphere; over a floor, of the upper hemisphere."""

    unseen_spread: float = 0.0
    """Relative RMS difference of irradiance between two fills of the uncovered part."""

    units: str = OWN_SCALE
    """Unit of the map; see `EnvMap.units`."""


def reduction_of(env: EnvMap, floor: bool, fill: Fill = None) -> Reduction:
    """Reduction of a map in memory, after filling its uncovered part."""
    part = fill_for_fit(env, floor, fill)
    env = part.env
    times = 1 if env.is_border_sampled else -(-LEAST_COLUMNS // env.width)
    # Do not repeat pixels once, because a copy of the map takes 9 % of a fit to 1024 columns.
    radiance = env.radiance
    if times > 1:
        radiance = radiance.repeat(times, axis=0).repeat(times, axis=1)
    cells = _native.reduce_map(radiance, env.is_border_sampled, WORKING_COLUMNS, POINT_SHARE, floor)
    fraction = 0.0 if env.clip_level is None else env.clipped_flux_fraction
    unseen_part = part.coverage_fraction, part.unseen_spread
    return Reduction(cells, env.width, env.notes, fraction, *unseen_part, env.units)


def is_file(env: AnyMap) -> TypeGuard[str | os.PathLike[str] | bytes]:
    """True for a path or bytes, which can be read again if the whole map is needed."""
    if isinstance(env, str | os.PathLike):
        return os.path.isfile(env)  # noqa: PTH113, which refuses bytes in names
    return isinstance(env, bytes)


def reduction_of_file(path: str | os.PathLike[str] | bytes, floor: bool) -> Reduction | None:
    """Reduction of a file row by row; None if the whole map is needed.

    It equals that of `EnvMap.open`.
    """
    reduced = reduce_file(path, WORKING_COLUMNS, POINT_SHARE, floor, LEAST_COLUMNS)
    if reduced is None:
        return None
    return Reduction(*reduced[:-1], units=reduced.units)
