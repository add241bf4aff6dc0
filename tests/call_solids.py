"""Calls of the functions on solids, for the table in `calls.py`."""

import numpy as np
from hypothesis import strategies as st

import envlights as el
from envlights import kernels
from envlights.kernels.solids import Stage
from tests.call_values import ANGLES, COLOUR, COLOURS, FEW, FLAG, RIG, SIZE, array

BALL, BOX = el.scene.Ball((0, 0.5, 0), 0.5), el.scene.Box((1.2, 0.4, 0), (0.4, 0.4, 0.4), 0.3)
POINTS = np.array([[0, 0, 0], [0.5, 0, 0.2], [3, 0, 1.0]])
VECTOR = st.sampled_from([(0, 1, 0), [0.5, 1, -2], np.ones(3)])
LENGTH = st.floats(0.1, 10)
STAGE = st.sampled_from([Stage.floor(each, POINTS) for each in ([], BALL, [BALL, BOX])])
SOLIDS = st.sampled_from([[], BALL, [BALL, BOX], (BOX, BOX)])

SOLID_CALLS = {
    "Ball": (el.scene.Ball, {"centre": VECTOR, "radius": LENGTH}),
    "Box": (
        el.scene.Box,
        {
            "centre": VECTOR,
            "half_sides": VECTOR,
            "turn": st.one_of(st.floats(-4, 4), st.just(np.eye(3))),
        },
    ),
    "Polyhedron": (
        el.scene.Polyhedron,
        {"vertices": st.just(BOX.vertices), "faces": st.sampled_from([BOX.faces, BOX.faces[:5]])},
    ),
    "shadow_overlay": (
        el.scene.shadow_overlay,
        {
            "rig": st.just(RIG),
            "solids": SOLIDS,
            "points": st.one_of(st.none(), st.just(POINTS), array(4, 5, 3)),
            "columns": SIZE,
            "floor_albedo": COLOUR,
            "albedo": st.one_of(st.none(), COLOUR),
        },
    ),
    "kernels.form_factors": (kernels.form_factors, {"stage": STAGE}),
    "kernels.hidden_fractions": (
        kernels.hidden_fractions,
        {"stage": STAGE, "directions": FEW, "angular_radius": ANGLES, "floor": FLAG},
    ),
    "kernels.reflected_irradiance": (
        kernels.reflected_irradiance,
        {
            "stage": st.just(Stage.floor(BALL, POINTS)),
            "ambient": COLOUR,
            "directions": FEW,
            "irradiance": COLOURS,
            "angular_radius": ANGLES,
            "albedo": st.sampled_from([[[0.5] * 3], np.ones((1, 3))]),
            "floor_albedo": COLOUR,
            "floor": FLAG,
        },
    ),
}
