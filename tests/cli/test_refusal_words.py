"""Refusals name options, not arguments of Python."""

import click
import numpy as np
import pytest
from click.testing import CliRunner

from envlights import io
from envlights.cli import main
from envlights.cli.refusal_words import with_options

COMMAND = click.Command(
    "fit",
    params=[
        click.Option(["-n", "--lights"]),
        click.Option(["--any-format"], is_flag=True),
        click.Option(["--at"]),
    ],
)


@pytest.mark.parametrize(
    ("python", "words"),
    [
        ("give any_format=True", "give --any-format"),
        ("with lights=8.", "with --lights 8."),
        ("give lights='two', or none", "give --lights two, or none"),
        ("lights= is missing", "--lights is missing"),
        ("nits needs at=(x, y, z)", "nits needs --at (x, y, z)"),
        ("any_format=False and mylights=2 stay", "any_format=False and mylights=2 stay"),
    ],
)
def test_arguments_are_options(python, words):
    assert with_options(python, [COMMAND]) == words


def test_names_of_files_stay(tmp_path):
    path = tmp_path / "lights=8.exr"
    assert (
        with_options(f"{path}: give lights=8", [COMMAND], [str(path)]) == f"{path}: give --lights 8"
    )
    done = CliRunner().invoke(main, ["fit", str(path), "-o", str(tmp_path / "rig.json")])
    assert f"cannot read {path}: there is no such file" in done.stderr


def test_a_refusal_of_a_file_names_the_options_that_help(tmp_path):
    (tmp_path / "text.exr").write_text("hello")
    io.write_hdr(tmp_path / "odd.hdr", np.ones((20, 26, 3), np.float32))
    for name, option in {"text.exr": "or --any-format", "odd.hdr": "--projection planar"}.items():
        given = ["fit", str(tmp_path / name), "-o", str(tmp_path / "rig.json")]
        done = CliRunner().invoke(main, given)
        assert option in done.stderr
        assert "=" not in done.stderr
