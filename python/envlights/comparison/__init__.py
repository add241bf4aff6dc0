"""Comparison of the lights of two maps.

| step                                         | file                      |
|----------------------------------------------|---------------------------|
| angles between vectors                       | `angles.py`               |
| angle between the irradiance vectors of maps | `vector_angle.py`         |
| rotation of one set of lights to another     | `common_rotation.py`      |
| difference of two sets as a result           | `light_set_difference.py` |
| measurement of that difference               | `light_sets.py`           |
"""
