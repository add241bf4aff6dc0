"""Folders of small maps, and a batch in a process that can be killed."""

import os
import signal
import subprocess
import sys
import time
from functools import cache

import envlights as el

#: Maps that cannot be read, by name, and a part of the reason.
BROKEN = {
    "bad-empty": (b"", "FileError"),
    "bad-text": (b"no map", "FileError"),
    "bad-header": (b"#?RADIANCE\n", "DamagedFileError"),
    "bad-cut": (b"v/1\x01" + bytes(40), "DamagedFileError"),
    "bad-png": (b"\x89PNG\r\n\x1a\n", "DamagedFileError"),
}
#: Seconds until a process must have written a row, also on a busy machine.
PATIENCE = 120

RUN = """
import sys
import envlights as el
if __name__ == "__main__":
    el.batch(sys.argv[1], sys.argv[2], lights=1, jobs=2, executor=sys.argv[3] or None)
"""


@cache
def sky(seed):
    return el.synthetic.plain(seed, 128).radiance


def write_maps(folder, number):
    """Write `number` small maps, five of them broken; return the names of the good ones."""
    folder.mkdir()
    good = [f"map-{seed:03}" for seed in range(number - len(BROKEN))]
    for seed, name in enumerate(good):
        el.EnvMap((1 + seed) * sky(seed % 20)).save(folder / f"{name}.exr")
    for name, (content, _) in BROKEN.items():
        (folder / f"{name}.exr").write_bytes(content)
    return good


def kill_batch(maps, out, rows, executor=""):
    """Start the batch, and kill it when that many rows are written."""
    script = out.parent / "run.py"
    script.write_text(RUN)
    command = [sys.executable, str(script), str(maps), str(out), executor]
    process = subprocess.Popen(command, start_new_session=True)
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end and process.poll() is None and rows_of(out) < rows:
        time.sleep(0.002)
    os.killpg(process.pid, signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL, "the batch ended before it was killed"


def rows_of(out):
    """Number of whole rows in the journal."""
    journal = out / "batch.jsonl"
    lines = journal.read_bytes().splitlines(keepends=True) if journal.exists() else []
    return sum(line.startswith(b'{"name"') and line.endswith(b"\n") for line in lines)


def check_whole(result, out, good):
    """Check that good maps have a row and a rig, broken ones a reason, and there is no more."""
    rows = list(result.rows())
    assert [row["name"] for row in rows] == sorted([*good, *BROKEN])
    assert rows_of(out) == len(rows)
    assert result.failures.keys() == BROKEN.keys()
    assert all(BROKEN[name][1] in reason for name, reason in result.failures.items())
    assert {path.name for path in out.iterdir()} == {
        "batch.jsonl",
        *(f"{name}.json" for name in good),
    }
    for row in rows:
        if row["name"] in good:
            rig = el.Rig.load(out / row["file"])
            assert rig.lights.direction.tolist() == [light["direction"] for light in row["lights"]]
