"""Lights of a map.

| step                                                   | file                |
|--------------------------------------------------------|---------------------|
| lights with their measurements, and the report         | `lights.py`         |
| detection by the component tree                        | `component_tree.py` |
| detection by the steps of Loghin (2021)                | `loghin.py`         |
| sentences of the reports                               | `wording.py`        |
| `detect`: one of them by name                          | `detect.py`         |
| lights that were removed from a map                    | `removed_lights.py` |
| `split`: those, and the map without them               | `split.py`          |

Each is a few calls: thresholds and components are in `src/kernels/detect/`.
"""
