"""Separation of a map into lights and the remaining map.

| step                                | file                |
|-------------------------------------|---------------------|
| detected lights, and the remainder  | `split.py`          |
| radiance above a maximum, as lights | `limit.py`          |
| lights that were removed            | `removed_lights.py` |
"""

from envlights.splitting.limit import Limit
from envlights.splitting.removed_lights import RemovedLights

__all__ = [
    "Limit",
    "RemovedLights",
]
