"""Calls of the functions that compare lights."""

import envlights as el
from envlights import kernels
from tests.call_values import COUNT, FEW, IMAGE, LIGHT_SETS, array

COMPARISON_CALLS = {
    "compare_lights": (
        el.compare_lights,
        {"truth": LIGHT_SETS, "guess": LIGHT_SETS, "strongest": COUNT},
    ),
    "vector_angle": (el.vector_angle, {"truth": IMAGE, "guess": IMAGE}),
    "kernels.transport_plan": (
        kernels.transport_plan,
        {
            "from_directions": FEW,
            "from_weights": array(5),
            "to_directions": FEW,
            "to_weights": array(5),
        },
    ),
}
