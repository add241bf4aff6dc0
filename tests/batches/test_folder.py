"""Folder of the results: other programs, other runs, torn lines, full disks and dangling links."""

import csv
import errno
import json
import os
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest

import envlights as el
from envlights._common.fields import plain
from tests.batches.helpers import BROKEN, write_maps

GREY = np.full((8, 16, 3), 0.5, np.float32)


def batch_of(out, *names, **options):
    return el.batch([(name, GREY) for name in names], out, **{"lights": 1, "jobs": 1, **options})


@pytest.mark.parametrize(
    "text",
    [
        '{"custom_id": "request-1", "method": "POST"}\n{"custom_id": "request-2"}\n',
        '{"name": "hall", "loss": 0.1}\n',
        '{"name": "hall"}',
        '{"name": "hall", "source": "hall"}\n',
        "[1, 2]\n3\n",
        "a log\nof another program",
        "\0\0\0\0",
        '{"claims": 3}\n',
    ],
)
def test_a_journal_of_another_program_is_not_touched(text, tmp_path):
    journal = tmp_path / "batch.jsonl"
    journal.write_text(text)
    with pytest.raises(el.FileError, match=r"batch\.jsonl .*another program; give another folder"):
        batch_of(tmp_path, "hall")
    assert journal.read_text() == text
    assert [each.name for each in tmp_path.iterdir()] == ["batch.jsonl"]
    with pytest.raises(el.FileError, match="has no row of one"):
        el.batches.Batch.load(tmp_path)


def test_lines_of_another_program_below_ours_are_not_touched(tmp_path):
    batch_of(tmp_path, "hall")
    journal = tmp_path / "batch.jsonl"
    with journal.open("a") as file:
        file.write('{"custom_id": 1}\n')
    before = journal.read_text()
    with pytest.raises(el.FileError, match="another program"):
        batch_of(tmp_path, "hall")
    assert journal.read_text() == before
    assert [row["name"] for row in el.batches.Batch.load(tmp_path).rows()] == ["hall"]


@pytest.mark.parametrize("options", [{}, {"suffix": ".usda"}, {"what": "split", "lights": 0}])
@pytest.mark.parametrize("kind", ["file", "link", "folder"])
def test_a_file_of_another_program_is_not_replaced(options, kind, tmp_path):
    suffixes = [options.get("suffix", ".json"), *([".exr"] if "what" in options else [])]
    for suffix in suffixes:
        out = tmp_path / suffix[1:]
        out.mkdir()
        foreign = out / f"hall{suffix}"
        if kind == "file":
            foreign.write_text("mine")
        elif kind == "link":
            foreign.symlink_to(tmp_path / "nowhere")
        else:
            foreign.mkdir()
        for _ in range(2):  # the row of the failure does not make the file ours
            result = batch_of(out, "hall", "room", **options)
            assert list(result.failures) == ["hall"]
            assert "no batch in this folder wrote it" in result.failures["hall"]
        assert foreign.is_symlink() if kind == "link" else foreign.exists()
        assert kind != "file" or foreign.read_text() == "mine"
        assert not (tmp_path / "nowhere").exists()
        assert (out / f"room{suffix}").is_file()


def test_a_file_of_a_batch_is_replaced_also_after_a_kill_or_a_failure(tmp_path):
    batch_of(tmp_path, "hall")
    whole = (tmp_path / "hall.json").read_text()
    # Killed between the file and its row: the line of claims is there.
    (tmp_path / "batch.jsonl").write_text('{"claims": ["hall.json"]}\n{"name": "ha')
    (tmp_path / "hall.json").write_text("half")
    assert not batch_of(tmp_path, "hall").failures
    # The map cannot be read for a while.
    (failed,) = el.batch([("hall", [1])], tmp_path, lights=1, jobs=1).rows()
    assert failed["failure"]
    assert not batch_of(tmp_path, "hall").failures
    first, again = (json.loads(text) for text in (whole, (tmp_path / "hall.json").read_text()))
    assert first["lights"] == again["lights"]


def test_a_deleted_map_of_a_split_is_written_again(tmp_path):
    for _ in range(2):
        batch_of(tmp_path, "hall", what="split")
        (tmp_path / "hall.exr").unlink()
    batch_of(tmp_path, "hall", what="split")
    assert batch_of(tmp_path, "hall", what="split").unchanged == 1


