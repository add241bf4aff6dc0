"""From a map, or from a measured probe, to a rig.

| step                                                                | file         |
|---------------------------------------------------------------------|--------------|
| what was asked for: how many lights, how good, from where           | `asked.py`   |
| the kernel's options, as one object                                 | `options.py` |
| the kernel's answer, as a rig with its report                       | `answer.py`  |
| what the report says in words                                       | `notes.py`   |
| `fit` and `fit_probe`: check, call the kernel, report               | `fit.py`     |
| the paper's own fit, for comparison                                 | `madsen.py`  |

The search itself is `src/kernels/fit/`; the report is a part of the rig: `envlights.report`.
"""
