"""`envlights transfer fit`: `envlights.TransferModel.fit` on a folder of pairs."""

from __future__ import annotations

import json

import click

from envlights._common.files import check_writable
from envlights._common.printable import printable
from envlights.cli.options.outputs import json_option, say_written
from envlights.transfer.files.database import read_pairs
from envlights.transfer.files.npz_file import check_suffix
from envlights.transfer.model import TransferModel
from envlights.transfer.prior import TransferPrior


def _rank(text: str) -> int | float:
    try:
        return float(text) if "." in text else int(text)
    except ValueError:
        raise click.BadParameter(
            f"give a whole number, or a fraction such as 0.99; got {text}"
        ) from None


@click.command("fit")
@click.argument("folder", metavar="FOLDER")
@click.option("-o", "--output", required=True, metavar="MODEL", help="File to write (.npz).")
@click.option(
    "--rank",
    type=_rank,
    metavar="RANK",
    help="Largest number of directions, or the fraction of the energy in them, such as 0.99."
    " [default: 64; as many as the errors need with a prior]",
)
@click.option(
    "--ridge",
    metavar="RIDGE",
    help="Regularisation: a number, or loo for the best one. [default: 0.001; loo if nonnegative"
    " or with a prior]",
)
@click.option(
    "--nonnegative",
    is_flag=True,
    help="No light darkens a texel: smaller errors for new lights, and a slower fit.",
)
@click.option(
    "--prior", metavar="PRIOR", help="File of a prior by the geometry of the scene (.npz)."
)
@click.option(
    "--error", type=float, help="Largest error; the fewest directions that reach it are used."
)
@json_option("report")
def command(
    folder: str,
    output: str,
    rank: int | float | None,
    ridge: str | None,
    nonnegative: bool,
    prior: str | None,
    error: float | None,
    as_json: bool,
) -> None:
    """Learn a model from the pairs in FOLDER.

    They are called direct_NAME.exr and lightmap_NAME.exr, one pair for each NAME. The images go
    through a file in TMPDIR: a database may be larger than memory.
    """
    check_suffix(output)
    check_writable(output)
    geometry = None if prior is None else TransferPrior.load(prior)
    pairs = read_pairs(folder, progress=True)
    for note in pairs.notes:
        click.echo(f"note: {printable(note)}", err=True)
    model = TransferModel.fit(
        pairs.direct,
        pairs.indirect,
        rank,
        None if ridge is None else _ridge(ridge),
        error=error,
        nonnegative=nonnegative,
        prior=geometry,
        progress=True,
    )
    model.save(output)
    click.echo(json.dumps(model.report.to_dict(), indent=2) if as_json else str(model))
    say_written([output])


def _ridge(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text
