"""`envlights show`, the examples of each help, and `--quiet`."""

import re
import shlex

import click
import pytest
from click.testing import CliRunner

import envlights as el
from envlights import io
from envlights.cli import main
from envlights.cli.examples import EXAMPLES


@pytest.fixture(scope="module")
def hall(tmp_path_factory):
    path = tmp_path_factory.mktemp("maps") / "hall.exr"
    io.write_exr(path, el.synthetic.hall(64).radiance)
    return str(path)


def test_show_writes_one_page_that_loads_nothing(hall, tmp_path):
    page = tmp_path / "report.html"
    result = CliRunner().invoke(main, ["show", hall, "-o", str(page), "-n", "2", "--title", "<a>"])
    assert result.exit_code == 0, result.output
    text = page.read_text()
    assert not re.findall(r"https?://|<script|<link|@import|url[(]", text)
    assert all(source.startswith("data:image/png") for source in re.findall('src="([^"]*)', text))
    assert "<h1>&lt;a&gt;</h1>" in text
    curve = el.error_curve(hall, range(9))
    assert curve._repr_html_().split("<tbody>")[1][:60] in text
    assert curve.rigs[2].lights.table().html() in text


def test_show_refuses_an_output_before_it_reads_the_map(tmp_path):
    result = CliRunner().invoke(main, ["show", "none.exr", "-o", str(tmp_path / "report.pdf")])
    assert (result.exit_code, result.stdout) == (2, "")
    assert "the suffix must be .html" in result.stderr


def test_every_subcommand_has_examples():
    assert list(EXAMPLES) == main.list_commands(click.Context(main))


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_examples_in_the_help_are_understood(name):
    text = CliRunner().invoke(main, [name, "--help"]).stdout
    for example in EXAMPLES[name]:
        assert f"envlights {name} {example}" in text
        words, command = shlex.split(example), main.get_command(click.Context(main), name)
        if isinstance(command, click.Group):
            command = command.commands[words.pop(0)]
        command.make_context(name, words)


def test_quiet_prints_nothing_but_a_refusal(hall, tmp_path):
    rig = tmp_path / "rig.json"
    result = CliRunner().invoke(main, ["fit", hall, "-n", "1", "-o", str(rig), "--quiet"])
    assert (result.exit_code, result.output) == (0, "")
    assert len(el.Rig.load(rig).lights) == 1
    result = CliRunner().invoke(main, ["fit", "none.exr", "--quiet"])
    assert (result.exit_code, result.stdout) == (1, "")
    assert "there is no such file" in result.stderr
