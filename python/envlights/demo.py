"""A first try: make a map, fit it, and draw the result."""

from __future__ import annotations

import os
from pathlib import Path

from envlights import plot
from envlights.envmap import EnvMap
from envlights.fitting.fit import fit
from envlights.io.files import check_writable
from envlights.io.image_output import write_exr
from envlights.rig import Rig
from envlights.synthetic.hall import hall


def demo(folder: str | os.PathLike[str] = ".") -> Rig:
    """Make a hall with three bright windows, write it, read it back and fit it.

    Parameters
    ----------
    folder : path-like
        Where ``hall.exr``, ``hall.json`` and the picture ``hall.png`` are written.

    Returns
    -------
    Rig
        Ambient and four lights: three at the windows, one for the white wall opposite.
    """
    exr, saved, picture = (Path(folder) / f"hall.{suffix}" for suffix in ("exr", "json", "png"))
    for path in (exr, saved, picture):
        check_writable(path)
    write_exr(exr, hall().radiance)
    env = EnvMap.open(exr)
    rig = fit(env, lights=4)
    rig.save(saved)
    plot.save(plot.picture(env, rig), picture)
    return rig
