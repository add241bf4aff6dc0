"""Compiled steps on plain NumPy arrays, one function per step.

Directions are unit vectors in the frame of `EnvMap`: right-handed, +y up, the centre of an
equirectangular image along +z, its left quarter along +x. All arrays are float64 unless a
function says otherwise; none is changed. An array must not be written to by another thread while a
kernel reads it.
"""

from envlights.kernels import gloss
from envlights.kernels.harmonics import (
    expand_discs,
    expand_map,
    harmonic_irradiance,
    harmonic_radiance,
)
from envlights.kernels.image import (
    area_means,
    blur,
    luminance,
    reduced_luminance,
    resize_bilinear,
    uv_to_pixel,
)
from envlights.kernels.loghin import (
    bresenham_line,
    merge_along_lines,
    neighbour_maximum,
    suppress,
    weighted_means,
)
from envlights.kernels.madsen import (
    face_radiance,
    pack_lights,
    probe_jacobian,
    probe_model,
    probe_residual,
    unpack_lights,
)
from envlights.kernels.occluder import form_factors, hidden_fractions, reflected_irradiance
from envlights.kernels.probe import (
    WORKING_COLUMNS,
    disc_map,
    irradiance,
    relative_rms,
    rig_irradiance,
    sum_over_sources,
    working_irradiance,
)
from envlights.kernels.reflection import rough_reflection
from envlights.kernels.sampling import (
    halton,
    hammersley,
    icosphere,
    radical_inverse,
    uniform_sphere,
)
from envlights.kernels.sphere import (
    direction_to_uv,
    pixel_directions,
    pixel_solid_angles,
    uv_to_direction,
)
from envlights.kernels.transport import transport_plan

__all__ = [
    "WORKING_COLUMNS",
    "area_means",
    "blur",
    "bresenham_line",
    "direction_to_uv",
    "disc_map",
    "expand_discs",
    "expand_map",
    "face_radiance",
    "form_factors",
    "gloss",
    "halton",
    "hammersley",
    "harmonic_irradiance",
    "harmonic_radiance",
    "hidden_fractions",
    "icosphere",
    "irradiance",
    "luminance",
    "merge_along_lines",
    "neighbour_maximum",
    "pack_lights",
    "pixel_directions",
    "pixel_solid_angles",
    "probe_jacobian",
    "probe_model",
    "probe_residual",
    "radical_inverse",
    "reduced_luminance",
    "reflected_irradiance",
    "relative_rms",
    "resize_bilinear",
    "rig_irradiance",
    "rough_reflection",
    "sum_over_sources",
    "suppress",
    "transport_plan",
    "uniform_sphere",
    "unpack_lights",
    "uv_to_direction",
    "uv_to_pixel",
    "weighted_means",
    "working_irradiance",
]


def __dir__() -> list[str]:
    return sorted(__all__)
