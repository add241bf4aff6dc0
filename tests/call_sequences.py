"""Calls of the functions on sequences, for the table in `calls.py`."""

from hypothesis import strategies as st

import envlights as el
from tests.call_values import FLAG, IMAGE, LIGHTS, RIG, SMALL

FRAME_RIGS = st.just(
    [el.sequence.FrameRig([0.1, 0.1, 0.1], RIG.lights, 0.0, ids=range(len(RIG.lights)))]
)

SEQUENCE_CALLS = {
    "follow": (
        lambda frames, **options: el.follow(frames, **options).sequence(),
        {
            "frames": st.lists(IMAGE, min_size=1, max_size=3),
            "lights": LIGHTS,
            "steadiness": st.one_of(st.integers(0, 3), st.sampled_from(["0.1 s"])),
            "fps": st.one_of(st.just(24.0), SMALL),
            "sizes": FLAG,
            "floor": FLAG,
        },
    ),
    "vary": (
        lambda **options: list(el.vary(RIG, **options)),
        {
            "count": st.integers(0, 3),
            "seed": st.integers(0, 9),
            "azimuth": SMALL,
            "exposure": st.one_of(SMALL, st.tuples(SMALL, SMALL)),
            "temperature": SMALL,
            "drop": SMALL,
            "jitter": SMALL,
        },
    ),
    "FrameRig": (
        lambda **fields: el.sequence.FrameRig([0.1, 0.1, 0.1], RIG.lights, 0.0, **fields),
        {"frame": st.integers(0, 9), "ids": st.just(tuple(range(len(RIG.lights))))},
    ),
    "RigSequence": (
        el.sequence.RigSequence,
        {"rigs": FRAME_RIGS, "steadiness": st.integers(0, 9), "fps": st.one_of(st.none(), SMALL)},
    ),
    "RigSequence.load": (el.sequence.RigSequence.load, {"path": st.just("none.jsonl")}),
    "sequence.usd": (el.sequence.usd, {"rigs": FRAME_RIGS, "fps": SMALL}),
    "sequence.gltf": (el.sequence.gltf, {"rigs": FRAME_RIGS, "fps": SMALL}),
    "sequence.blender": (el.sequence.blender, {"rigs": FRAME_RIGS, "fps": SMALL}),
    "sequence.csv": (el.sequence.csv, {"rigs": FRAME_RIGS}),
    "sequence.json_lines": (el.sequence.json_lines, {"rigs": FRAME_RIGS}),
}
