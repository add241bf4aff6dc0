"""Rigs over a sequence of maps.

| step                                                          | file               |
|---------------------------------------------------------------|--------------------|
| files, videos and arrays as frames                            | `frames.py`, `video.py` |
| fits that continue the last frame, and full searches          | `continuation.py`  |
| identities of the lights                                      | `identity.py`, `assignment.py` |
| steps of the light                                            | `steps.py`         |
| window, and mean of the rigs in it                            | `steadiness.py`, `window.py` |
| rig of a frame, rigs of all frames                            | `frame_rig.py`, `rig_sequence.py` |
| the function that does it                                     | `follow.py`        |
"""

from envlights.sequence.follow import RigStream, follow
from envlights.sequence.frame_rig import FrameRig
from envlights.sequence.rig_sequence import RigSequence

__all__ = ["FrameRig", "RigSequence", "RigStream", "follow"]
