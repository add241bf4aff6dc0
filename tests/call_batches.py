"""Calls of the functions that work on many maps."""

from hypothesis import strategies as st

import envlights as el
from tests.call_values import COUNT, IMAGE, RIGS

#: A batch of an array and of what is no map, whose rows stay in memory.
BATCH = el.batch([("hall", el.synthetic.plain(0, 128).radiance), ("bad", [1])], lights=2, jobs=1)

BATCH_CALLS = {
    "batch": (
        el.batch,
        {
            "maps": st.lists(IMAGE, max_size=2),
            "out": st.none(),
            "what": st.sampled_from(["fit", "detect", "split"]),
            "suffix": st.sampled_from([".json", None]),
            "executor": st.sampled_from([None, "thread"]),
            "jobs": st.sampled_from([1, 2]),
            "progress": st.none(),
        },
    ),
    "Batch.load": (el.batches.Batch.load, {"folder": st.just("no-folder")}),
    "Batch.table": (BATCH.table, {"of": st.sampled_from(["lights", "maps"])}),
    "Batch.save": (
        BATCH.save,
        {"path": st.just("table.jsonl"), "of": st.sampled_from(["lights", "maps"])},
    ),
    "row": (
        el.batches.row,
        {
            "env": IMAGE,
            "what": st.sampled_from(["fit", "detect", "split", "nothing"]),
            "threads": st.sampled_from([1, 2]),
        },
    ),
    "label_arrays": (
        el.batches.label_arrays,
        {"labels": st.one_of(st.just(BATCH), st.lists(RIGS)), "lights": COUNT},
    ),
}
