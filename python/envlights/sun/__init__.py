"""The sun of a map: found in the picture, or computed from time and place.

| step                                   | file           |
|----------------------------------------|----------------|
| search                                 | `find.py`      |
| result                                 | `result.py`    |
| position from time and place           | `almanac.py`   |
"""

from envlights.sun.almanac import SunAt as SunAt
from envlights.sun.find import find_sun as find_sun
from envlights.sun.result import Sun as Sun
