"""Comparison of folders, and the command `envlights compare`."""

import csv
import json

import numpy as np
import pytest
from click.testing import CliRunner

import envlights as el
from envlights.cli import main

MAPS = [el.synthetic.plain(seed, 128).radiance[::4, ::4] for seed in range(3)]


@pytest.fixture
def folders(tmp_path):
    """Two folders with a pair, a damaged guess, a name without counterpart and a name twice."""
    for side, gain in (("truth", 1.0), ("guess", 2.0)):
        (tmp_path / side).mkdir()
        for i, radiance in enumerate(MAPS):
            el.EnvMap(gain * radiance).save(tmp_path / side / f"map-{i}.exr")
    (tmp_path / "guess" / "map-1.exr").write_bytes(b"no map")
    el.EnvMap(MAPS[0]).save(tmp_path / "truth" / "alone.hdr")
    el.EnvMap(MAPS[0]).save(tmp_path / "guess" / "map-2.hdr")
    (tmp_path / "guess" / "notes.txt").write_text("no map")
    return tmp_path / "truth", tmp_path / "guess"


def test_a_bad_file_costs_its_row_and_says_why(folders):
    table = el.compare_folders(*folders)
    assert list(table.comparisons) == ["map-0"]
    assert list(table.failures) == ["alone", "map-1", "map-2"]
    assert table.failures["alone"] == "guess has no file of this name"
    assert table.failures["map-1"].startswith("guess: ")
    assert table.failures["map-2"] == "guess has 2 files of this name"
    assert "failed: map-1: " in str(table)


def test_each_row_is_the_comparison_of_its_files(folders):
    (folders[1] / "map-2.hdr").unlink()
    table = el.compare_folders(*folders)
    assert len(table) == 2
    for i in (0, 2):
        expected = el.compare(MAPS[i], 2 * MAPS[i])
        assert table.comparisons[f"map-{i}"] == expected
    values = [each.spheres["matte"].rmse for each in table.comparisons.values()]
    assert table.mean["matte_rmse"] == pytest.approx(np.mean(values))
    assert table.median["matte_rmse"] == pytest.approx(np.median(values))
    assert table.columns()["matte_rmse"].tolist() == values
    assert "<table" in table._repr_html_()


def test_black_guesses_have_a_table_without_angles(folders):
    for path in folders[1].iterdir():
        path.unlink()
    el.EnvMap(0 * MAPS[0]).save(folders[1] / "map-0.exr")
    table = el.compare_folders(*folders)
    first = dict(zip(table.table().columns, table.table().rows[0], strict=True))
    assert first["diffuse angle"] == "nan"
    assert float(first["diffuse rmse"]) > 0
    assert "map-0" in str(table)


def test_rigs_are_compared_with_maps_of_the_same_name(folders):
    el.fit(MAPS[1], lights=2).save(folders[1] / "map-1.json")
    (folders[1] / "map-1.exr").unlink()
    table = el.compare_folders(*folders)
    assert table.comparisons["map-1"] == el.compare(MAPS[1], el.fit(MAPS[1], lights=2))


def test_tables_are_lossless(folders, tmp_path):
    table = el.compare_folders(*folders)
    table.save(tmp_path / "table.csv")
    with (tmp_path / "table.csv").open() as file:
        row, *failed = csv.DictReader(file)
    numbers = {name: values[0] for name, values in table.columns().items()}
    assert {name: float(row[name]) for name in numbers} == numbers
    assert row["failure"] == ""
    assert {each["name"]: each["failure"] for each in failed} == table.failures
    assert all(each[name] == "" for each in failed for name in numbers)
    table.save(tmp_path / "table.json")
    assert json.loads((tmp_path / "table.json").read_text()) == table.to_dict()
    frame = table.to_frame()
    assert frame["name"].tolist() == ["map-0"]
    assert frame["matte_rmse"][0] == numbers["matte_rmse"]


def test_folders_without_maps_are_refused(tmp_path):
    with pytest.raises(el.io.MissingFileError, match="truth must be a folder; got"):
        el.compare_folders(tmp_path / "none", tmp_path)
    with pytest.raises(el.EnvLightsError, match="truth has no map"):
        el.compare_folders(tmp_path, tmp_path)
    with pytest.raises(el.EnvLightsError, match="the suffix must be one of"):
        el.comparison.FolderComparison(el.comparison.Protocol(), {}, {}).save(
            tmp_path / "table.txt"
        )


def run(*arguments):
    return CliRunner().invoke(main, ["compare", *map(str, arguments)])


def test_the_command_prints_the_table_of_two_maps(folders, tmp_path):
    files = [folder / "map-0.exr" for folder in folders]
    done = run(*files, "-o", tmp_path / "table.csv")
    assert done.exit_code == 0, done.output
    assert str(el.compare(*files)) in done.output
    assert "map-0," in (tmp_path / "table.csv").read_text()


def test_the_command_prints_json_and_reports_failures_by_its_exit_code(folders):
    done = run(*folders, "--protocol", "stylelight", "--json")
    assert done.exit_code == 1, done.output
    content = json.loads(done.stdout)
    assert content["protocol"] == "stylelight"
    # Each map is scaled to its own median.
    assert content["mean"]["matte_relative"] < 1e-5
    # The guess is twice the truth, so its error is that of the truth.
    exact = json.loads(run(*folders, "--json").stdout)
    assert exact["mean"]["matte_relative"] == pytest.approx(1)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--protocol", "emlight"], "never published"),
        (["-o", "table.txt"], "the suffix must be one of .csv, .json"),
    ],
)
def test_the_command_refuses_in_a_sentence(folders, arguments, message):
    done = run(*folders, *arguments)
    assert done.exit_code == 2
    assert message in done.output


def test_a_file_and_a_folder_are_refused(folders):
    done = run(folders[0] / "map-0.exr", folders[1])
    assert done.exit_code == 2
    assert "must both be files, or both be folders" in done.output


@pytest.mark.parametrize("name", ["\x1b]0;owned\x07", "a\nenvlights: all is well", "\u202egnp"])
def test_names_of_files_are_printable_in_tables(name, tmp_path):
    for folder in ("truth", "guess"):
        (tmp_path / folder).mkdir()
        even = el.EnvMap(np.full((8, 16, 3), 0.5, np.float32))
        even.save(tmp_path / folder / f"{name}.exr")
    (tmp_path / "guess" / f"{name}2.exr").write_bytes(b"")
    table = el.compare_folders(tmp_path / "truth", tmp_path / "guess")
    assert len(table) == len(table.failures) == 1
    for text in (str(table), table.to_csv(), repr(table)):
        assert all(character.isprintable() for character in text.replace("\n", ""))
        assert "\nenvlights" not in text
    assert table.columns()["scale"] == [1]
