"""Batches: failures cost their rows, and a batch goes on."""

import tracemalloc

import envlights as el
from envlights.batches.journal import Journal


def test_a_batch_goes_on_after_a_torn_row_and_costs_a_bad_file_its_row(tmp_path):
    for seed in range(3):
        el.EnvMap(el.synthetic.plain(seed, 128).radiance).save(tmp_path / f"map-{seed}.exr")
    (tmp_path / "bad.exr").write_bytes(b"no map")
    out, pattern = tmp_path / "out", str(tmp_path / "*.exr")
    first = el.batch(pattern, out, lights=1)
    assert (len(first), list(first.failures), first.unchanged) == (4, ["bad"], 0)
    rows = (out / "batch.jsonl").read_bytes()
    (out / "batch.jsonl").write_bytes(rows[:-20])
    again = el.batch(pattern, out, lights=1)
    assert (len(again), list(again.failures), again.unchanged) == (4, ["bad"], 2)
    for seed in range(3):
        rig = el.Rig.load(out / f"map-{seed}.json")
        assert rig == el.fit(tmp_path / f"map-{seed}.exr", lights=1)


def test_a_row_in_a_folder_needs_little_memory(tmp_path):
    row = {"sha256": 64 * "0", "what": "fit", "options": "{}", "suffix": ".json", "lights": []}
    journal, number = Journal(tmp_path), 3000
    tracemalloc.start()
    try:
        for k in range(number):
            name = f"map-{k:06}"
            assert journal.claim(name, [f"{name}.json"])
            journal.append({"name": name, "source": name, **row, "file": f"{name}.json"})
        assert tracemalloc.get_traced_memory()[0] < 400 * number  # bytes; 800 with all its texts
    finally:
        tracemalloc.stop()
    journal.finish()
    journal.close()
    assert len(el.batches.Batch.load(tmp_path)) == number
