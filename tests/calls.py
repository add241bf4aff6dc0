"""Table of public functions with their arguments, from which calls are generated.

To add a function, add a row: its name, the function, and a strategy for each of its parameters.
Arguments that it should take are drawn from those strategies; in every second call one of them is
something strange instead. `test_calls.py` sees to it that no public function is missing.
"""

import numpy as np
from hypothesis import strategies as st

import envlights as el
from envlights import export, io, kernels, synthetic
from tests.call_batches import BATCH_CALLS
from tests.call_comparisons import COMPARISON_CALLS
from tests.call_gloss import GLOSS_CALLS
from tests.call_sequences import SEQUENCE_CALLS
from tests.call_solids import SOLID_CALLS
from tests.call_suns import SUN_CALLS
from tests.call_transfer import TRANSFER_CALLS
from tests.call_values import (
    AMBIENT,
    AMBIENT_MODEL,
    ANGLES,
    AXIS_OF_SURFACE,
    COLOUR,
    COLOURS,
    COUNT,
    DETECTED,
    ENGINE,
    FEW,
    FITTED,
    FLAG,
    GREY,
    HEIGHT,
    IMAGE,
    LIGHTS,
    NORMALS,
    OF_MAPS,
    OF_PHOTOGRAPHS,
    PAPER,
    PHOTOGRAPHS,
    PIXELS,
    RIG,
    RIGS,
    SEED,
    SHARE,
    SIZE,
    SMALL,
    STEPS,
    TURN,
    UNITS,
    UNKNOWNS,
    array,
    exports_of,
    light_at,
    method_of,
    unit_vectors,
)

_CORNER = np.transpose([[-2.0, 0, 0], [0, -1, 0], [1, 0.5, 1]])
CARDS = el.Cards(["rectangle"], [_CORNER], [[3.0, 2.0, 1.0]])
PLACED = el.place(el.synthetic.hall(64).radiance, room=(6, 3, 5))

