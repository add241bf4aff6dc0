"""Calls of what concerns shiny objects and harmonics, for `calls.py`."""

from hypothesis import strategies as st

import envlights as el
from envlights import kernels
from tests.call_values import ANGLES, COLOURS, COUNT, FEW, FLAG, IMAGE

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
    "kernels.expand_discs": (
        kernels.expand_discs,
        {"directions": FEW, "irradiance": COLOURS, "angular_radius": ANGLES, "degree": COUNT},
    ),
    "kernels.expand_map": (
        kernels.expand_map,
        {"radiance": IMAGE, "degree": COUNT, "border_sampled": FLAG},
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
