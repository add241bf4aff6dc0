"""From a map, or from a measured probe, to a rig.

| step                                                                    | file          |
|-------------------------------------------------------------------------|---------------|
| irradiance at the normals that are fitted, and at those that judge      | `normals.py`  |
| the kernel's solutions, and the rig of the one that is worth its lights | `solution.py` |
| `fit` and `fit_probe`: check what was asked for, solve, report          | `fit.py`      |
| the paper's own fit, for comparison                                     | `madsen.py`   |

The search itself is `src/kernels/fit/`; the report is a part of the rig: `envlights.report`.
"""
