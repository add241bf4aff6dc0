"""Types of the Rust kernels. `make types` checks this file against the built module."""

from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from envlights.detection.detect import TreeOptions
from envlights.environment.layouts.picture_layout import PictureLayout
from envlights.fitting.request import FitOptions
from envlights.kernels.loghin import LineRule
from envlights.kernels.occluder import _Lighting
from envlights.kernels.solids import Stage

# fmt: off
__all__ = [
    "BASIS_SHARE",
    "BASIS_TILE",
    "GLOSS_DEGREE",
    "HARMONIC_FACTORS",
    "LEAST_WHITE",
    "LUMINANCE",
    "MOST_PARTS",
    "ClippedDetection",
    "DamagedBytesError",
    "EnvLightsError",
    "FitAnswer",
    "MapCards",
    "MapSplit",
    "PictureFile",
    "ReducedMap",
    "RowReducer",
    "TreeDetection",
    "TriangleTree",
    "UnusableSamplesError",
    "apply_matrix",
    "are_clipped",
    "area_means",
    "assignment",
    "blur",
    "bounding_volume_hierarchy",
    "bresenham_line",
    "clean",
    "clipped_depth",
    "clipped_fraction",
    "clipped_light_shares",
    "code_histogram_8",
    "code_histogram_16",
    "continue_reduced",
    "cut_cards",
    "decode_8",
    "decode_16",
    "detect_tree",
    "direction_to_uv",
    "disc_map",
    "draw_cards",
    "even_sphere",
    "expand_discs",
    "expand_map",
    "expand_reduced",
    "exr_file",
    "face_radiance",
    "fill_unseen",
    "fit_reduced",
    "fit_samples",
    "form_factors",
    "gloss_spectrum",
    "halton",
    "hammersley",
    "harmonic_irradiance",
    "harmonic_radiance",
    "hidden_fractions",
    "icosphere",
    "irradiance",
    "kernel_spectra",
    "luminance",
    "map_energy",
    "merge_along_lines",
    "near_irradiance",
    "neighbour_maximum",
    "nine_harmonics",
    "overview",
    "pack_lights",
    "pixel_directions",
    "pixel_solid_angles",
    "plane_threshold",
    "png_file",
    "probe_jacobian",
    "probe_model",
    "probe_residual",
    "projection_directions",
    "projection_places",
    "projection_solid_angles",
    "radiance_rows",
    "radical_inverse",
    "reduce_map",
    "reduced_luminance",
    "reflected_irradiance",
    "relative_rms",
    "resample",
    "resize_bilinear",
    "rig_error",
    "rig_irradiance",
    "rotate_map",
    "rough_reflection",
    "split_map",
    "sum_over_sources",
    "suppress",
    "threads",
    "tiff_file",
    "transfer_columns",
    "transfer_frames",
    "transfer_gram",
    "transport_plan",
    "uniform_sphere",
    "unpack_lights",
    "uv_to_direction",
    "uv_to_pixel",
    "weighted_means",
    "white_code",
    "widen",
    "working_irradiance",
]
# fmt: on

_Reals = NDArray[np.float64]
_Image = NDArray[np.float32]
_Indices = NDArray[np.int64]
#: Ambient and diffuse coefficient and colour of a surface.
_Coefficients = tuple[float, float, list[float]]
#: `envlights.environment.clean.Cleaned`.
_Cleaned = tuple[int, int, int, float | None, bool]
#: `envlights.splitting.split.LightPixels`.
_LightPixels = tuple[_Indices, _Indices, _Reals, int, float, _Image]

LEAST_WHITE: float
GLOSS_DEGREE: int
HARMONIC_FACTORS: list[float]
LUMINANCE: list[float]
MOST_PARTS: int
BASIS_SHARE: int
BASIS_TILE: int

class EnvLightsError(ValueError): ...
class DamagedBytesError(EnvLightsError): ...
class UnusableSamplesError(EnvLightsError): ...

@final
class ClippedDetection:
    direction_uncertainty: _Reals
    weight: _Reals
    clip_level: float
    is_below_largest: bool
    clipped_fraction: float

@final
class ReducedMap:
    floor: bool
    overview: _Image

