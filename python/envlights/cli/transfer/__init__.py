"""`envlights transfer`: indirect light from direct light."""

from __future__ import annotations

import click

from envlights.cli.transfer import apply, figure, fit


@click.group("transfer")
def command() -> None:
    """Learn indirect light from pairs of images, and predict it.

    A pair shows one scene under one light: a small image of the direct light, direct_NAME.exr, and
    its lightmap of indirect light, lightmap_NAME.exr. A model is learnt from a folder of pairs, and
    says which errors to expect on lights that it has not seen. It then makes lightmaps for new
    direct light:

    \b
      envlights transfer fit ROOM -o room.npz --ridge loo
      envlights transfer apply room.npz direct.exr -o lightmap.exr

    To see how good one is, beside the true lightmap and the best that the model could do:

    \b
      envlights transfer figure room.npz direct.exr lightmap.exr -o frame.png
    """  # noqa: D301, click reads the backspace as: keep these lines


for _each in (fit.command, apply.command, figure.command):
    command.add_command(_each)
