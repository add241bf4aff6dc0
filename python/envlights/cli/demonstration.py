"""Demonstrations: a fit to a map, and a transfer model of a room."""

from __future__ import annotations

import os
from pathlib import Path

from envlights import plot
from envlights._common.files import can_draw, check_writable
from envlights.environment.envmap import EnvMap
from envlights.environment.files.image_output import write_exr
from envlights.fitting.fit import fit
from envlights.rigs.rig import Rig
from envlights.synthetic.hall import hall
from envlights.synthetic.room import Room, room
from envlights.transfer import TransferModel, read_pairs

#: Pairs of the room to learn from, and columns of its lightmap.
_PAIRS, _WIDTH = 64, 64


def demo(folder: str | os.PathLike[str] = ".") -> Rig:
    """Make a hall with three bright windows, write it, read it back and fit it.

    Parameters
    ----------
    folder : path-like
        Folder for ``hall.exr``, ``hall.json`` and the picture ``hall.png``, which is left out if
        Matplotlib (extra `plot`) is not installed.

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
    if can_draw():
        plot.save(plot.picture(env, rig), picture)
    return rig


def demo_transfer(
    folder: str | os.PathLike[str] = ".", *, progress: bool | None = None
) -> TransferModel:
    """Make a room under many lamps, learn its indirect light, and predict it under new lamps.

    Parameters
    ----------
    folder : path-like
        Folder for the pairs (``room/direct_0000.exr``, ``room/lightmap_0000.exr``, ...), the model
        ``room.npz``, the direct light ``room_direct.exr`` of a new frame, the predicted lightmap
        ``room_lightmap.exr``, and two pictures: ``room.png`` with the prediction beside the truth,
        ``room_parts.png`` with the lightmap in the room; none without Matplotlib.
    progress : bool, optional
        Progress bars; see `read_pairs`.

    Returns
    -------
    TransferModel
    """
    names = ("room.npz", "room_direct.exr", "room_lightmap.exr", "room.png", "room_parts.png")
    saved, direct, lightmap, picture, parts = (Path(folder) / name for name in names)
    for path in (saved, direct, lightmap, picture, parts):
        check_writable(path)
    # Make the pairs, and one more frame.
    made = room(_PAIRS + 1, _WIDTH)
    Room(made.direct[:_PAIRS], made.indirect[:_PAIRS]).save(Path(folder) / "room")
    # Learn from the files, as from those of any other program.
    pairs = read_pairs(Path(folder) / "room", progress=progress)
    model = TransferModel.fit(pairs.direct, pairs.indirect, ridge="loo", progress=progress)
    model.save(saved)
    # Predict the new frame, and draw it.
    write_exr(direct, made.direct[_PAIRS])
    predicted = model.predict(made.direct[_PAIRS])
    write_exr(lightmap, predicted)
    if can_draw():
        frame = made.direct[_PAIRS], made.indirect[_PAIRS]
        plot.save(plot.transfer_picture(model, *frame), picture)
        plot.save(plot.room_picture(frame[0], predicted), parts)
    return model
