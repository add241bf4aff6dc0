"""The sun of a map: in an 8-bit sky, or among the lights of a float map.

| step                                                    | file             |
|---------------------------------------------------------|------------------|
| the search                                              | `find.py`        |
| reduced image, clipped core and sky                     | `sky_image.py`   |
| a single small spot in smooth sky                       | `spots.py`       |
| the best part of the core                               | `parts.py`       |
| azimuth by symmetry                                     | `symmetry.py`    |
| elevation by a fit of a clear sky, and the tone         | `sky_fit.py`     |
| direction and its uncertainty                           | `direction.py`   |
| eight questions                                         | `questions.py`   |
| irradiance                                              | `brightness.py`  |
| sky behind the sun                                      | `plateau.py`     |
| sun of a map that is not clipped                        | `float_map.py`   |
| result                                                  | `result.py`      |
"""

from envlights.sun.find import find_sun as find_sun
from envlights.sun.result import Sun as Sun
