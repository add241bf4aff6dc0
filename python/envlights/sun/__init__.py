"""The sun of a map, found in an 8-bit sky or among the lights of a float map.

| step                                   | file           |
|----------------------------------------|----------------|
| search                                 | `find.py`      |
| result                                 | `result.py`    |
"""

from envlights.sun.find import find_sun as find_sun
from envlights.sun.result import Sun as Sun
