"""Types of the Rust kernels. `make types` checks this file against the built module."""

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "EnvLightsError",
    "direction_to_uv",
    "fit_lights",
    "halton",
    "hammersley",
    "icosphere",
    "irradiance",
    "pixel_directions",
    "pixel_solid_angles",
    "radical_inverse",
    "relative_rms",
    "rig_irradiance",
    "sum_over_sources",
    "uniform_sphere",
    "unusable",
    "uv_to_direction",
    "working_irradiance",
]

_Reals = NDArray[np.float64]

class EnvLightsError(ValueError): ...

def direction_to_uv(direction: _Reals) -> _Reals: ...
def fit_lights(
    normals: _Reals, weights: _Reals, irradiance: _Reals, lights: int, max_steps: int
) -> list[tuple[list[float], _Reals, _Reals, float, int, str]]: ...
def halton(count: int, bases: list[int]) -> _Reals: ...
def hammersley(count: int) -> _Reals: ...
def icosphere(faces: int) -> tuple[_Reals, _Reals]: ...
def irradiance(radiance: NDArray[np.float32], normals: _Reals, border_sampled: bool) -> _Reals: ...
def pixel_directions(height: int, width: int, border_sampled: bool) -> _Reals: ...
def pixel_solid_angles(height: int, width: int, border_sampled: bool) -> _Reals: ...
def radical_inverse(index: int, base: int) -> float: ...
def relative_rms(seen: _Reals, wanted: _Reals, weights: _Reals) -> float: ...
def rig_irradiance(
    normals: _Reals, ambient: list[float], directions: _Reals, irradiance: _Reals
) -> _Reals: ...
def sum_over_sources(
    normals: _Reals,
    directions: _Reals,
    radiance: _Reals,
    solid_angles: _Reals,
    k_d: float,
    colour: list[float],
) -> _Reals: ...
def uniform_sphere(uv: _Reals) -> _Reals: ...
def unusable(radiance: NDArray[np.float32]) -> tuple[int, int, int]: ...
def uv_to_direction(uv: _Reals) -> _Reals: ...
def working_irradiance(
    radiance: NDArray[np.float32],
    normals: _Reals,
    border_sampled: bool,
    columns: int,
    source_share: float,
) -> tuple[_Reals, int]: ...
