"""Lights of a map.

| step                                                   | file                |
|--------------------------------------------------------|---------------------|
| lights with their measurements, and the report         | `lights.py`         |
| detection by the component tree                        | `component_tree.py` |
| detection by the steps of Loghin (2021)                | `loghin.py`         |
| pixels of the lights                                   | `members.py`        |
| lights whose colour may be damaged                     | `colour_casts.py`   |
| sentences of the reports                               | `wording.py`        |
| `detect`: one of them by name                          | `detect.py`         |
| lights that were removed from a map                    | `removed_lights.py` |
| `split`: lights, and the map without them              | `split.py`          |

The kernels are in `src/kernels/detect/` and `src/kernels/split/`.
"""
