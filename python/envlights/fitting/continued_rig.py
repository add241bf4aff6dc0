"""Rig that continues a known one under the next map of a sequence."""

from __future__ import annotations

import numpy as np

from envlights import _native
from envlights.fitting import wording
from envlights.fitting.ambient_terms import AMBIENTS
from envlights.fitting.arguments import FitArguments
from envlights.fitting.map_fit import MapSamples
from envlights.fitting.options import FitOptions
from envlights.fitting.reduction import Reduction
from envlights.lights import Lights, brightest_first
from envlights.report import FitReport
from envlights.rig import Rig


def continue_rig(
    reduction: Reduction, arguments: FitArguments, lights: Lights, ambient: str
) -> tuple[Rig, MapSamples]:
    """Rig of the minimum near `lights` with sizes, and the irradiance under the map.

    No other lights are searched for, and those that are black there are left out. The report holds
    the errors alone.
    """
    options = FitOptions(
        AMBIENTS[ambient],
        lights.direction,
        0,
        len(lights),
        sizes=arguments.objective,
        max_radius=arguments.max_radius,
    )
    answer = _native.continue_reduced(reduction.cells, options, lights.angular_radius)
    sky, direction, irradiance, radii, error, objective_error, samples = answer
    order = brightest_first(irradiance)
    rows = direction[order], irradiance[order], np.array(radii)[order]
    rig = Rig(
        sky if len(sky) > 1 else sky.sum(axis=0),
        Lights.unchecked(*rows, reduction.units),
        error,
        FitReport(
            objective_error=objective_error,
            measured_on=wording.measured_on(len(samples[1]), arguments.floor),
            ambient=ambient,
        ),
        (*reduction.notes, *wording.clipping(reduction.clipped_flux_fraction)),
        arguments.floor,
    )
    return rig, MapSamples(*samples)