def test_the_order_of_a_set_does_not_matter():
    assert plain({"usd", "three", "gltf"}) == ["gltf", "three", "usd"]
    assert plain(frozenset({3, 1, 2})) == [1, 2, 3]


def test_a_file_system_without_locks_is_no_fault(tmp_path, monkeypatch):
    def refuse(*_):
        raise OSError(errno.ENOLCK, "no locks available")

    monkeypatch.setattr("fcntl.flock", refuse)
    assert not batch_of(tmp_path, "hall").failures
    assert sorted(path.name for path in tmp_path.iterdir()) == ["batch.jsonl", "hall.json"]


def test_a_batch_has_the_rows_of_its_call_and_names_other_runs(tmp_path):
    batch_of(tmp_path, "hall", "room")
    batch_of(tmp_path, "roof", lights=2)
    maps = [("attic", GREY), ("room", GREY)]
    result = el.batch(maps, tmp_path, what="detect", jobs=1)
    assert [row["name"] for row in result.rows()] == ["attic", "room"]
    assert (len(result), len(list(result.table("maps"))), result.unchanged) == (2, 2, 0)
    text = str(result)
    assert 'not listed: 1 row of another run in the folder: fit {"lights": 1}' in text
    assert 'not listed: 1 row of another run in the folder: fit {"lights": 2}' in text
    assert result.to_dict()["other_runs"] == {'fit {"lights": 1}': 1, 'fit {"lights": 2}': 1}
    assert len(el.batches.label_arrays(result, 1)) == 2
    every = el.batches.Batch.load(tmp_path)
    assert [row["name"] for row in every.rows()] == ["attic", "hall", "roof", "room"]
    assert "not listed" not in str(every)
    # Unchanged maps are of the call.
    again = batch_of(tmp_path, "hall")
    assert ([row["name"] for row in again.rows()], again.unchanged) == (["hall"], 1)


@pytest.mark.parametrize("torn", ["", "{", '{"name": "r', '{"claims": ["room.j'])
def test_a_torn_line_is_cut_off_and_left_out_by_readers(torn, tmp_path):
    batch_of(tmp_path, "hall")
    with (tmp_path / "batch.jsonl").open("a") as file:
        file.write(torn)
    loaded = el.batches.Batch.load(tmp_path)
    assert [row["name"] for row in loaded.rows()] == ["hall"]
    assert str(loaded).startswith("1 map, 0 failed")
    assert batch_of(tmp_path, "hall", "room").unchanged == 1


FULL = """
import resource, signal, sys
import numpy as np
import envlights as el
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
maps = [(f"map-{k}", np.full((8, 16, 3), 0.5 + k / 99, "f4")) for k in range(30)]
el.batch(maps[:3], sys.argv[1], suffix=None, lights=1, jobs=1)
resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000))
try:
    el.batch(maps, sys.argv[1], suffix=None, lights=1, jobs=1)
except el.FileError as refusal:
    print(refusal)
"""


@pytest.mark.skipif(not hasattr(signal, "SIGXFSZ"), reason="Windows has no limit of files")
def test_a_full_disk_is_one_sentence_and_the_batch_goes_on(tmp_path):
    run = subprocess.run(
        [sys.executable, "-c", FULL, str(tmp_path)], capture_output=True, text=True, check=True
    )
    assert "batch.jsonl: File too large; what is finished stays" in run.stdout
    assert not run.stderr
    maps = [(f"map-{k}", np.full((8, 16, 3), 0.5 + k / 99, "f4")) for k in range(30)]
    again = el.batch(maps, tmp_path, suffix=None, lights=1, jobs=1)
    assert len(again) == 30
    assert again.unchanged >= 3


