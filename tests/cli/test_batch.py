"""`envlights batch`."""

import json

import pytest
from click.testing import CliRunner

import envlights as el
from envlights.cli import main


@pytest.fixture
def maps(tmp_path):
    folder = tmp_path / "maps"
    folder.mkdir()
    for seed in range(3):
        el.EnvMap(el.synthetic.plain(seed, 128).radiance).save(folder / f"map-{seed}.exr")
    return folder


def run(*arguments):
    return CliRunner().invoke(main, ["batch", *map(str, arguments)])


def test_rows_and_files_are_those_of_python(maps, tmp_path):
    out, table = tmp_path / "out", tmp_path / "lights.jsonl"
    done = run(maps / "*.exr", "-o", out, "--set", "lights=2", "--jobs", 2, "--table", table)
    assert done.exit_code == 0, done.output
    assert done.stdout.startswith("3 maps, 0 failed\nmedian error ")
    expected = el.batch(maps, lights=2, jobs=1)
    rows = [json.loads(line) for line in table.read_text().splitlines()]
    assert [row["x"] for row in rows] == [row["x"] for row in expected.table()]
    assert el.Rig.load(out / "map-1.json") == el.fit(maps / "map-1.exr", lights=2)
    again = run(maps / "*.exr", "-o", out, "--set", "lights=2", "--json")
    assert json.loads(again.stdout)["unchanged"] == 3


def test_a_failed_map_makes_the_exit_code_1(maps, tmp_path):
    (maps / "bad.exr").write_bytes(b"no map")
    table = tmp_path / "maps.jsonl"
    done = run(maps, "-o", tmp_path / "out", "--what", "detect", "--table", table, "--rows", "maps")
    assert done.exit_code == 1
    assert "4 maps, 1 failed\nfailed: bad: FileError: cannot read" in done.stdout
    assert len(table.read_text().splitlines()) == 4


def test_a_pattern_without_files_has_exit_code_1(maps, monkeypatch):
    monkeypatch.chdir(maps.parent)
    done = run("no*.exr", "-o", "out")
    assert done.exit_code == 1
    assert "no file matches the pattern" in done.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["maps", "-o", "out", "--set", "what=fit"], "--set must be NAME=VALUE of an option"),
        (["maps", "-o", "out", "--set", "lights"], "--set must be NAME=VALUE of an option"),
        (["maps", "-o", "out", "--set", "lamps=2"], "fit refuses an option of the batch"),
        (["maps", "-o", "out", "--set", "lights=many"], "lights must be"),
        (["maps", "-o", "out", "--table", "lights.txt"], "must be one of .csv, .jsonl, .parquet"),
        (["maps", "-o", "out", "--jobs", "0"], "jobs must be"),
        (["maps", "-o", "maps"], "outside of the folder of the results"),
    ],
)
def test_wrong_use_is_a_sentence_with_exit_code_2(maps, monkeypatch, arguments, message):
    monkeypatch.chdir(maps.parent)
    done = run(*arguments)
    assert done.exit_code == 2, done.output
    assert message in done.stderr
    assert not (maps / "map-0.json").exists()
