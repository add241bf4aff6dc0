"""`envlights batch`: `envlights.batch` on files."""

from __future__ import annotations

from collections.abc import Sequence
from inspect import signature
from typing import Any

import click

from envlights.batches.batch import batch
from envlights.batches.columns import COLUMNS, SUFFIXES, check_table
from envlights.batches.executors import NAMES
from envlights.batches.result import Batch
from envlights.batches.work import METHODS
from envlights.cli.options.map_input import MapCommand, reading_options
from envlights.cli.options.outputs import default_of, json_option, print_result
from envlights.cli.options.settings import settings_from, settings_option
from envlights.environment.reading import Reading


@click.command("batch", cls=MapCommand)
@click.argument("maps", nargs=-1, required=True, metavar="MAP...")
@click.option(
    "-o",
    "--output",
    "out",
    required=True,
    metavar="DIR",
    help="Folder of the files and of the rows (batch.jsonl); the same folder goes on.",
)
@click.option(
    "--what",
    type=click.Choice(list(METHODS)),
    default=default_of(batch, "what"),
    show_default=True,
    help="Work on each map.",
)
@settings_option("work")
@click.option(
    "--suffix",
    default=default_of(batch, "suffix"),
    show_default=True,
    metavar="SUFFIX",
    help="Format of the file of each map (list: envlights export -h).",
)
@click.option("--jobs", type=int, metavar="N", help="Maps at once; by default one for each core.")
@click.option("--executor", type=click.Choice(NAMES), help="Threads, the default, or processes.")
@click.option(
    "--table", metavar="TABLE", help=f"Also write the rows as a table ({', '.join(SUFFIXES)})."
)
@click.option(
    "--rows",
    type=click.Choice(list(COLUMNS)),
    default=default_of(Batch.save, "of"),
    show_default=True,
    help="Rows of TABLE: one for each light, or for each map, also for those that failed.",
)
@json_option("summary")
@reading_options
@click.pass_context
def command(
    context: click.Context,
    maps: Sequence[str],
    out: str,
    what: str,
    settings: Sequence[str],
    suffix: str,
    jobs: int | None,
    executor: str | None,
    table: str | None,
    rows: str,
    as_json: bool,
    reading: Reading,
) -> None:
    """Do the same work on many maps: files, folders, patterns or lists of paths (.txt, .jsonl).

    A map that fails has a row with the reason, and the exit code is 1.
    """
    if table is not None:
        check_table(table)
    own = signature(batch).parameters
    options = settings_from(settings, "work", lambda name: name.isidentifier() and name not in own)
    how: dict[str, Any] = {"what": what, "suffix": suffix, "executor": executor, "jobs": jobs}
    result = batch(maps, out, reading=reading or None, **how, **options)
    if table is not None:
        result.save(table, rows)
    print_result(result, as_json)
    if result.failures:
        context.exit(1)