CALLS = {
    "EnvMap": (
        el.EnvMap,
        {
            "radiance": IMAGE,
            "layout": st.sampled_from(["cell-centred", "border-sampled"]).map(
                lambda name: el.io.Layout.equirectangular(registration=name)
            ),
            "notes": st.sampled_from([(), ("a note",)]),
            "clip_level": st.one_of(st.none(), SMALL),
            "units": UNITS,
        },
    ),
    "EnvMap.harmonics": (
        lambda env, **options: el.EnvMap(env).harmonics(**options),
        {
            "env": IMAGE,
            "degree": st.integers(0, 2),
            "convention": st.sampled_from(["envlights", "ramamoorthi", "three", "unity"]),
        },
    ),
    "rigs_to_frame": (el.rigs.rigs_to_frame, {"rigs": st.lists(st.just(RIG), max_size=3)}),
    "EnvMap.calibrated": (
        lambda env, **readings: el.EnvMap(env).calibrated(**readings),
        {"env": IMAGE, "lux": SMALL, "normal": AXIS_OF_SURFACE, "patch": SMALL},
    ),
    "EnvMap.calibrated by a place": (
        lambda env, **readings: el.EnvMap(env).calibrated(**readings),
        {"env": IMAGE, "nits": SMALL, "at": AXIS_OF_SURFACE, "patch": SMALL},
    ),
    "EnvMap.calibrated by an exposure": (
        lambda env, **readings: el.EnvMap(env).calibrated(**readings),
        {"env": IMAGE, "ev100": SMALL},
    ),
    "EnvMap.calibrated in sun and shade": (
        lambda env, **readings: el.EnvMap(env, clip_level=0.9).calibrated(**readings),
        {"env": IMAGE, "lux": st.just(9.0), "shaded": SMALL, "normal": AXIS_OF_SURFACE},
    ),
    "EnvMap.probe": (
        lambda env, normals: el.EnvMap(env).probe(normals),
        {"env": IMAGE, "normals": NORMALS},
    ),
    "EnvMap.open": (el.EnvMap.open, {"path": st.just("none.exr"), "max_pixels": COUNT}),
    "Lights": (
        el.Lights,
        {
            "direction": FEW,
            "irradiance": COLOURS,
            "angular_radius": st.one_of(st.none(), ANGLES),
            "units": UNITS,
        },
    ),
    "Lights.to_map": (method_of(RIG.lights, "to_map"), {"height": SIZE}),
    "Lights[]": (light_at, {"index": st.integers(0, len(RIG.lights) - 1)}),
    "Cards": (
        el.Cards,
        {
            "shape": st.lists(st.sampled_from(["rectangle", "disc", "other"]), max_size=2),
            "matrix": st.just([_CORNER]),
            "irradiance": COLOURS,
            "units": UNITS,
        },
    ),
    "Cards.at": (method_of(CARDS, "at"), {"distance": st.floats(0.1, 1e4)}),
    "Cards.far": (method_of(CARDS, "far"), {"radius": st.floats(0.1, 1e4)}),
    "Rig.probe": (method_of(RIG, "probe"), {"normals": NORMALS}),
    "Rig.to_map": (method_of(RIG, "to_map"), {"height": SIZE}),
    "Rig.load": (el.Rig.load, {"path": st.just("none.json")}),
    "Rig.save": (method_of(FITTED, "save"), {"path": st.just("no-folder/rig.json")}),
    "DetectedLights.to_map": (method_of(DETECTED, "to_map"), {"height": SIZE}),
    "detect": (
        el.detect,
        {
            "env": IMAGE,
            "max_lights": LIGHTS,
            "min_flux_fraction": SHARE,
            "min_worth": SMALL,
            "rise": SMALL,
            "prominence": SMALL,
            "gap_deg": SMALL,
            "extent": SHARE,
            "working_width": SIZE,
            "clip_level": st.one_of(st.none(), SMALL),
        },
    ),
    "split": (
        el.split,
        {
            "env": IMAGE,
            "lights": st.one_of(st.none(), st.integers(0, 3), st.just(DETECTED)),
            "fraction": st.one_of(st.none(), SHARE),
            "shapes": st.booleans(),
        },
    ),
    "place": (
        el.place,
        {
            "env": IMAGE,
            "depth": st.sampled_from([np.ones((16, 32)), np.full((20, 40), np.inf)]),
            "reading": st.sampled_from([None, "ray", "inverse"]),
            "scale": st.one_of(st.none(), SMALL),
        },
    ),
    "place in a room": (
        lambda env, room, camera: el.place(env, room=room, camera=camera),
        {"env": IMAGE, "room": st.just((6, 3, 5)), "camera": st.sampled_from([None, (1, 1, 1)])},
    ),
    "place by two maps": (
        lambda env, other, position: el.place([(env, (0, 0, 0)), (other, position)]),
        {"env": IMAGE, "other": IMAGE, "position": AXIS_OF_SURFACE},
    ),
    "PlacedLights.irradiance": (PLACED.irradiance, {"points": array(5, 3), "normals": NORMALS}),
    "PlacedLights.at": (PLACED.at, {"point": AXIS_OF_SURFACE, "lights": COUNT}),
    "PlacedLights.map_at": (PLACED.map_at, {"point": AXIS_OF_SURFACE}),
    "PlacedLights.compare": (PLACED.compare, {"maps": st.just({(0, 1, 0): np.ones((4, 8, 3))})}),
    "limit": (el.limit, {"env": IMAGE, "maximum": SMALL}),
    "papers.loghin.detect": (
        el.papers.loghin.detect,
        {
            "env": IMAGE,
            "lights": LIGHTS,
            "working_width": SIZE,
            "settings": st.builds(el.papers.loghin.Settings, **STEPS, **OF_MAPS),
        },
    ),
    "papers.loghin.Settings": (el.papers.loghin.Settings, {**STEPS, **OF_MAPS, **OF_PHOTOGRAPHS}),
    "detect_photograph": (el.detect_photograph, PHOTOGRAPHS),
    "fit": (
        el.fit,
        {
            "env": IMAGE,
            "lights": st.integers(0, 4),
            "sizes": FLAG,
            "objective": st.sampled_from(["mixed", "lambert"]),
            "ambient": AMBIENT_MODEL,
            "start": st.sampled_from(["greedy", "detect", "even", RIG]),
            "floor": FLAG,
        },
    ),
    "fit to an error": (el.fit, {"env": IMAGE, "error": st.floats(0.01, 1)}),
    "fit to an error of shadows": (el.fit, {"env": IMAGE, "shadow_error": st.floats(0.1, 1)}),
    "fit with a largest radius": (el.fit, {"env": IMAGE, "max_radius": st.floats(0.01, 1.5)}),
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
    **BATCH_CALLS,
    **COMPARISON_CALLS,
    "papers.madsen.fit": (
        el.papers.madsen.fit,
        {
            "env": IMAGE,
            "lights": COUNT,
            **PAPER,
            "start": st.none(),
            "damped": FLAG,
            "max_steps": COUNT,
        },
    ),
    **TRANSFER_CALLS,
    "read_pairs": (el.read_pairs, {"pairs": st.just("no-folder")}),
    "io.read_image": (io.read_image, {"source": st.just("none.png"), "max_pixels": COUNT}),
    "io.check_writable": (io.check_writable, {"path": st.just("no-folder/file.exr")}),
    "synthetic.hall": (synthetic.hall, {"height": SIZE}),
    "synthetic.hard": (synthetic.hard, {"seed": SEED, "height": HEIGHT}),
    "synthetic.openings": (synthetic.openings, {"seed": SEED, "height": HEIGHT}),
    "synthetic.plain": (synthetic.plain, {"seed": SEED, "height": HEIGHT}),
    "synthetic.rigs": (synthetic.rigs, {"number": COUNT, "seed": SEED}),
    "synthetic.room": (synthetic.room, {"pairs": COUNT, "width": SIZE, "seed": SEED}),
    "synthetic.scene": (synthetic.scene, {"height": SIZE, "background": COLOUR}),
    "Model": (
        el.viewer.Model,
        {
            "vertices": st.one_of(array(9, 3), st.just(np.eye(3))),
            "triangles": st.just([[0, 1, 2]]),
            "albedo": st.one_of(COLOUR, st.just([0.5, 0.5, 0.5])),
            "scale": SMALL,
            "up": st.sampled_from(["y", "z"]),
        },
    ),
    "Model.open": (el.viewer.Model.open, {"source": st.just("none.glb"), "scale": SMALL}),
    "view": (
        el.view,
        {"env": st.just(RIG), "rig": st.none(), "title": st.sampled_from(["A hall", "</script>"])},
    ),
    "EnvMap.rotated": (
        lambda env, matrix: el.EnvMap(env).rotated(matrix, frame="unity"),
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
    "Rig.rotated": (method_of(RIG, "rotated"), {"matrix": TURN}),
    "Rig.measured": (method_of(RIG, "measured"), {"env": IMAGE}),
    "frames.rotation": (el.frames.rotation, {"yaw": SMALL, "pitch": SMALL}),
    "Lights.rotated": (method_of(RIG.lights, "rotated"), {"matrix": TURN}),
    "Lights.save": (method_of(RIG.lights, "save"), {"path": st.just("no-folder/rig.csv")}),
    "DetectedLights.rotated": (method_of(DETECTED, "rotated"), {"matrix": TURN}),
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
    **SOLID_CALLS,
    **GLOSS_CALLS,
    **SUN_CALLS,
    **SEQUENCE_CALLS,
    **dict(call for target in export.TARGETS for call in exports_of(target)),
    "kernels.area_means": (kernels.area_means, {"image": GREY, "rows": SIZE, "columns": SIZE}),
    "kernels.blur": (kernels.blur, {"image": GREY, "sigma": SMALL, "wrap": FLAG}),
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
        {"image": GREY, "height": SIZE, "width": SIZE, "wrap": FLAG},
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
    "kernels.working_irradiance": (
        kernels.working_irradiance,
        {
            "radiance": IMAGE,
            "normals": NORMALS,
            "border_sampled": FLAG,
            "columns": SIZE,
            "source_fraction": SHARE,
        },
    ),
}
