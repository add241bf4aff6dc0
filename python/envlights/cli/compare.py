"""`envlights compare`: `compare` on two files, `compare_folders` on two folders."""

from __future__ import annotations

from pathlib import Path

import click

from envlights._common.tables import json_text, save_table
from envlights._native import EnvLightsError
from envlights.cli.options.map_input import MapCommand, reading_options
from envlights.cli.options.outputs import (
    check_output,
    default_of,
    json_option,
    print_result,
    say_written,
)
from envlights.comparison.compare import Comparison, compare
from envlights.comparison.folders import FolderComparison, compare_folders
from envlights.comparison.protocol import PROTOCOLS
from envlights.environment.reading import Reading


@click.command("compare", cls=MapCommand)
@click.argument("truth", metavar="TRUTH")
@click.argument("guess", metavar="GUESS")
@click.option(
    "--protocol",
    default=default_of(compare, "protocol"),
    show_default=True,
    metavar="NAME",
    help=f"Rules of the comparison: {', '.join(PROTOCOLS)}.",
)
@click.option("-o", "--output", metavar="OUT", help="Table to write (.csv, .json).")
@json_option("comparison")
@reading_options
def command(
    truth: str,
    guess: str,
    protocol: str,
    output: str | None,
    as_json: bool,
    reading: Reading,
) -> None:
    """Compare the lighting GUESS with TRUTH.

    Both are maps (.hdr, .exr, .png, .jpg, .tif), rigs or lights (.json, .csv), or both are folders
    of such files, which are paired by name. The exit code is 1 if a file of a folder failed.
    """
    if output is not None:
        check_output(output, (".csv", ".json"), {"the truth": truth, "the guess": guess})
    folders = _are_folders(truth, guess)
    if folders:
        table = compare_folders(truth, guess, protocol, reading=reading or None)
        result: FolderComparison | Comparison = table
    else:
        result = compare(truth, guess, protocol, reading=reading or None)
        table = FolderComparison(result.protocol, {Path(truth).stem: result}, {})
    if output is not None:
        save_table(output, {".csv": table.to_csv, ".json": lambda: json_text(result.to_dict())})
    print_result(result, as_json)
    say_written([] if output is None else [output])
    if table.failures:
        raise SystemExit(1)


def _are_folders(truth: str, guess: str) -> bool:
    """True if both paths are folders; raises an error if only one is."""
    are_folders = [Path(path).is_dir() for path in (truth, guess)]
    if any(are_folders) and not all(are_folders):
        raise EnvLightsError("TRUTH and GUESS must both be files, or both be folders")
    return all(are_folders)
