"""A batch that was killed goes on: no map is lost, and none is done twice."""

import os

import pytest

import envlights as el
from tests.batches.helpers import check_whole, kill_batch, rows_of, write_maps

pytestmark = pytest.mark.skipif(not hasattr(os, "killpg"), reason="Windows has no SIGKILL")


@pytest.mark.parametrize("number", [40, pytest.param(300, marks=pytest.mark.slow)])
def test_a_batch_killed_three_times_goes_on(tmp_path, number):
    maps, out = tmp_path / "maps", tmp_path / "out"
    good = write_maps(maps, number)
    for part in (0.2, 0.4, 0.6):
        kill_batch(maps, out, int(part * number))
    failed = sum(b'"failure"' in line for line in (out / "batch.jsonl").read_bytes().splitlines())
    rows = rows_of(out)
    result = el.batch(maps, out, lights=1, jobs=2)
    check_whole(result, out, good)
    # Rows of the killed runs stay, but failures are tried again.
    assert result.unchanged >= rows - failed
    assert el.batch(maps, out, lights=1, jobs=2).unchanged == len(good)


@pytest.mark.slow
def test_a_batch_on_processes_goes_on_after_a_kill(tmp_path):
    maps, out = tmp_path / "maps", tmp_path / "out"
    good = write_maps(maps, 40)
    kill_batch(maps, out, 12, "process")
    check_whole(el.batch(maps, out, lights=1, jobs=2, executor="process"), out, good)
