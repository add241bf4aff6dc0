"""Calls of the functions that compare lightings and lights."""

from hypothesis import strategies as st

import envlights as el
from envlights import kernels
from tests.call_values import (
    COLOURS,
    COUNT,
    FEW,
    FLAG,
    IMAGE,
    LIGHT_SETS,
    RIGS,
    SHARE,
    SIZE,
    SMALL,
    array,
)

COMPARISON_CALLS = {
    "compare": (
        el.compare,
        {
            "truth": st.one_of(IMAGE, RIGS),
            "guess": st.one_of(IMAGE, RIGS),
            "protocol": st.sampled_from(["exact", el.comparison.Protocol(gamma=2.2, median=0.5)]),
        },
    ),
    "compare_lights": (
        el.comparison.compare_lights,
        {"truth": LIGHT_SETS, "guess": LIGHT_SETS, "strongest": COUNT},
    ),
    "compare_folders": (
        el.compare_folders,
        {"truth": st.just("no-folder"), "guess": st.just("no-folder"), "progress": st.none()},
    ),
    "image_errors": (
        el.comparison.image_errors,
        {
            "truth": st.one_of(COLOURS, array(4, 8, 3)),
            "guess": st.one_of(COLOURS, array(4, 8, 3)),
            "mask": st.one_of(st.none(), array(4, 8)),
            "channels": st.sampled_from(["mean", "sum"]),
        },
    ),
    "Protocol": (
        el.comparison.Protocol,
        {
            "name": st.just("own"),
            "gamma": st.one_of(st.none(), SMALL),
            "median": st.one_of(st.none(), SMALL),
            "rows": st.one_of(st.none(), SIZE),
            "channels": st.sampled_from(["mean", "sum"]),
            "black": st.sampled_from(["left out", "perfect"]),
            "normalised": FLAG,
        },
    ),
    "Protocol.named": (
        el.comparison.Protocol.named,
        {"name": st.sampled_from(["exact", "stylelight"])},
    ),
    "vector_angle": (el.comparison.vector_angle, {"truth": IMAGE, "guess": IMAGE}),
    "kernels.transport_plan": (
        kernels.transport_plan,
        {
            "from_directions": FEW,
            "from_weights": array(5),
            "to_directions": FEW,
            "to_weights": array(5),
        },
    ),
    "kernels.gloss.spectrum": (
        kernels.gloss.spectrum,
        {
            "roughness": st.floats(0.2, 1),
            "degree": st.integers(0, 40),
            "material": st.sampled_from(["metal", "plastic"]),
            "base": SHARE,
        },
    ),
    "kernels.rough_reflection": (
        kernels.rough_reflection,
        {
            "radiance": st.one_of(IMAGE, array(4, 8, 6)),
            "normals": FEW,
            "views": FEW,
            "roughness": st.floats(0.1, 1),
            "specular": SHARE,
        },
    ),
    "kernels.weighted_means": (
        kernels.weighted_means,
        {"points": FEW, "weights": array(5), "light": st.just([0, 0, 1, 1, 2])},
    ),
}
