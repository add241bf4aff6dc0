"""Maps reduced to few cells for a fit: of arrays, and of files that are never whole in memory."""

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

#: Normals at which the probes under two fills are compared.
_NORMALS = 320


class FilledMap(NamedTuple):
    """A map that shows the whole sphere, and what is known about its fill."""

    env: EnvMap
    """Map without a `coverage` share."""

    coverage_fraction: float
    """Fraction of the sphere that was seen; over a floor, of its upper half."""

    unseen_spread: float
    """Relative RMS difference of the probe between a black and a harmonic fill."""


def fill_for_fit(env: EnvMap, floor: bool, fill: Fill) -> FilledMap:
    """Fill a map; a floor hides the lower half of the sphere, so nothing there is missing."""
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
    layout = Layout.equirectangular(registration=env.registration)
    return EnvMap(radiance, layout=layout, clip_level=env.clip_level, coverage=env.coverage)


#: Fraction of the flux of a channel from which a cell of the reduced map becomes a point source.
POINT_SHARE = 5e-3
#: Columns into which smaller maps are divided: the bright pixels of a reduced map are points. A
#: bright pixel of 64 columns as one point hid an error of 1.6 %, and of 512 columns 0.02 %.
LEAST_COLUMNS = 512


class Reduction(NamedTuple):
    """A reduced map, and what a report says about the whole one."""

    cells: ReducedMap
    """Cells, and the pixels of bright ones."""

    width: int
    """Columns of the map."""

    notes: tuple[str, ...]
    """Notes of the map."""

    clipped_flux_fraction: float
    """Fraction of the flux in clipped pixels; 0 for a map without a clip level.

    Such maps are not examined, because that takes a third of the time of a fit.
    `EnvMap.clipped_flux_fraction` examines any map.
    """

    coverage_fraction: float = 1.0
    """Fraction of the sphere that the map shows; over a floor, of its upper half."""

    unseen_spread: float = 0.0
    """Relative RMS difference of the probe between two fills of the unseen part."""

    units: str = OWN_SCALE
    """Unit of the map; see `EnvMap.units`."""


def reduction_of(env: EnvMap, floor: bool, fill: Fill = None) -> Reduction:
    """Reduction of a map in memory, after its unseen part is filled."""
    part = fill_for_fit(env, floor, fill)
    env = part.env
    times = 1 if env.is_border_sampled else -(-LEAST_COLUMNS // env.width)
    # A repetition once would copy the map: 9 % of a fit to 1024 columns.
    radiance = env.radiance
    if times > 1:
        radiance = radiance.repeat(times, axis=0).repeat(times, axis=1)
    cells = _native.reduce_map(radiance, env.is_border_sampled, WORKING_COLUMNS, POINT_SHARE, floor)
    fraction = 0.0 if env.clip_level is None else env.clipped_flux_fraction
    unseen_part = part.coverage_fraction, part.unseen_spread
    return Reduction(cells, env.width, env.notes, fraction, *unseen_part, env.units)


def is_file(env: AnyMap) -> TypeGuard[str | os.PathLike[str] | bytes]:
    """True for a file on disk or its bytes, which can be read again if the whole map is needed."""
    if isinstance(env, str | os.PathLike):
        return os.path.isfile(env)  # noqa: PTH113, which refuses bytes in names
    return isinstance(env, bytes)


def reduction_of_file(path: str | os.PathLike[str] | bytes, floor: bool) -> Reduction | None:
    """Reduction of the rows of a file; None for files that need the whole map.

    It equals that of `EnvMap.open`.
    """
    reduced = reduce_file(path, WORKING_COLUMNS, POINT_SHARE, floor, LEAST_COLUMNS)
    if reduced is None:
        return None
    return Reduction(*reduced[:-1], units=reduced.units)
