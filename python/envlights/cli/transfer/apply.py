"""`envlights transfer apply`: `TransferModel.predict` on a file."""

from __future__ import annotations

import click

from envlights.cli.options.outputs import check_output, default_of, say_written
from envlights.environment.files.image_output import write_exr
from envlights.environment.files.images import read_image
from envlights.transfer.model import TransferModel


@click.command("apply")
@click.argument("model_path", metavar="MODEL")
@click.argument("direct_path", metavar="DIRECT")
@click.option("-o", "--output", required=True, metavar="OUT", help="File to write (.exr).")
@click.option(
    "--error",
    type=float,
    default=default_of(TransferModel.predict, "error"),
    help="Largest relative error of the prediction that saves time.",
    show_default=True,
)
def command(model_path: str, direct_path: str, output: str, error: float) -> None:
    """Predict the indirect light for DIRECT (.exr)."""
    inputs = {"the model": model_path, "the direct light": direct_path}
    check_output(output, (".exr",), inputs)
    model = TransferModel.load(model_path)
    predicted = model.predict(read_image(direct_path).pixels, error=error)
    write_exr(output, predicted.astype("float32", copy=False))
    say_written([output])
