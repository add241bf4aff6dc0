"""Files are written whole or not at all."""

import os
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

import envlights as el
from envlights import plot
from envlights._common.files import check_writable, write_atomically


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
        lambda: plot.save(plot.Picture(), 3.5),
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


KILLED = """
import os, signal, sys
from envlights._common.files import write_atomically

def die(beside):
    beside.write_text("half")
    os.kill(os.getpid(), signal.SIGKILL)

write_atomically(sys.argv[1], die)
"""


@pytest.mark.skipif(os.name == "nt", reason="nobody is killed so on Windows")
def test_what_a_killed_process_left_is_cleared_but_not_what_another_writes(tmp_path):
    target = tmp_path / "rig.json"
    target.write_text("old")
    killed = subprocess.run([sys.executable, "-c", KILLED, str(target)], check=False)
    assert killed.returncode == -signal.SIGKILL
    assert target.read_text() == "old"
    assert len(list(tmp_path.iterdir())) == 2

    def write_both(beside):
        write_atomically(target, lambda other: other.write_text("inner"))
        beside.write_text("outer")

    write_atomically(target, write_both)
    assert target.read_text() == "outer"
    assert list(tmp_path.iterdir()) == [target]


def test_a_file_is_on_the_disk_before_it_has_its_name(tmp_path, monkeypatch):
    target = tmp_path / "rig.json"
    flushed = []

    def fsync(file):
        flushed.append(target.exists())

    monkeypatch.setattr(os, "fsync", fsync)
    write_atomically(target, lambda beside: beside.write_text("new"))
    # First the file, then the folder that names it.
    assert flushed[:2] == [False, True]


def test_threads_that_write_one_file_do_not_disturb_each_other(tmp_path):
    target = tmp_path / "rig.json"

    def write(_):
        write_atomically(target, lambda beside: beside.write_text("whole"))

    with ThreadPoolExecutor(4) as pool:
        list(pool.map(write, range(200)))
    assert target.read_text() == "whole"
    assert list(tmp_path.iterdir()) == [target]
