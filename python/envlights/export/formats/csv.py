"""A table of numbers: for spreadsheets, NumPy and the like."""

from __future__ import annotations

import numpy as np

from envlights._common.tables import csv_text
from envlights.export.files import AnyPath, save_scene
from envlights.export.formats.csv_table import AMBIENTS, FORMAT, HEADER, SCALE
from envlights.export.scene import Exportable, check_rig

_FRAME = (
    "# right-handed, +y up; image centre +z, left quarter +x; x, y, z: towards the light;"
    " light: irradiance at normal incidence, angular_radius in radians; ambient: radiance;"
    " linear Rec.709 RGB"
)


def csv(rig: Exportable) -> str:
    """Lossless table with a row for each light and for the ambient term (nine for harmonics).

    Comments that begin with ``#`` give frame and units.

    See Also
    --------
    read_csv : the inverse.

    Examples
    --------
    >>> import envlights as el
    >>> print(el.export.csv(el.Lights([[0, 1, 0]], [[3, 2, 1]], [0.5])).splitlines()[-1])
    light,0.0,1.0,0.0,3.0,2.0,1.0,0.5
    """
    lights = check_rig(rig).discs()
    lines = [FORMAT, f"{_FRAME}{SCALE}{lights.units}"]
    ambient = getattr(rig, "ambient", None)
    if ambient is not None:
        floor = ", over a floor" if getattr(rig, "floor", False) else ""
        lines.append(f"# relative RMS error {getattr(rig, 'error', 0.0)!r}{floor}")
    lines += [f"# note: {note}" for note in lights.notes]
    arrays = lights.direction, lights.irradiance, lights.angular_radius[:, None]
    rows = [["light", *row] for row in np.hstack(arrays).tolist()]
    if ambient is not None:
        values = np.atleast_2d(ambient).tolist()
        names = AMBIENTS[len(values) > 1]
        rows += [[name, *[None] * 3, *row, None] for name, row in zip(names, values, strict=True)]
    return "\n".join([*lines, HEADER, csv_text(rows)])


def save_csv(rig: Exportable, path: AnyPath) -> None:
    """Write `csv` at `path`."""
    save_scene(path, csv(rig))
