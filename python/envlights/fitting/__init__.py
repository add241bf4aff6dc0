"""Fit of a rig to a map, or to measured irradiance.

| step                                                                | file         |
|---------------------------------------------------------------------|--------------|
| arguments of `fit` and their checks, ambient terms, kernel's options | `request.py` |
| the map, filled and reduced                                         | `reduction.py` |
| rig and report from the kernel's result                             | `result.py`  |
| sentences of the report                                             | `wording.py` |
| the fit to a map: check, reduce, call the kernel, report            | `map_fit.py` |
| `fit` and `fit_probe`                                               | `fit.py`     |
| errors of any rig on any map                                        | `measure.py` |
| errors by number of lights                                          | `error_curve.py` |
| the sun as one light, and the fit to the sky around it              | `sun_light.py` |

`src/kernels/fit/` holds the search. The report belongs to the rig and has its own module,
`envlights.rigs.report`.
"""

from envlights.fitting.error_curve import ErrorCurve

__all__ = [
    "ErrorCurve",
]
