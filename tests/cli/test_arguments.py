"""Arguments of every subcommand: an answer, or a refusal on one line; never a traceback."""

import io as streams

import click
import numpy as np
import pytest
from click.testing import CliRunner

import envlights as el
from envlights import io
from envlights.cli import main
from tests.helpers import cases

PATHS = [
    *("", ".", "/", "..", "-", "~", "*", "dir", "dir.json", "dir/", "none.exr", ".json", "usd"),
    *("a\0b.exr", "a\nb.exr", "\x1b[31m.json", "\udcff.exr", "x" * 300 + ".json", "/dev/null"),
    *("bad.json", "deep.json", "loop.json", "bad.png", "bad.csv", "bad.npz", "map.exr/x.json"),
    *("map.exr", "rig.json", "rig.csv", "found.json", "out.exr", "out.usda", "out.png", "out.hdr"),
    *("sky_{face}.exr", "x://y", "out.unity.json", "out.npz", "$x.xml"),
]
ABOVE = ("/", "..")
NUMBERS = ["0", "1", "-1", "4", "60", "nan", "inf", "1e-300", "1e308", "0.5", "9" * 20, "x", ""]
WORDS = ["srgb", "linear", "cube", "fisheye", "harmonic", "equidistant", "opengl", "1/50,2", "loo"]


def commands(command=main, path=()):
    """Subcommands with their names."""
    if not isinstance(command, click.Group):
        return [(path, command)]
    context = click.Context(command)
    return [
        found
        for name in command.list_commands(context)
        for found in commands(command.get_command(context, name), (*path, name))
    ]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Small files that are right, and some that are damaged."""
    monkeypatch.chdir(tmp_path)
    hall = el.synthetic.hall(32).radiance
    io.write_exr("map.exr", hall)
    rig = el.fit(hall, lights=1)
    rig.save("rig.json")
    rig.save("rig.csv")
    el.detect(hall).save("found.json")
    for name in ("dir", "dir.json"):
        (tmp_path / name).mkdir()
    (tmp_path / "loop.json").symlink_to("loop.json")
    (tmp_path / "deep.json").write_text("[" * 2000 + "]" * 2000)
    for name in ("bad.json", "bad.png", "bad.csv", "bad.npz"):
        (tmp_path / name).write_bytes(b'{"format": [1]}' if name == "bad.json" else b"\x89PNG\xff")
    return tmp_path


def value_of(parameter, rng):
    """A value that may be right for a parameter."""
    if parameter.type.name in ("float", "integer"):
        return rng.choice(NUMBERS)
    if isinstance(parameter.type, click.Choice):
        return rng.choice(parameter.type.choices)
    return rng.choice([*WORDS, *PATHS] if rng.random() < 0.3 else PATHS)


def arguments(command, rng):
    """Arguments of a subcommand, with a few of its options."""
    for parameter in command.params:
        if isinstance(parameter, click.Argument):
            count = 1 if parameter.nargs == 1 else rng.integers(1, 4)
            values = (value_of(parameter, rng) for _ in range(count))
            # From a folder above the own one, `batch` would take all pictures of the machine.
            yield from (
                "." if command.name == "batch" and each in ABOVE else each for each in values
            )
        elif parameter.required or rng.random() < 0.2:
            yield parameter.opts[0]
            if not parameter.is_flag:
                yield value_of(parameter, rng)


@pytest.mark.parametrize("path", [path for path, _ in commands()], ids=" ".join)
def test_any_arguments_give_an_answer_or_a_refusal(folder, path):
    if path == ("demo",):
        pytest.skip("its only argument is a folder")
    command = dict(commands())[path]
    rng = np.random.default_rng(len(path[-1]))
    for _ in range(cases(short=40, long=1000)):
        given = [str(each) for each in arguments(command, rng)]
        result = CliRunner().invoke(main, [*path, *given], input=streams.BytesIO())
        assert result.exception is None or isinstance(result.exception, SystemExit), given
        assert all(line.isprintable() for line in result.output.split("\n")), given
