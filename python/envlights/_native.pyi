"""Types of the Rust kernels. `make types` checks this file against the built module."""

from typing import final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "EnvLightsError",
    "TreeDetection",
    "detect_tree",
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

@final
class TreeDetection:
    direction: _Reals
    irradiance: _Reals
    peak_direction: _Reals
    orientation: _Reals
    solid_angle: _Reals
    elongation: _Reals
    peak_luminance: _Reals
    flux: _Reals
    top_pixels: NDArray[np.int64]
    pixel: NDArray[np.int64]
    light_of_pixel: NDArray[np.int64]
    threshold: float
    background_is_light: bool
    map_flux: float
    working_size: tuple[int, int]
    tiles: int
    opened_tiles: int
    bright_pixels: int
    dropped: int
    merged: int

def detect_tree(
    radiance: NDArray[np.float32],
    border_sampled: bool,
    working_columns: int,
    prominence: float,
    extent: float,
    gap: float,
    min_flux_share: float,
    max_lights: int,
) -> TreeDetection: ...
def direction_to_uv(direction: _Reals) -> _Reals: ...
def fit_lights(
    normals: _Reals,
    weights: _Reals,
    irradiance: _Reals,
    start: _Reals,
    lights: int,
    max_steps: int,
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
