"""`envlights transfer figure`: `plot.transfer_picture` on files."""

from __future__ import annotations

import click

from envlights._common.files import PICTURES
from envlights.cli.options.outputs import check_output, say_written
from envlights.environment.files.images import read_image
from envlights.transfer.model import TransferModel


@click.command("figure")
@click.argument("model_path", metavar="MODEL")
@click.argument("direct_path", metavar="DIRECT")
@click.argument("indirect_path", metavar="INDIRECT")
@click.option(
    "-o", "--output", required=True, metavar="PICTURE", help="File to write (.png, .pdf, .svg)."
)
def command(model_path: str, direct_path: str, indirect_path: str, output: str) -> None:
    """Draw a predicted frame beside the truth.

    The five images are DIRECT; INDIRECT, the truth; the prediction of MODEL for DIRECT; the
    projection of INDIRECT, the best that MODEL could do; and the prediction minus the truth. The
    titles hold relative errors.
    """
    inputs = {
        "the model": model_path,
        "the direct light": direct_path,
        "the indirect light": indirect_path,
    }
    check_output(output, PICTURES, inputs)
    model = TransferModel.load(model_path)
    direct, indirect = (read_image(path).pixels for path in (direct_path, indirect_path))
    from envlights import plot

    plot.save(plot.transfer_picture(model, direct, indirect), output)
    say_written([output])
