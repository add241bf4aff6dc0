"""The worst cases of a fit beside a usual one: run time, and changes under another scale.

`scaled` is the largest change at scales of 1e-6 and 1e9: of the rig's irradiance relative to the
brightest, of the directions, and of the lights' irradiance relative to the brightest light.
"""

import numpy as np
import stopwatch
from tests.fitting import worst_cases
from tests.helpers import NORMALS, SOLID_ANGLES

import envlights as el

SCALES = (1e-6, 1e9)


def table():
    cases = {"a usual map": worst_cases.hall(), **worst_cases.cases()}
    for lights in (4, 8):
        print(f"\nworst cases, {lights} lights; time over that of the usual map")
        print(f"{'':<32}{'lights':>7}{'error':>9}{'time':>9}   scaled: probe, directions, lights")
        work = {
            name: lambda e=irradiance, m=lights: fit_probe(e, m)
            for name, irradiance in cases.items()
        }
        seconds = stopwatch.least_seconds(work)
        usual = seconds["a usual map"]
        for name, irradiance in cases.items():
            rig = fit_probe(irradiance, lights)
            assert np.isfinite(rig.lights.direction).all(), name
            assert (rig.lights.irradiance >= 0).all(), name
            changes = "".join(f"{change:>10.0e}" for change in scale_changes(irradiance, lights))
            time = f"{seconds[name] / usual:>7.2f} x"
            print(f"{name:<32}{len(rig.lights):>7}{rig.error:>9.0e}{time}  {changes}", flush=True)


def fit_probe(irradiance, lights):
    return el.fit_probe(NORMALS, irradiance, lights, weights=SOLID_ANGLES)


def scale_changes(irradiance, lights):
    """Largest changes under another scale; infinite where the number of lights changes."""
    one, changes = fit_probe(irradiance, lights), []
    for scale in SCALES:
        other = fit_probe(scale * irradiance, lights)
        if len(other.lights) != len(one.lights):
            return (np.inf,) * 3
        changes.append(
            (
                change(other.probe(NORMALS) / scale, one.probe(NORMALS)),
                np.abs(other.lights.direction - one.lights.direction).max(initial=0),
                change(other.lights.irradiance / scale, one.lights.irradiance),
            )
        )
    return np.max(changes, axis=0)


def change(other, one):
    return np.abs(other - one).max(initial=0) / (np.abs(one).max(initial=0) or 1)
