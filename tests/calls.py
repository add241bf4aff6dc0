"""Public functions, and what they may be given: a table from which calls are generated.

To add a function, add a row: its name, the function, and a strategy for each of its parameters.
Arguments that it should take are drawn from those strategies; in every second call one of them is
something strange instead. `test_calls.py` sees to it that no public function is missing.
"""

import contextlib

import numpy as np
from hypothesis import strategies as st

import envlights as el
from envlights import export, io, kernels, synthetic

RIG = synthetic.rigs(1)[0]
ROOM = synthetic.room(8, width=16)
MODEL = el.TransferModel.fit(ROOM.direct, ROOM.indirect)
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
TURN = st.sampled_from([np.eye(3), np.eye(3)[[1, 2, 0]], np.eye(3)[[0, 2, 1]].tolist()])
AXIS = st.sampled_from(["+x", "-x", "+y", "-y", "+z", "-z"])
ENGINE = {
    "environment": st.one_of(st.none(), IMAGE),
    "right": AXIS,
    "up": AXIS,
    "forward": AXIS,
}
RIGS = st.sampled_from([RIG, FITTED, RIG.lights, DETECTED])
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


def _method(of, name):
    """A method of an object that is there, found when it is called."""
    return lambda **arguments: getattr(of, name)(**arguments)


def _detect(env, method, max_lights):
    return el.detect(env, method, max_lights=max_lights)


def _light(index):
    """A light, or none where there is none: Python wants IndexError of a sequence."""
    with contextlib.suppress(IndexError):
        return RIG.lights[index]


def _exports(target):
    """The functions of a target: its own form, and a file of it."""
    arguments = {"rig": RIGS}
    if target.takes_map:
        arguments["environment"] = st.one_of(st.none(), IMAGE)
    file = {"path": st.just(f"no-folder/rig{target.suffixes[0]}")}
    for name, more in ((target.name, {}), (f"save_{target.name}", file)):
        if name in export.__all__:
            yield f"export.{name}", (getattr(export, name), arguments | more)


