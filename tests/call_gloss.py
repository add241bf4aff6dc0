"""Calls of what concerns shiny objects, for `calls.py`."""

from hypothesis import strategies as st

import envlights as el
from envlights import kernels
from tests.call_values import FLAG, IMAGE

ROUGHNESS = st.floats(0.3, 1)
GLOSS_CALLS = {
    "fit to an error of metal": (
        el.fit,
        {"env": IMAGE, "gloss_error": st.floats(0.1, 1), "roughness": ROUGHNESS},
    ),
    "error_curve": (
        el.error_curve,
        {
            "env": IMAGE,
            "lights": st.lists(st.integers(0, 2), min_size=1, max_size=2),
            "roughness": ROUGHNESS,
            "sizes": FLAG,
            "floor": FLAG,
        },
    ),
    "kernels.gloss.spectrum": (
        kernels.gloss.spectrum,
        {
            "roughness": ROUGHNESS,
            "degree": st.integers(0, 40),
            "material": st.sampled_from(["metal", "plastic"]),
            "base": st.floats(0, 1),
        },
    ),
}