@final
class RowReducer:
    block: int
    retained_bytes: int
    def __new__(
        cls,
        size: tuple[int, int, bool],
        cells: tuple[int, float, bool],
        sample: str,
        table: NDArray[np.float32],
    ) -> RowReducer: ...
    @property
    def histogram(self) -> _Reals: ...
    def add(self, rows: NDArray[Any]) -> None: ...
    def clipped(self, value: float) -> tuple[float, float] | None: ...
    def finish(self) -> tuple[ReducedMap, _Cleaned, float]: ...

@final
class TreeDetection:
    direction: _Reals
    irradiance: _Reals
    flux: _Reals
    peak_direction: _Reals
    orientation: _Reals
    solid_angle: _Reals
    elongation: _Reals
    peak_luminance: _Reals
    flux_fraction: _Reals
    is_clipped: NDArray[np.bool_]
    is_cut: NDArray[np.bool_]
    pixel: _Indices
    light_of_pixel: _Indices
    luminance: NDArray[np.float32]
    panes: list[int]
    widest_bar: tuple[float, float]
    threshold: float
    threshold_rule: tuple[float, float, float | None] | None
    working_size: tuple[int, int]
    tiles: int
    opened_tiles: int
    dropped: int
    merged: int
    clipped: ClippedDetection | None

@final
class TriangleTree:
    def __new__(cls, corners: _Reals) -> TriangleTree: ...
    def nearest(
        self, origins: _Reals, directions: _Reals
    ) -> tuple[_Indices, _Reals, NDArray[np.bool_]]: ...

@final
class FitAnswer:
    points: int
    lights: int
    angular_radii: list[float]
    at_bound: list[int]
    shadow_error: float
    objective_error: float
    bands: list[list[float]]
    points_error: float
    fitted_points_error: float
    channels: int
    errors: list[tuple[int, float]]
    error: float
    channel_errors: list[float]
    max_error: float
    map_samples: tuple[_Reals, _Reals, _Reals] | None
    steps: int
    stop: str
    seconds: list[tuple[str, float]]
    tolerances: list[float]
    condition: float
    direction_errors: list[float]
    irradiance_errors: list[list[float]]
    @property
    def ambient(self) -> _Reals: ...
    @property
    def directions(self) -> _Reals: ...
    @property
    def irradiance(self) -> _Reals: ...

@final
class MapCards:
    remainder: _Image
    shape: list[int]
    matrix: _Reals
    irradiance: _Reals
    overlap: _Reals
    radius: list[float | None]
    texture: list[_Image]
    lights: list[list[int]]
    is_window: list[bool]

@final
class MapSplit:
    remainder: _Image
    map_flux: float
    direction: _Reals
    irradiance: _Reals
    flux: _Reals
    solid_angle: _Reals
    reach: _Reals
    vectors: _Reals
    light_of_block: NDArray[np.uint32]

