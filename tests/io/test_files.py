"""Files are written whole or not at all."""

import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

import envlights as el
from envlights import plot
from envlights.io.files import check_writable, write_atomically


def test_a_write_that_fails_leaves_the_old_file_and_nothing_else(tmp_path):
    target = tmp_path / "rig.json"
    target.write_text("old")

    def fail(beside):
        beside.write_text("half")
        raise OSError(28, "No space left on device")

    with pytest.raises(el.EnvLightsError, match=r"cannot write .*rig\.json: No space left"):
        write_atomically(target, fail)
    assert target.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["rig.json"]


@pytest.mark.parametrize(
    "call",
    [
        lambda: el.Rig.load(3),
        lambda: el.synthetic.rigs(1)[0].save(None),
        lambda: el.TransferModel.load(None),
        lambda: el.read_pairs(5),
        lambda: el.EnvMap.open(None),
        lambda: plot.save(None, 3.5),
    ],
)
def test_what_is_no_path_is_refused(call):
    with pytest.raises(el.EnvLightsError, match=r"must be (text|a folder)"):
        call()


def test_links_are_followed(tmp_path):
    (tmp_path / "real").mkdir()
    real = tmp_path / "real" / "rig.json"
    real.write_text("old")
    link = tmp_path / "rig.json"
    link.symlink_to(real)
    write_atomically(link, lambda beside: beside.write_text("new"))
    assert link.is_symlink()
    assert real.read_text() == "new"


def test_places_where_nothing_can_be_written_are_refused(tmp_path):
    read_only = tmp_path / "kept.json"
    read_only.write_text("kept")
    read_only.chmod(0o444)
    refused = {
        tmp_path / "none" / "rig.json": "the folder .*none does not exist",
        tmp_path: "it is a folder",
        read_only: "marked read-only",
    }
    if Path(os.devnull).exists():
        refused[os.devnull] = "not a regular file"
    for path, message in refused.items():
        with pytest.raises(el.EnvLightsError, match=message):
            check_writable(path)
    assert read_only.read_text() == "kept"


def test_a_move_that_fails_leaves_nothing(tmp_path, monkeypatch):
    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.replace", fail)
    with pytest.raises(el.EnvLightsError, match="No space left"):
        write_atomically(tmp_path / "rig.json", lambda beside: beside.write_text("new"))
    assert list(tmp_path.iterdir()) == []


def test_any_other_failure_of_the_writer_leaves_nothing(tmp_path):
    def fail(beside):
        beside.write_text("half")
        raise RuntimeError("the writer broke")

    with pytest.raises(RuntimeError, match="the writer broke"):
        write_atomically(tmp_path / "rig.json", fail)
    assert list(tmp_path.iterdir()) == []


def test_a_private_file_stays_private(tmp_path):
    target = tmp_path / "rig.json"
    target.write_text("old")
    target.chmod(0o600)
    write_atomically(target, lambda beside: beside.write_text("new"))
    assert target.stat().st_mode & 0o777 == 0o600


def test_the_longest_name_is_written_and_impossible_names_are_refused(tmp_path):
    longest = tmp_path / ("n" * 250 + ".json")
    write_atomically(longest, lambda beside: beside.write_text("new"))
    assert longest.read_text() == "new"
    for name in ("n" * 300 + ".json", "a\0b.json"):
        with pytest.raises(el.EnvLightsError, match="cannot write"):
            check_writable(tmp_path / name)


def test_threads_that_write_one_file_do_not_disturb_each_other(tmp_path):
    target = tmp_path / "rig.json"

    def write(_):
        write_atomically(target, lambda beside: beside.write_text("whole"))

    with ThreadPoolExecutor(4) as pool:
        list(pool.map(write, range(200)))
    assert target.read_text() == "whole"
    assert list(tmp_path.iterdir()) == [target]
