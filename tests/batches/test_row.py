"""`batches.row`: one map for engines that distribute work themselves."""

import json
import os
import subprocess
import sys

import pytest

import envlights as el


def test_a_row_is_that_of_a_batch(tmp_path):
    el.EnvMap(el.synthetic.hall(32).radiance).save(tmp_path / "hall.exr")
    path = tmp_path / "hall.exr"
    row = el.batches.row(path.read_bytes(), lights=2)
    (expected,) = el.batch(str(path), lights=2).rows()
    assert json.loads(json.dumps(row)) == row
    for name in ("sha256", "error", "shadow_error", "ambient", "lights", "notes"):
        assert row[name] == expected[name], name


def test_a_bad_map_is_a_row_and_a_bad_option_is_not():
    assert el.batches.row(b"no map")["failure"].startswith("FileError: cannot read the bytes")
    with pytest.raises(el.EnvLightsError, match="did you mean lights="):
        el.batches.row(b"no map", lihgts=2)
    with pytest.raises(el.EnvLightsError, match="what must be one of fit, detect"):
        el.batches.row(b"no map", "fits")
    with pytest.raises(el.EnvLightsError, match="threads must be a whole number"):
        el.batches.row(b"no map", threads="2")


POOLS = """
import multiprocessing
import envlights as el

hall = el.synthetic.hall(32).radiance
here = el.batches.row(hall, "detect")
for method in {"spawn", "fork"} & {*multiprocessing.get_all_start_methods()}:
    with multiprocessing.get_context(method).Pool(2) as pool:
        for row in pool.starmap(el.batches.row, [(hall, "detect")] * 4):
            assert row | {"seconds": 0} == here | {"seconds": 0}
"""


def test_any_process_makes_the_same_row():
    """Rows of processes that were forked and spawned, with 16 threads on few cores."""
    # In a process of its own, because JAX may have started threads in this one.
    environment = {**os.environ, "RAYON_NUM_THREADS": "16"}
    done = subprocess.run(
        [sys.executable, "-c", POOLS], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