def apply_matrix(image: _Image, matrix: list[list[float]]) -> tuple[_Image, int]: ...
def are_clipped(
    radiance: _Image, pixels: _Indices, reach: int, sphere: bool, clip_level: float | None
) -> NDArray[np.bool_]: ...
def area_means(image: _Image | _Reals, rows: int, columns: int) -> _Reals: ...
def assignment(costs: _Reals) -> _Indices: ...
def blur(image: _Image, sigma: float, wrap: bool) -> _Image: ...
def bounding_volume_hierarchy(
    vertices: NDArray[np.uint16], triangles: NDArray[np.uint32]
) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]: ...
def bresenham_line(start: list[int], end: list[int]) -> _Indices: ...
def clipped_depth(
    radiance: _Image, border_sampled: bool, clip_level: float, working_columns: int, gap: float
) -> _Image: ...
def clipped_light_shares(
    radiance: _Image, border_sampled: bool, clip_level: float, working_columns: int, gap: float
) -> _Image: ...
def clipped_fraction(
    radiance: _Image, border_sampled: bool, clip_level: float | None
) -> tuple[float, float]: ...
def clean(radiance: _Image, wraps: bool) -> tuple[_Image, _Cleaned] | None: ...
def decode_16(codes: NDArray[np.uint16], tables: _Image, values: _Image) -> None: ...
def code_histogram_8(codes: NDArray[np.uint8], weights: _Reals) -> _Reals: ...
def code_histogram_16(codes: NDArray[np.uint16], weights: _Reals) -> _Reals: ...
def cut_cards(
    radiance: _Image,
    rest: _Image,
    border_sampled: bool,
    block: int,
    pixel: _Indices,
    light_of_pixel: _Indices,
    direction: _Reals,
    radius: _Reals,
) -> MapCards: ...
def decode_8(codes: NDArray[np.uint8], tables: _Image, values: _Image) -> None: ...
def detect_tree(
    radiance: _Image, border_sampled: bool, options: TreeOptions, seen: _Image | None
) -> TreeDetection: ...
def direction_to_uv(direction: _Reals) -> _Reals: ...
def disc_map(height: int, directions: _Reals, irradiance: _Reals, radii: _Reals) -> _Reals: ...
def draw_cards(
    height: int,
    width: int,
    border_sampled: bool,
    matrix: _Reals,
    is_disc: list[bool],
    irradiance: _Reals,
    sizes: list[list[int]],
    texels: _Image,
) -> _Image: ...
def even_sphere(count: int) -> _Reals: ...
def expand_discs(directions: _Reals, irradiance: _Reals, radii: _Reals, degree: int) -> _Reals: ...
def expand_map(radiance: _Image, degree: int, border_sampled: bool) -> _Reals: ...
def expand_reduced(
    reduced: ReducedMap,
) -> tuple[_Reals, list[float], _Reals, _Reals, _Reals]: ...
def face_radiance(radiance: _Image, faces: int, border_sampled: bool) -> _Reals: ...
def fill_unseen(
    radiance: _Image, seen: _Image, border_sampled: bool, columns: int, most: float
) -> _Image: ...
def continue_reduced(
    reduced: ReducedMap, options: FitOptions, radii: _Reals
) -> tuple[_Reals, _Reals, _Reals, list[float], float, float, tuple[_Reals, _Reals, _Reals]]: ...
def fit_reduced(reduced: ReducedMap, options: FitOptions, counts: list[int]) -> list[FitAnswer]: ...
def fit_samples(
    normals: _Reals, weights: _Reals, irradiance: _Reals, options: FitOptions
) -> FitAnswer: ...
def gloss_spectrum(roughness: float, degree: int, base: float | None) -> _Reals: ...
def halton(count: int, bases: list[int]) -> _Reals: ...
def hammersley(count: int) -> _Reals: ...
def harmonic_irradiance(normals: _Reals) -> _Reals: ...
def harmonic_radiance(directions: _Reals) -> _Reals: ...
def hidden_fractions(stage: Stage, directions: _Reals, radii: _Reals, floor: bool) -> _Reals: ...
def form_factors(stage: Stage) -> _Reals: ...
def reflected_irradiance(stage: Stage, lighting: _Lighting) -> _Reals: ...
def icosphere(faces: int) -> tuple[_Reals, _Reals]: ...
def irradiance(radiance: _Image, normals: _Reals, border_sampled: bool) -> _Reals: ...
def kernel_spectra(degree: int) -> list[_Reals]: ...
def luminance(radiance: _Image) -> _Image: ...
def map_energy(
    radiance: _Image, border_sampled: bool, columns: int, point_share: float
) -> float: ...
def merge_along_lines(
    luminance: _Image, pixels: _Indices, points: _Reals, rule: LineRule
) -> _Indices: ...
def near_irradiance(
    points: _Reals, normals: _Reals, spheres: _Reals, cards: _Reals, patches: _Reals
) -> _Reals: ...
def neighbour_maximum(
    luminance: _Image, pixels: _Indices, reach: int, sphere: bool
) -> tuple[_Image, _Indices]: ...
def nine_harmonics(radiance: _Image, border_sampled: bool) -> _Reals: ...
def pack_lights(ambient: _Reals, directions: _Reals, irradiance: _Reals) -> _Reals: ...
def overview(radiance: _Image, border_sampled: bool, columns: int) -> _Image: ...
def pixel_directions(
    height: int, width: int, border_sampled: bool, top: int, bottom: int
) -> _Reals: ...
def pixel_solid_angles(height: int, width: int, border_sampled: bool) -> _Reals: ...
def plane_threshold(luminance: _Image) -> float: ...
def probe_jacobian(
    x: _Reals, normals: _Reals, probe: _Reals, weights: _Reals, surface: _Coefficients
) -> _Reals: ...
def probe_model(x: _Reals, normals: _Reals, surface: _Coefficients) -> _Reals: ...
def probe_residual(
    x: _Reals, normals: _Reals, probe: _Reals, weights: _Reals, surface: _Coefficients
) -> _Reals: ...
def radiance_rows(radiance: _Image, rounds: bool) -> bytes: ...
def radical_inverse(index: int, base: int) -> float: ...
def projection_directions(layout: PictureLayout, places: _Reals) -> _Reals: ...
def projection_places(layout: PictureLayout, directions: _Reals) -> _Reals: ...
def projection_solid_angles(layout: PictureLayout) -> _Reals: ...
def reduce_map(
    radiance: _Image, border_sampled: bool, columns: int, source_fraction: float, floor: bool
) -> ReducedMap: ...
def reduced_luminance(radiance: _Image, columns: int, border_sampled: bool) -> _Image: ...
def relative_rms(seen: _Reals, wanted: _Reals, weights: _Reals) -> float: ...
def resize_bilinear(image: _Image, height: int, width: int, wrap: bool) -> _Image: ...
def rig_error(
    samples: tuple[_Reals, _Reals, _Reals],
    ambient: _Reals,
    directions: _Reals,
    irradiance: _Reals,
    radii: list[float],
    floor: bool,
) -> float: ...
def rig_irradiance(
    normals: _Reals,
    ambient: _Reals,
    directions: _Reals,
    irradiance: _Reals,
    radii: _Reals,
    floor: bool,
) -> _Reals: ...
def resample(
    radiance: _Image,
    seen: _Image | None,
    source: PictureLayout,
    target: PictureLayout,
    matrix: _Reals,
) -> tuple[_Image, _Image | None]: ...
def rotate_map(radiance: _Image, matrix: _Reals) -> _Image: ...
def rough_reflection(
    radiance: _Image, normals: _Reals, views: _Reals, roughness: float, specular: float
) -> _Reals: ...
def split_map(
    radiance: _Image, border_sampled: bool, lights: _LightPixels, seen: _Image | None
) -> MapSplit: ...
def sum_over_sources(
    normals: _Reals,
    directions: _Reals,
    radiance: _Reals,
    solid_angles: _Reals,
    k_d: float,
    colour: list[float],
) -> _Reals: ...
def suppress(points: _Reals, distance: float) -> _Indices: ...
def threads(wanted: int | None) -> int: ...
def transfer_columns(
    images: _Image, scale: _Image, non_black: NDArray[np.bool_], weights: _Image
) -> _Image: ...
def transfer_frames(
    values: NDArray[np.int8] | NDArray[np.float16],
    scales: _Image,
    coefficients: _Image,
    places: _Indices,
) -> _Image: ...
def transfer_gram(images: _Image, scale: _Image) -> tuple[_Reals, NDArray[np.bool_]]: ...
def transport_plan(
    from_directions: _Reals, from_weights: _Reals, to_directions: _Reals, to_weights: _Reals
) -> tuple[float, _Indices, _Reals]: ...
def uniform_sphere(uv: _Reals) -> _Reals: ...
def unpack_lights(x: _Reals) -> tuple[_Reals, _Reals, _Reals]: ...
def widen(halves: NDArray[np.float16], values: _Image) -> None: ...
def uv_to_direction(uv: _Reals) -> _Reals: ...
def uv_to_pixel(uv: _Reals, height: int, width: int) -> _Indices: ...
def weighted_means(points: _Reals, weights: _Reals, light: _Indices) -> _Reals: ...
def white_code(histogram: _Reals) -> int | None: ...
def working_irradiance(
    radiance: _Image,
    normals: _Reals,
    border_sampled: bool,
    columns: int,
    source_fraction: float,
) -> tuple[_Reals, int]: ...

@final
class PictureFile:
    def __new__(cls, data: bytes, kind: str, max_pixels: int) -> PictureFile: ...
    @property
    def parts(self) -> list[dict[str, Any]]: ...
    def apply_gain_map(self, values: _Image, top: int) -> None: ...
    def rows(self, part: int, channels: list[int], top: int, bottom: int) -> NDArray[Any]: ...

def exr_file(
    radiance: _Image,
    half: bool,
    compression: str,
    statements: tuple[tuple[float, ...], float | None, str, str],
) -> bytes: ...
def png_file(codes: NDArray[Any], description: str) -> bytes: ...
def tiff_file(radiance: _Image, description: str) -> bytes: ...
