"""Sun of a map: from a clipped sky, from the lights of a float map, or from time and place.

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
| position from time and place                            | `almanac.py`     |
| sun of an argument                                      | `choice.py`      |
| sun as a light, and the sky without it                  | `sun_split.py`   |
| disc in the pixels of a map                             | `disc_pixels.py` |
| notes                                                   | `wording.py`     |
"""

from envlights.sun.almanac import SunAt
from envlights.sun.find import find_sun
from envlights.sun.result import Sun
from envlights.sun.sun_split import SunSplit, with_sun

__all__ = [
    "Sun",
    "SunAt",
    "SunSplit",
    "find_sun",
    "with_sun",
]
