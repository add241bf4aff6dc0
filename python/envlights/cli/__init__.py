"""The command line: one subcommand, one public function."""

from __future__ import annotations

import errno
import inspect
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import click

import envlights
from envlights.detection.detect import METHODS
from envlights.fitting.fit import AMBIENTS, NORMALS
from envlights.io.files import PICTURES, check_writable, write_atomically
from envlights.io.images import read_image, write_exr
from envlights.rig import Rig
from envlights.transfer.archive import check_suffix


class _Refusing(click.Group):
    """A group whose refusals are a sentence and the exit code 2, not a traceback."""

    def invoke(self, context: click.Context) -> Any:
        try:
            return super().invoke(context)
        except envlights.EnvLightsError as refusal:
            click.echo(f"envlights: {refusal}", err=True)
            context.exit(2)
        except OSError as error:
            if error.errno == errno.EPIPE:
                raise  # `| head`: click ends quietly
            click.echo(f"envlights: cannot print the answer: {error.strerror}", err=True)
            context.exit(2)


def _default(function: Callable[..., Any], parameter: str) -> Any:
    """What Python takes when the parameter is left out."""
    return inspect.signature(function).parameters[parameter].default


def _outputs(help_text: str) -> Callable[[Any], Any]:
    return click.option("-o", "--output", "outputs", multiple=True, metavar="OUT", help=help_text)


@click.group(cls=_Refusing, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="envlights", prog_name="envlights")
def main() -> None:
    """Turn an environment map into a handful of lights."""


@main.command()
@click.argument("map_path", metavar="MAP")
@click.option("-n", "--lights", type=int, help="Directional lights, at most; 4 when left out.")
@click.option("--error", type=float, help="Use the fewest lights with at most this error: 0.01.")
@click.option(
    "--ambient",
    type=click.Choice(list(AMBIENTS)),
    default=_default(envlights.fit, "ambient"),
    show_default=True,
    help="The environment beside the lights; sh2: nine spherical harmonics.",
)
@click.option(
    "--normals",
    type=click.Choice(NORMALS),
    default=_default(envlights.fit, "normals"),
    show_default=True,
    help="Surfaces that count; upper: those that face up, for things on a floor.",
)
@_outputs("Write the rig (.json) or a picture (.png, .pdf, .svg); may be given again.")
@click.option("--json", "as_json", is_flag=True, help="Print the rig as JSON.")
def fit(
    map_path: str,
    lights: int | None,
    error: float | None,
    ambient: str,
    normals: str,
    outputs: Sequence[str],
    as_json: bool,
) -> None:
    """Fit ambient and directional lights to MAP (.hdr, .exr, .png, .jpg, .tif)."""
    for output in outputs:
        _check_output(output, (".json", *PICTURES), {"the map": map_path})
    env = envlights.EnvMap.open(map_path)
    rig = envlights.fit(env, lights, error=error, ambient=ambient, normals=normals)
    for output in outputs:
        _write(env, rig, output)
    _print(rig, as_json)
    _say_written(outputs)


@main.command()
@click.argument("map_path", metavar="MAP")
@click.option("-n", "--max-lights", type=int, help="Merge neighbours until there are no more.")
@click.option(
    "--method",
    type=click.Choice(list(METHODS)),
    default=_default(envlights.detect, "method"),
    show_default=True,
    help="How bright places are found.",
)
@_outputs("Write the lights (.json) or a picture (.png, .pdf, .svg); may be given again.")
@click.option("--json", "as_json", is_flag=True, help="Print the lights as JSON.")
def detect(
    map_path: str, max_lights: int | None, method: str, outputs: Sequence[str], as_json: bool
) -> None:
    """Find the bright places of MAP (.hdr, .exr, .png, .jpg, .tif)."""
    for output in outputs:
        _check_output(output, (".json", *PICTURES), {"the map": map_path})
    env = envlights.EnvMap.open(map_path)
    lights = envlights.detect(env, method, max_lights=max_lights)
    for output in outputs:
        _write_lights(env, lights, output)
    click.echo(json.dumps(lights.to_dict(), indent=2) if as_json else str(lights))
    _say_written(outputs)


@main.command()
@click.option(
    "-o",
    "--output",
    "folder",
    default=".",
    metavar="FOLDER",
    help="Where the files go.",
    show_default=True,
)
@click.option("--json", "as_json", is_flag=True, help="Print the rig as JSON.")
def demo(folder: str, as_json: bool) -> None:
    """Make a hall with three bright windows, fit it, and draw the result."""
    from envlights.demo import demo as run

    _print(run(folder), as_json)
    _say_written([str(Path(folder) / f"hall.{suffix}") for suffix in ("exr", "json", "png")])


def _rank(text: str) -> int | float:
    try:
        return float(text) if "." in text else int(text)
    except ValueError:
        raise click.BadParameter(
            f"give a whole number, or a share such as 0.99; got {text}"
        ) from None


@main.group()
def transfer() -> None:
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


