"""A table with a row for each light of each frame."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from envlights._common.tables import csv_text
from envlights._common.units import statement
from envlights.sequence.frame_rig import FrameRig
from envlights.sequence.light_tracks import checked_rigs

HEADER = "frame,kind,id,x,y,z,red,green,blue,angular_radius"
_HEAD = (
    "# envlights sequence CSV, version 1; right-handed, +y up; x, y, z: towards the light; light:"
    " irradiance at normal incidence, angular_radius in radians; ambient: radiance; linear Rec.709"
    " RGB; "
)


def csv(rigs: Iterable[FrameRig]) -> str:
    """Table with a row for each light and one or nine for the ambient term of each frame.

    Examples
    --------
    >>> import envlights as el
    >>> lamp = el.Lights([[0, 1, 0]], [[3, 2, 1]], [0.5])
    >>> print(csv([el.sequence.FrameRig([0, 0, 0], lamp, 0.0, frame=8, ids=(2,))]).splitlines()[2])
    8,light,2,0.0,1.0,0.0,3.0,2.0,1.0,0.5
    """
    rigs = checked_rigs(rigs)
    rows = []
    for rig in rigs:
        lights = rig.lights
        table = np.hstack([lights.direction, lights.irradiance, lights.angular_radius[:, None]])
        numbers = zip(rig.ids, table.tolist(), strict=True)
        rows += [[rig.frame, "light", identity, *row] for identity, row in numbers]
        ambient = np.atleast_2d(rig.ambient).tolist()
        rows += [[rig.frame, "ambient", *[None] * 4, *row, None] for row in ambient]
    return f"{_HEAD}{statement(rigs[0].units)}\n{HEADER}\n{csv_text(rows)}"
