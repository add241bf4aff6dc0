"""`envlights vary`: `envlights.vary` on files of rigs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import click

from envlights._common.tables import json_lines
from envlights.cli.options.outputs import (
    check_output,
    check_source,
    default_of,
    print_losses,
    say_written,
    stage_of,
    stage_options,
)
from envlights.export.exposure import with_exposure
from envlights.export.files import save_scene
from envlights.export.saving import check_options, save
from envlights.export.targets import SUFFIXES, Target, target_of
from envlights.rigs.rig import Rig
from envlights.rigs.vary import Variation, vary


class _Span(click.ParamType[Any]):
    """Number, or a range LOW,HIGH."""

    name = "LOW,HIGH"

    def convert(self, value: Any, _: Any, __: Any) -> Any:
        """Numbers parsed from text; `vary` checks their count."""
        if not isinstance(value, str):
            return value
        try:
            ends = tuple(map(float, value.split(",")))
        except ValueError:
            self.fail(f"{value!r} is neither a number nor LOW,HIGH")
        return ends[0] if len(ends) == 1 else ends


def _span(name: str, help_text: str) -> Callable[[Any], Any]:
    return click.option(
        f"--{name}", type=_Span(), default=default_of(vary, name), show_default=True, help=help_text
    )


@click.command("vary")
@click.argument("paths", metavar="RIG...", nargs=-1, required=True)
@click.option("-n", "--count", type=int, default=10, show_default=True, help="Number of rigs.")
@click.option(
    "-o",
    "--output",
    required=True,
    metavar="OUT",
    help="File for the program of its suffix; rigs/hall.usda writes rigs/hall.0000.usda and so on,"
    " and rigs/hall.jsonl, a line of JSON on what was changed in each.",
)
@click.option("--seed", type=int, default=default_of(vary, "seed"), show_default=True, help="Seed.")
@_span("azimuth", "Degrees by which rigs are turned.")
@_span("exposure", "Stops by which they become brighter.")
@_span("temperature", "Colour temperature of white light, in kelvins; 6504 changes nothing.")
@_span("mix", "Weight of a second RIG, from 0 to 1.")
@click.option(
    "--drop",
    type=float,
    default=default_of(vary, "drop"),
    show_default=True,
    help="Probability of each light to be left out.",
)
@click.option(
    "--jitter",
    type=float,
    default=default_of(vary, "jitter"),
    show_default=True,
    help="Largest movement of a light, relative to its direction tolerance.",
)
@stage_options
def command(
    paths: Sequence[str], count: int, output: str, stage: dict[str, Any], **ranges: Any
) -> None:
    """Vary each RIG, a file of `fit` (.json), at random, for training."""
    check_output(output, SUFFIXES, {})
    check_options((target_of(output),), stage)
    variations = list(vary(map(Rig.load, paths), count, **ranges))
    options = {**stage_of(output, stage), **_one_exposure(target_of(output), variations)}
    suffix = max((each for each in SUFFIXES if output.lower().endswith(each)), key=len)
    stem = output[: -len(suffix)]
    table, digits = f"{stem}.jsonl", max(4, len(str(count - 1)))
    files = [f"{stem}.{number:0{digits}}{suffix}" for number in range(count)]
    for number, path in enumerate(paths):
        for file in (*files, table):
            check_source(file, {f"rig {number + 1}": path})
    rows = []
    with print_losses():
        for each in variations:
            file = files[each.number]
            save(each.rig, file, **options)
            rows.append({"file": Path(file).name, **each.changes()})
    save_scene(table, json_lines(rows))
    say_written([f"{stem}.*{suffix}", table])


def _one_exposure(target: Target, variations: Iterable[Variation]) -> dict[str, float]:
    """Scale of the pixels at which none is clipped, for a program whose files have one each."""
    if "scale" not in target.options:
        return {}
    scales = [with_exposure(target.name, each.rig, None, None)[1] for each in variations]
    return {"scale": min(scales, default=1.0)}
