"""Fit of a rig to a map, or to a measured probe.

| step                                                                | file         |
|---------------------------------------------------------------------|--------------|
| checked arguments: number of lights, errors, start, fixed lights    | `request.py` |
| ambient terms for a target and over a floor                         | `ambient_terms.py` |
| options of the kernel, as one object                                | `options.py` |
| rig and report from the kernel's result                             | `result.py`  |
| sentences of the report                                             | `wording.py` |
| arguments of `fit`, as one object                                   | `arguments.py` |
| the fit to a map: check, reduce, call the kernel, report            | `map_fit.py` |
| a rig that continues a known one, for sequences                     | `continued_rig.py` |
| `fit` and `fit_probe`                                               | `fit.py`     |
| errors by number of lights                                          | `error_curve.py` |
| the sun as one light, and the fit to the sky around it              | `sun_light.py` |
| the fit of Madsen et al. (2003), for comparison                     | `madsen.py`  |

`src/kernels/fit/` holds the search. The report belongs to the rig and has its own module,
`envlights.rigs.report`.
"""

from envlights.fitting.error_curve import ErrorCurve

__all__ = [
    "ErrorCurve",
]
