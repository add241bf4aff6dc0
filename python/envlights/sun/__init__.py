"""The sun of a map: found in the picture, or computed from time and place.

| step                                   | file           |
|----------------------------------------|----------------|
| search                                 | `find.py`      |
| result                                 | `result.py`    |
| position from time and place           | `almanac.py`   |
| sun of an argument                     | `choice.py`    |
| sun as a light, and the sky without it | `sun_split.py` |
| disc in the pixels of a map            | `disc_pixels.py`, `repair.py` |
| notes                                  | `wording.py`   |
"""

from envlights.sun.almanac import SunAt as SunAt
from envlights.sun.find import find_sun as find_sun
from envlights.sun.repair import repair_with_sun as repair_with_sun
from envlights.sun.result import Sun as Sun
from envlights.sun.sun_split import SunSplit as SunSplit
from envlights.sun.sun_split import with_sun as with_sun
