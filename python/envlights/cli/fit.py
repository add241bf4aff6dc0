"""`envlights fit`: `envlights.fit` on a file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from envlights.cli.outputs import (
    OUTPUTS,
    check_output,
    default_of,
    output_option,
    print_rig,
    say_written,
)
from envlights.envmap import EnvMap
from envlights.export.targets import SUFFIXES
from envlights.fitting.fit import AMBIENTS, AUTO, fit
from envlights.io.files import PICTURES
from envlights.rig import Rig


@click.command("fit")
@click.argument("map_path", metavar="MAP")
@click.option("-n", "--lights", type=int, help="Lights, at most; 4 when left out.")
@click.option("--error", type=float, help="Use the fewest lights with at most this error: 0.01.")
@click.option(
    "--shadow-error", type=float, help="Use the fewest with at most this error of shadows: 0.05."
)
@click.option(
    "--sizes/--points", default=default_of(fit, "sizes"), help="Lights as discs, or as points."
)
@click.option(
    "--ambient",
    type=click.Choice([*AMBIENTS, AUTO]),
    default=default_of(fit, "ambient"),
    show_default=True,
    help="The environment beside the lights; sh2: nine spherical harmonics; auto: what pays.",
)
@click.option(
    "--floor", is_flag=True, help="A floor in the scene hides all light from below the horizon."
)
@output_option(OUTPUTS)
@click.option("--json", "as_json", is_flag=True, help="Print the rig as JSON.")
def command(
    map_path: str,
    lights: int | None,
    error: float | None,
    shadow_error: float | None,
    sizes: bool,
    ambient: str,
    floor: bool,
    outputs: Sequence[str],
    as_json: bool,
) -> None:
    """Fit ambient and a few lights to MAP (.hdr, .exr, .png, .jpg, .tif)."""
    for output in outputs:
        check_output(output, (*SUFFIXES, *PICTURES), {"the map": map_path})
    env = EnvMap.open(map_path)
    rig = fit(
        env,
        lights,
        error=error,
        shadow_error=shadow_error,
        sizes=sizes,
        ambient=ambient,
        floor=floor,
    )
    for output in outputs:
        _write(env, rig, output)
    print_rig(rig, as_json)
    say_written(outputs)


def _write(env: EnvMap, rig: Rig, output: str) -> None:
    if Path(output).suffix.lower() not in PICTURES:
        rig.save(output)
        return
    # Drawing takes a second to import; a rig alone does not need it.
    from envlights import plot

    plot.save(plot.picture(env, rig), output)