@transfer.command("fit")
@click.argument("folder", metavar="FOLDER")
@click.option("-o", "--output", required=True, metavar="MODEL", help="Where the model goes: .npz.")
@click.option(
    "--rank",
    type=_rank,
    default=str(_default(envlights.TransferModel.fit, "rank")),
    show_default=True,
    metavar="RANK",
    help="Directions, at most; or the share of the energy that they hold: 0.99.",
)
@click.option(
    "--ridge",
    default=str(_default(envlights.TransferModel.fit, "ridge")),
    show_default=True,
    help="A number, or loo: the best one.",
)
@click.option("--error", type=float, help="Use the fewest directions with at most this error.")
@click.option("--json", "as_json", is_flag=True, help="Print the report as JSON.")
def transfer_fit(
    folder: str, output: str, rank: int | float, ridge: str, error: float | None, as_json: bool
) -> None:
    """Learn a model from the pairs in FOLDER.

    They are called direct_NAME.exr and lightmap_NAME.exr, one pair for each NAME. The images go
    through a file in TMPDIR: a database may be larger than memory.
    """
    check_suffix(output)
    check_writable(output)
    pairs = envlights.read_pairs(folder, progress=True)
    for note in pairs.notes:
        click.echo(f"note: {note}", err=True)
    model = envlights.TransferModel.fit(
        pairs.direct, pairs.indirect, rank, _ridge(ridge), error=error
    )
    model.save(output)
    click.echo(json.dumps(model.report.to_dict(), indent=2) if as_json else str(model))
    _say_written([output])


@transfer.command("apply")
@click.argument("model_path", metavar="MODEL")
@click.argument("direct_path", metavar="DIRECT")
@click.option("-o", "--output", required=True, metavar="OUT", help="Where the image goes: .exr.")
def transfer_apply(model_path: str, direct_path: str, output: str) -> None:
    """Predict the indirect light for DIRECT (.exr)."""
    inputs = {"the model": model_path, "the direct light": direct_path}
    _check_output(output, (".exr",), inputs)
    model = envlights.TransferModel.load(model_path)
    predicted = model.predict(read_image(direct_path).pixels)
    write_exr(output, predicted.astype("float32", copy=False))
    _say_written([output])


@transfer.command("figure")
@click.argument("model_path", metavar="MODEL")
@click.argument("direct_path", metavar="DIRECT")
@click.argument("indirect_path", metavar="INDIRECT")
@click.option(
    "-o", "--output", required=True, metavar="PICTURE", help="Where it goes: .png, .pdf or .svg."
)
def transfer_figure(model_path: str, direct_path: str, indirect_path: str, output: str) -> None:
    """Draw a predicted frame beside the truth.

    Four images: INDIRECT, which is the truth; what MODEL predicts for DIRECT; the projection of
    INDIRECT, which is the best that MODEL could do; and what the prediction misses. The titles hold
    relative errors.
    """
    inputs = {
        "the model": model_path,
        "the direct light": direct_path,
        "the indirect light": indirect_path,
    }
    _check_output(output, PICTURES, inputs)
    model = envlights.TransferModel.load(model_path)
    direct, indirect = (read_image(path).pixels for path in (direct_path, indirect_path))
    from envlights import plot

    plot.save(plot.transfer_picture(model, direct, indirect), output)
    _say_written([output])


def _ridge(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def _say_written(paths: Sequence[str]) -> None:
    """Said last: files are whole before anything is printed, and nobody may be listening."""
    for path in paths:
        click.echo(f"wrote {path}", err=True)


def _print(rig: Rig, as_json: bool) -> None:
    click.echo(json.dumps(rig.to_dict(), indent=2) if as_json else f"{rig}\n\n{rig.report}")


def _check_output(output: str, suffixes: tuple[str, ...], inputs: Mapping[str, str]) -> None:
    """Refuse an output of another kind, or one that is an input."""
    if Path(output).suffix.lower() not in suffixes:
        wanted = f"one of {', '.join(suffixes)}" if suffixes[1:] else suffixes[0]
        raise envlights.EnvLightsError(f"cannot write {output}: the suffix must be {wanted}")
    target = check_writable(output)
    for what, path in inputs.items():
        if _is_same(target, Path(path)):
            raise envlights.EnvLightsError(
                f"cannot write {output}: it is {what}; give another name"
            )


def _is_same(target: Path, source: Path) -> bool:
    return target.exists() and source.exists() and target.samefile(source)


def _write(env: envlights.EnvMap, rig: Rig, output: str) -> None:
    if Path(output).suffix.lower() == ".json":
        rig.save(output)
        return
    # Drawing takes a second to import; a rig alone does not need it.
    from envlights import plot

    plot.save(plot.picture(env, rig), output)


def _write_lights(env: envlights.EnvMap, lights: envlights.DetectedLights, output: str) -> None:
    if Path(output).suffix.lower() == ".json":
        text = json.dumps(lights.to_dict(), indent=2, allow_nan=False) + "\n"
        write_atomically(output, lambda beside: beside.write_text(text, encoding="utf-8"))
        return
    from envlights import plot

    plot.save(plot.detection_picture(env, lights), output)
