"""Values and calls from which `calls.py` draws arguments."""

import contextlib

import numpy as np
from hypothesis import strategies as st

import envlights as el
from envlights import export, synthetic
from tests.helpers import oblong

RIG = synthetic.rigs(1)[0]
DIRECT, INDIRECT = oblong(8, np.float32)
MODEL = el.TransferModel.fit(DIRECT, INDIRECT)
FITTED = el.fit(synthetic.hall(32).radiance, lights=3)
DETECTED = el.detect(synthetic.hall(64).radiance)


def array(*shape):
    """Random numbers from 0 to 1 of this shape, or as strange but whole: another order or type."""
    numbers = np.random.default_rng(sum(shape)).random(shape)
    return st.sampled_from(
        [
            numbers,
            np.float32(numbers),
            np.asfortranarray(numbers),
            numbers[::-1],
            numbers.astype(">f4"),
            numbers.tolist(),
            np.zeros(shape),
            np.round(9 * numbers).astype(int),
            1e30 * np.float32(numbers),
            1e-30 * np.float32(numbers),
        ]
    )


def unit_vectors(n):
    """Some directions, the axes among them."""
    vectors = np.random.default_rng(n).normal(size=(n, 3))
    vectors[: min(n, 3)] = np.eye(3)[: min(n, 3)]
    vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
    return st.sampled_from([vectors, vectors.tolist(), vectors[::-1], -vectors])


IMAGE = st.one_of([array(h, w, 3) for h, w in [(2, 4), (4, 8), (16, 32), (9, 17), (32, 64)]])
GREY = st.one_of([array(h, w) for h, w in [(1, 1), (2, 4), (16, 32), (9, 17)]])
NORMALS = st.one_of([unit_vectors(n) for n in (1, 5, 40)])
FEW = unit_vectors(5)
COLOURS = array(5, 3)
FLAG = st.booleans()
SMALL = st.floats(0, 10)
SHARE = st.floats(0, 1)
COUNT = st.integers(1, 12)
SIZE = st.integers(2, 40)
#: Rows of a generated map; some kinds need 128 or 256.
HEIGHT = st.sampled_from([40, 128, 256])
SEED = st.integers(0, 9)
COLOUR = st.sampled_from([(1, 1, 1), (0.2, 0.5, 1), [1, 0, 0]])
AMBIENT = st.sampled_from([[0, 0, 0], [1, 2, 3], np.ones((9, 3))])
ANGLES = st.sampled_from([np.zeros(5), np.full(5, 0.3), np.full(5, np.pi / 2)])
PIXELS = st.sampled_from([[[0, 0]], [[0, 0], [1, 1]], np.zeros((0, 2), int)])
AMBIENT_MODEL = st.sampled_from(["constant", "none", "sh2"])
UNKNOWNS = st.sampled_from([np.full(3 + 5 * n, 0.5) for n in (0, 1, 4)])
LIGHTS = st.one_of(st.none(), st.integers(0, 5))
#: Settings of the steps of Loghin (2021), in maps and in photographs.
STEPS = {
    "reduction": st.sampled_from(["bilinear", "area"]),
    "blur_px": SMALL,
    "sampling": st.sampled_from(["hammersley", "halton"]),
    "samples_per_pixel": SHARE,
    "window_px": st.one_of(st.none(), COUNT),
    "relative": FLAG,
    "threshold": SMALL,
    "tolerance": SHARE,
    "ceiling": SMALL,
    "move_to_maximum": FLAG,
}
OF_MAPS = {
    "suppression_deg": SMALL,
    "merge_cap_deg": st.one_of(st.none(), SMALL),
    "sphere": FLAG,
}
OF_PHOTOGRAPHS = {
    "rise": SMALL,
    "suppression_px": SMALL,
    "tolerance_stops": SMALL,
    "merge_cap_px": st.one_of(st.none(), SMALL),
}
#: Arguments of `detect_photograph`.
PHOTOGRAPHS = {
    "image": st.one_of([array(*shape) for shape in [(2, 2), (30, 40), (33, 48, 4)]]),
    "fov": st.one_of(st.none(), st.floats(1, 170)),
    "lights": LIGHTS,
    "working_side": SIZE,
    "settings": st.builds(el.papers.loghin.Settings, **STEPS, **OF_PHOTOGRAPHS),
}
TURN = st.sampled_from([np.eye(3), np.eye(3)[[1, 2, 0]], np.eye(3)[[0, 2, 1]].tolist()])
AXIS_OF_SURFACE = st.sampled_from([(0, 1, 0), [1, 0, 0], np.array([0.6, -0.8, 0])])
UNITS = st.sampled_from(["the map's own scale", "cd/m2"])
AXIS = st.sampled_from(["+x", "-x", "+y", "-y", "+z", "-z"])
ENGINE = {
    "environment": st.one_of(st.none(), IMAGE),
    "right": AXIS,
    "up": AXIS,
    "forward": AXIS,
}
RIGS = st.sampled_from([RIG, FITTED, RIG.lights, DETECTED])
LIGHT_SETS = st.sampled_from([RIG.lights, FITTED.lights, DETECTED, RIG.lights[:0]])
PAPER = {"k_a": SMALL, "k_d": SMALL, "C": COLOUR}

