"""Files are written whole or not at all."""

import os
from pathlib import Path

import pytest

import envlights as el
from envlights.files import check_writable, write_atomically


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
        refused[os.devnull] = "no regular file"
    for path, message in refused.items():
        with pytest.raises(el.EnvLightsError, match=message):
            check_writable(path)
    assert read_only.read_text() == "kept"