def test_dangling_links_and_lists_that_are_no_text_are_sentences(tmp_path):
    write_maps(tmp_path / "maps", 1 + len(BROKEN))
    (tmp_path / "maps" / "gone.exr").symlink_to(tmp_path / "nowhere.exr")
    result = el.batch(tmp_path / "maps", tmp_path / "out", lights=1, jobs=1)
    assert "gone" in result.failures
    (tmp_path / "link").symlink_to(tmp_path / "nowhere")
    with pytest.raises(el.EnvLightsError, match="cannot make the folder"):
        batch_of(tmp_path / "link", "hall")
    (tmp_path / "link2").mkdir()
    (tmp_path / "link2" / "batch.jsonl").symlink_to(tmp_path / "no" / "where")
    with pytest.raises(el.EnvLightsError, match="does not exist"):
        batch_of(tmp_path / "link2", "hall")
    (tmp_path / "list.txt").write_bytes(b"\xff\xfe\n")
    with pytest.raises(el.EnvLightsError, match="is not text"):
        el.batch(tmp_path / "list.txt", lights=1, jobs=1)


def test_a_table_is_written_as_csv(tmp_path):
    def numbers(env):
        return {"mean": env.radiance.mean(), "odd": [1, "a"], "text": 'comma, "quote"\nline'}

    el.batch([("hall", GREY), ("bad", [1])], tmp_path / "a", what=numbers, jobs=1).save(
        tmp_path / "maps.csv", "maps"
    )
    with (tmp_path / "maps.csv").open(newline="") as file:
        bad, hall = csv.DictReader(file)
    assert (bad["name"], bad["value_mean"]) == ("bad", "")
    assert bad["failure"].startswith("EnvLightsError: ")
    assert (float(hall["value_mean"]), hall["value_odd"]) == (0.5, '[1, "a"]')
    assert hall["value_text"] == 'comma, "quote"\nline'
    lamp = el.synthetic.plain(1, 128).radiance
    result = el.batch([("hall", lamp)], tmp_path / "b", lights=2, jobs=1)
    result.save(tmp_path / "lights.csv")
    with (tmp_path / "lights.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    for row, light in zip(rows, result.table(), strict=True):
        assert [float(row[name]) for name in "xyz"] == [light[name] for name in "xyz"]


@pytest.mark.parametrize(
    ("submit", "words"),
    [
        (lambda: None, "TypeError"),
        (lambda work, task: 1 / 0, "ZeroDivisionError"),
        (lambda work, task: work(task), "result()"),
        (lambda work, task: SimpleNamespace(result=3), "result()"),
    ],
)
def test_any_executor_works_or_is_refused_in_a_sentence(submit, words):
    with pytest.raises(el.EnvLightsError, match=words):
        el.batch([GREY], lights=1, executor=SimpleNamespace(submit=submit))


def test_an_executor_with_odd_attributes_works():
    def submit(work, task):
        def cancel():
            raise OSError

        return SimpleNamespace(result=lambda: work(task), cancel=cancel)

    for odd in ({"ncores": 3}, {"ncores": lambda: None}, {"num_workers": "many"}):
        executor = SimpleNamespace(submit=submit, **odd)
        assert len(el.batch([GREY, GREY], lights=1, executor=executor)) == 2


def test_an_executor_that_was_shut_down_is_refused():
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(1) as pool:
        pass
    with pytest.raises(el.EnvLightsError, match="cannot schedule new futures after shutdown"):
        el.batch([GREY], lights=1, executor=pool)


ORPHANS = """
import sys
import time
import envlights as el
from pathlib import Path
def wait(env, folder):
    import os
    Path(folder, str(os.getpid())).touch()
    time.sleep(60)
if __name__ == "__main__":
    maps = [__import__("numpy").ones((8, 16, 3))] * 9
    el.batch(maps, what=wait, folder=sys.argv[1], executor="process", jobs=1)
"""


@pytest.mark.skipif(not os.path.isdir("/proc"), reason="needs /proc")  # noqa: PTH112
def test_workers_of_a_killed_parent_end(tmp_path):
    (tmp_path / "run.py").write_text(ORPHANS)
    (tmp_path / "pids").mkdir()
    parent = subprocess.Popen([sys.executable, str(tmp_path / "run.py"), str(tmp_path / "pids")])
    end = time.monotonic() + 120
    while not (pids := [each.name for each in (tmp_path / "pids").iterdir()]):
        assert time.monotonic() < end
        time.sleep(0.1)
    parent.kill()
    parent.wait()
    while any(os.path.exists(f"/proc/{pid}") for pid in pids):  # noqa: PTH110
        assert time.monotonic() < end, "a worker outlived its parent"
        time.sleep(0.1)