#: What no parameter expects, or hardly one.
STRANGE = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-2, 2),
    st.sampled_from([-(2**63), 2**31, 2**32 + 1, 2**63, 10**30, 10**6]),
    st.floats(),
    st.sampled_from([1e300, -1e300, 5e-324, np.float32("nan"), np.inf, 2.5, 1 + 2j]),
    st.sampled_from(["", "text", "constant", b"bytes", "\0", "é" * 300]),
    st.sampled_from([[], {}, (), [[]], [None], [[1, 2], [3]], {"a": 1}, object()]),
    st.sampled_from([len, el, slice(3)]),
    st.sampled_from(
        [
            np.zeros(0),
            np.zeros((0, 3)),
            np.zeros((3, 0)),
            np.zeros((0, 0, 3)),
            np.zeros((1, 1, 3)),
            np.zeros((4, 8, 4)),
            np.zeros((2, 2, 2, 2)),
            np.array(3.0),
            np.full((4, 8, 3), np.nan),
            np.full((4, 8, 3), -1.0),
            np.full((4, 8, 3), np.inf),
            np.full((5, 3), 1e300),
            np.full((5, 3), 3e38, np.float32),
            np.full((5, 3), 1e-320),
            np.ones((4, 8, 3), bool),
            np.ones((4, 8, 3), complex),
            np.array(["a", "b"]),
            np.array([None, {}], object),
            np.array(["2000-01-01"], "datetime64[D]"),
            np.ma.masked_less(np.arange(12.0).reshape(4, 3), 3),
            np.broadcast_to(1.0, (5, 3)),
            np.frombuffer(bytes(5 * 24 + 1), np.uint8)[1:].view(float).reshape(5, 3),
            np.full((5, 2), -(2**62)),
            np.eye(3, dtype=np.float16),
            np.eye(3, dtype=np.longdouble),
        ]
    ),
)


def method_of(of, name):
    """A method of an object that is there, found when it is called."""
    return lambda **arguments: getattr(of, name)(**arguments)


def detect(env, method, max_lights):
    return el.detect(env, method, max_lights=max_lights)


def light_at(index):
    """A light, or none where there is none: Python wants IndexError of a sequence."""
    with contextlib.suppress(IndexError):
        return RIG.lights[index]


def exports_of(target):
    """The functions of a target: its own form, and a file of it."""
    arguments = {"rig": RIGS}
    if target.shows.environment:
        arguments["environment"] = st.one_of(st.none(), IMAGE)
    if target.name in ("mujoco", "sapien", "genesis"):
        arguments["scale"] = st.one_of(st.none(), SMALL)
    file = {"path": st.just(f"no-folder/rig{target.suffixes[0]}")}
    for name, more in ((target.name, {}), (f"save_{target.name}", file)):
        if name in export.__all__:
            yield f"export.{name}", (getattr(export, name), arguments | more)
