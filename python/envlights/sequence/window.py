"""Mean of the rigs in a window around a frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights.fitting.map_fit import MapSamples
from envlights.rigs.lights import Lights, brightest_first
from envlights.rigs.report import FitReport
from envlights.rigs.rig import Rig, error_of
from envlights.sequence.frame_rig import FrameRig
from envlights.sequence.steadiness import window_weights

#: Stride of the normals at which a rig is measured. It shares no factor with the number of normals
#: in a ring of equal height, so all azimuths occur.
_STRIDE = 7


def thin(samples: MapSamples) -> MapSamples:
    """Every seventh of 5120 normals, which changes the error of three real maps by 0.4 %."""
    return MapSamples(*(array[::_STRIDE] for array in samples))


class FrameFit(NamedTuple):
    """Fit of a frame, with identities of its lights."""

    frame: int
    rig: Rig
    ids: tuple[int, ...]
    samples: MapSamples
    is_search: bool
    is_step: bool


def average(fits: Sequence[FrameFit]) -> FrameRig:
    """Mean rig for the middle of an odd number of consecutive fits.

    Irradiance and ambient radiance are means, and a light counts as black in frames without it, so
    the irradiance of lights that rest is the mean of those of the fits. Directions and radii are
    means over the frames with the light, weighted by its flux.
    """
    middle = fits[len(fits) // 2]
    weights = window_weights(len(fits) // 2)
    ambient = np.einsum("k,k...->...", weights, [each.rig.ambient for each in fits])
    lights, ids = _lights(fits, weights)
    rig = FrameRig(
        ambient,
        lights,
        0.0,
        FitReport(
            measured_on=f"{len(middle.samples.normals)} normals", ambient=middle.rig.report.ambient
        ),
        middle.rig.notes,
        middle.rig.floor,
        middle.frame,
        ids,
        error_of(middle.rig),
        middle.is_search,
        middle.is_step,
    )
    object.__setattr__(rig, "error", error_under(rig, middle.samples))
    return rig


def error_under(rig: Rig, samples: MapSamples) -> float:
    """Relative RMS error of a rig under a map; absolute if the map is black."""
    lights = rig.lights
    return _native.rig_error(
        samples,
        np.atleast_2d(rig.ambient),
        lights.direction,
        lights.irradiance,
        lights.angular_radius.tolist(),
        rig.floor,
    )


def _lights(
    fits: Sequence[FrameFit], weights: NDArray[np.float64]
) -> tuple[Lights, tuple[int, ...]]:
    """Mean lights with their identities, brightest first; black lights are omitted."""
    sums: dict[int, NDArray[np.float64]] = {}
    for weight, each in zip(weights, fits, strict=True):
        lights = each.rig.lights
        flux = lights.luminance[:, None]
        moments = np.hstack(
            [
                lights.irradiance,
                flux * lights.direction,
                flux * lights.angular_radius[:, None],
                flux,
            ]
        )
        for identity, row in zip(each.ids, weight * moments, strict=True):
            sums[identity] = sums.get(identity, 0.0) + row
    rows = np.reshape(list(sums.values()), (-1, 8))
    length = np.linalg.norm(rows[:, 3:6], axis=1)
    is_lit = (rows[:, 7] > 0) & (length > 0)
    rows, ids = rows[is_lit], np.array(list(sums), np.intp)[is_lit]
    order = brightest_first(rows[:, :3])
    rows, ids = rows[order], ids[order]
    direction = rows[:, 3:6] / np.linalg.norm(rows[:, 3:6], axis=1, keepdims=True)
    units = fits[0].rig.units
    lights = Lights(direction, rows[:, :3], rows[:, 6] / rows[:, 7], units=units)
    return lights, tuple(ids.tolist())