CALLS = {
    "EnvMap": (
        el.EnvMap,
        {
            "radiance": IMAGE,
            "projection": st.just("equirectangular"),
            "registration": st.sampled_from(["cell-centred", "border-sampled"]),
            "notes": st.sampled_from([(), ("a note",)]),
            "white": st.one_of(st.none(), SMALL),
        },
    ),
    "EnvMap.probe": (
        lambda env, normals: el.EnvMap(env).probe(normals),
        {"env": IMAGE, "normals": NORMALS},
    ),
    "EnvMap.open": (el.EnvMap.open, {"path": st.just("none.exr"), "max_pixels": COUNT}),
    "Lights": (
        el.Lights,
        {"direction": FEW, "irradiance": COLOURS, "angular_radius": st.one_of(st.none(), ANGLES)},
    ),
    "Lights.to_map": (_method(RIG.lights, "to_map"), {"height": SIZE}),
    "Lights[]": (_light, {"index": st.integers(0, len(RIG.lights) - 1)}),
    "Rig.probe": (_method(RIG, "probe"), {"normals": NORMALS}),
    "Rig.to_map": (_method(RIG, "to_map"), {"height": SIZE}),
    "Rig.load": (el.Rig.load, {"path": st.just("none.json")}),
    "Rig.save": (_method(FITTED, "save"), {"path": st.just("no-folder/rig.json")}),
    "DetectedLights.to_map": (_method(DETECTED, "to_map"), {"height": SIZE}),
    "detect": (
        _detect,
        {"env": IMAGE, "method": st.sampled_from(["tree", "article"]), "max_lights": LIGHTS},
    ),
    "detect_tree": (
        el.detect_tree,
        {
            "env": IMAGE,
            "max_lights": LIGHTS,
            "min_flux_share": SHARE,
            "min_worth": SMALL,
            "rise": SMALL,
            "prominence": SMALL,
            "gap_deg": SMALL,
            "extent": SHARE,
            "working_width": SIZE,
            "white": st.one_of(st.none(), SMALL),
        },
    ),
    "split": (
        el.split,
        {
            "env": IMAGE,
            "lights": st.one_of(st.none(), st.integers(0, 3), st.just(DETECTED)),
            "share": st.one_of(st.none(), SHARE),
            "method": st.sampled_from(["tree", "article"]),
        },
    ),
    "detect_article": (
        el.detect_article,
        {
            "env": IMAGE,
            "max_lights": LIGHTS,
            "working_width": SIZE,
            "reduction": st.sampled_from(["bilinear", "area"]),
            "blur_px": SMALL,
            "samples_per_pixel": SHARE,
            "window_px": COUNT,
            "threshold": SMALL,
            "suppression_deg": SMALL,
            "tolerance": SHARE,
            "ceiling": SMALL,
            "merge_cap_deg": st.one_of(st.none(), SMALL),
            "relative": FLAG,
            "move_to_maximum": FLAG,
            "sphere": FLAG,
        },
    ),
    "fit": (
        el.fit,
        {
            "env": IMAGE,
            "lights": st.integers(0, 4),
            "sizes": FLAG,
            "objective": st.sampled_from(["mixed", "lambert"]),
            "ambient": AMBIENT_MODEL,
            "start": st.sampled_from(["greedy", "detect", "even", RIG]),
            "normals": st.sampled_from(["sphere", "320"]),
            "floor": FLAG,
        },
    ),
    "fit to an error": (el.fit, {"env": IMAGE, "error": st.floats(0.01, 1)}),
    "fit to an error of shadows": (el.fit, {"env": IMAGE, "shadow_error": st.floats(0.1, 1)}),
    "fit with fixed lights": (el.fit, {"env": IMAGE, "lights": LIGHTS, "fixed": FEW}),
    "fit_probe": (
        el.fit_probe,
        {
            "normals": unit_vectors(40),
            "irradiance": array(40, 3),
            "lights": st.integers(0, 5),
            "weights": st.one_of(st.none(), array(40)),
            "ambient": AMBIENT_MODEL,
            "start": st.sampled_from(["greedy", "even", RIG]),
            "fixed": st.one_of(st.none(), FEW),
        },
    ),
    "fit_paper": (
        el.fit_paper,
        {
            "env": IMAGE,
            "lights": COUNT,
            **PAPER,
            "start": st.none(),
            "damped": FLAG,
            "max_steps": COUNT,
        },
    ),
    "TransferModel.fit": (
        el.TransferModel.fit,
        {
            "direct": st.one_of(array(6, 2, 3, 3), st.just(ROOM.direct)),
            "indirect": st.one_of(array(6, 4, 2, 3), st.just(ROOM.indirect)),
            "rank": st.one_of(st.integers(1, 9), SHARE),
            "ridge": st.one_of(SHARE, st.just("loo")),
            "error": st.one_of(st.none(), SHARE),
            "notebook": FLAG,
        },
    ),
    "TransferModel.predict": (
        _method(MODEL, "predict"),
        {"direct": st.just(ROOM.direct), "error": SHARE, "region": st.none()},
    ),
    "TransferModel.project": (_method(MODEL, "project"), {"indirect": st.just(ROOM.indirect)}),
    "TransferModel.add": (
        _method(MODEL, "add"),
        {"direct": st.just(ROOM.direct[:1]), "indirect": st.just(ROOM.indirect[:1])},
    ),
    "TransferModel.compressed": (_method(MODEL, "compressed"), {"error": SHARE}),
    "TransferModel.load": (el.TransferModel.load, {"path": st.just("none.npz")}),
    "TransferModel.save": (_method(MODEL, "save"), {"path": st.just("no-folder/m.npz")}),
    "read_pairs": (el.read_pairs, {"pairs": st.just("no-folder")}),
    "io.read_image": (io.read_image, {"path": st.just("none.png"), "max_pixels": COUNT}),
    "io.check_writable": (io.check_writable, {"path": st.just("no-folder/file.exr")}),
    "synthetic.faint": (synthetic.faint, {"seed": SEED, "height": HEIGHT}),
    "synthetic.hall": (synthetic.hall, {"height": SIZE}),
    "synthetic.hard": (synthetic.hard, {"seed": SEED, "height": HEIGHT}),
    "synthetic.openings": (synthetic.openings, {"seed": SEED, "height": HEIGHT}),
    "synthetic.plain": (synthetic.plain, {"seed": SEED, "height": HEIGHT}),
    "synthetic.rigs": (synthetic.rigs, {"number": COUNT, "seed": SEED}),
    "synthetic.room": (synthetic.room, {"pairs": COUNT, "width": SIZE, "seed": SEED}),
    "synthetic.scene": (synthetic.scene, {"height": SIZE, "background": COLOUR}),
    "EnvMap.rotated": (
        lambda env, matrix: el.EnvMap(env).rotated(matrix),
        {"env": IMAGE, "matrix": TURN},
    ),
    "EnvMap.save": (
        el.EnvMap(np.ones((2, 4, 3))).save,
        {
            "path": st.just("no-folder/map.exr"),
            "half": FLAG,
            "compression": st.sampled_from(["zip", "none"]),
        },
    ),
    "Rig.rotated": (_method(RIG, "rotated"), {"matrix": TURN}),
    "Lights.rotated": (_method(RIG.lights, "rotated"), {"matrix": TURN}),
    "Lights.save": (_method(RIG.lights, "save"), {"path": st.just("no-folder/rig.csv")}),
    "DetectedLights.rotated": (_method(DETECTED, "rotated"), {"matrix": TURN}),
    "export.save": (
        export.save,
        {"rig": RIGS, "path": st.just("no-folder/rig.csv"), "environment": st.none()},
    ),
    "export.read_csv": (export.read_csv, {"path": st.just("none.csv")}),
    "export.target_of": (export.target_of, {"path": st.just("rig.csv")}),
    "export.engine": (export.engine, {"rig": RIGS, **ENGINE}),
    "export.save_engine": (
        export.save_engine,
        {"rig": RIGS, "path": st.just("no-folder/rig.json"), **ENGINE},
    ),
    **dict(call for target in export.TARGETS for call in _exports(target)),
    "kernels.blur": (kernels.blur, {"image": GREY, "sigma": SMALL}),
    "kernels.bresenham_line": (
        kernels.bresenham_line,
        {"start": st.tuples(SEED, SEED), "end": st.tuples(SEED, SEED)},
    ),
    "kernels.direction_to_uv": (kernels.direction_to_uv, {"direction": NORMALS}),
    "kernels.disc_map": (
        kernels.disc_map,
        {"height": SIZE, "directions": FEW, "irradiance": COLOURS, "angular_radius": ANGLES},
    ),
    "kernels.face_radiance": (
        kernels.face_radiance,
        {"radiance": IMAGE, "faces": st.sampled_from([20, 80, 320]), "border_sampled": FLAG},
    ),
    "kernels.halton": (kernels.halton, {"n": COUNT, "bases": st.sampled_from([(2, 3), (2,), [5]])}),
    "kernels.hammersley": (kernels.hammersley, {"n": COUNT}),
    "kernels.harmonic_irradiance": (kernels.harmonic_irradiance, {"normals": NORMALS}),
    "kernels.harmonic_radiance": (kernels.harmonic_radiance, {"directions": NORMALS}),
    "kernels.icosphere": (kernels.icosphere, {"faces": st.sampled_from([20, 80, 320])}),
    "kernels.irradiance": (
        kernels.irradiance,
        {"radiance": IMAGE, "normals": NORMALS, "border_sampled": FLAG},
    ),
    "kernels.luminance": (kernels.luminance, {"radiance": IMAGE}),
    "kernels.merge_along_lines": (
        kernels.merge_along_lines,
        {
            "luminance": GREY,
            "pixels": PIXELS,
            "tolerance": SHARE,
            "ceiling": SMALL,
            "bright": SMALL,
            "farthest": SMALL,
            "sphere": FLAG,
        },
    ),
    "kernels.neighbour_maximum": (
        kernels.neighbour_maximum,
        {"luminance": GREY, "pixels": PIXELS, "reach": COUNT, "sphere": FLAG},
    ),
    "kernels.pack_lights": (
        kernels.pack_lights,
        {"ambient": COLOUR, "directions": FEW, "irradiance": COLOURS},
    ),
    "kernels.pixel_directions": (
        kernels.pixel_directions,
        {"height": SIZE, "width": SIZE, "border_sampled": FLAG},
    ),
    "kernels.pixel_solid_angles": (
        kernels.pixel_solid_angles,
        {"height": SIZE, "width": SIZE, "border_sampled": FLAG},
    ),
    "kernels.probe_jacobian": (
        kernels.probe_jacobian,
        {"x": UNKNOWNS, "normals": FEW, "probe": COLOURS, "weights": array(5), **PAPER},
    ),
    "kernels.probe_model": (kernels.probe_model, {"x": UNKNOWNS, "normals": FEW, **PAPER}),
    "kernels.probe_residual": (
        kernels.probe_residual,
        {"x": UNKNOWNS, "normals": FEW, "probe": COLOURS, "weights": st.none(), **PAPER},
    ),
    "kernels.radical_inverse": (
        kernels.radical_inverse,
        {"index": st.integers(0, 2**40), "base": st.integers(2, 40)},
    ),
    "kernels.reduced_luminance": (
        kernels.reduced_luminance,
        {"radiance": IMAGE, "columns": SIZE, "border_sampled": FLAG},
    ),
    "kernels.relative_rms": (
        kernels.relative_rms,
        {"seen": COLOURS, "wanted": COLOURS, "weights": array(5)},
    ),
    "kernels.resize_bilinear": (
        kernels.resize_bilinear,
        {"image": GREY, "height": SIZE, "width": SIZE},
    ),
    "kernels.rig_irradiance": (
        kernels.rig_irradiance,
        {
            "normals": NORMALS,
            "ambient": AMBIENT,
            "directions": FEW,
            "irradiance": COLOURS,
            "angular_radius": st.one_of(st.none(), ANGLES),
            "floor": FLAG,
        },
    ),
    "kernels.sum_over_sources": (
        kernels.sum_over_sources,
        {
            "normals": NORMALS,
            "directions": FEW,
            "radiance": COLOURS,
            "solid_angles": array(5),
            "k_d": SMALL,
            "C": COLOUR,
        },
    ),
    "kernels.suppress": (kernels.suppress, {"points": NORMALS, "distance": SMALL}),
    "kernels.uniform_sphere": (kernels.uniform_sphere, {"uv": array(7, 2)}),
    "kernels.unpack_lights": (kernels.unpack_lights, {"x": UNKNOWNS}),
    "kernels.uv_to_direction": (kernels.uv_to_direction, {"uv": array(7, 2)}),
    "kernels.uv_to_pixel": (
        kernels.uv_to_pixel,
        {"uv": array(7, 2), "height": SIZE, "width": SIZE},
    ),
    "kernels.weighted_means": (
        kernels.weighted_means,
        {"points": FEW, "weights": array(5), "light": st.just([0, 0, 1, 1, 2])},
    ),
    "kernels.working_irradiance": (
        kernels.working_irradiance,
        {
            "radiance": IMAGE,
            "normals": NORMALS,
            "border_sampled": FLAG,
            "columns": SIZE,
            "source_share": SHARE,
        },
    ),
}

#: Public functions and classes that are not in the table, and why.
LEFT_OUT = {
    "BakedPairs": "comes from bake",
    "DetectedLights": "comes from detect",
    "DetectionReport": "comes from detect",
    "DirectLight": "asks a scene of the caller's",
    "EnvLightsError": "is the refusal",
    "FilePairs": "comes from read_pairs",
    "FitReport": "comes from fit",
    "MitsubaScene": "is Mitsuba's answer to a scene",
    "PaperFit": "comes from fit_paper",
    "Rig": "comes from fit",
    "Split": "comes from split",
    "StopReason": "is an enumeration",
    "Surface": "comes from a scene",
    "RemovedLights": "comes from split",
    "TransferReport": "comes from TransferModel.fit",
    "bake": "renders, by Mitsuba",
    "export.add_to_blender": "needs Blender",
    "export.AXES": "is a table",
    "export.Axes": "is a row of it",
    "export.TARGETS": "is a table",
    "export.Target": "is a row of it",
    "kernels.WORKING_COLUMNS": "is a number",
    "threads": "changes the threads of the process",
}
