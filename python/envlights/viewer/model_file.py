"""Reader of models by trimesh: triangles and linear albedos."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._common import check
from envlights._common.errors import MissingFileError
from envlights._common.srgb import decode_srgb
from envlights._native import EnvLightsError
from envlights.viewer.gltf_size import check_size

#: Largest number of triangles: 8 MB in the page, 11 MB as text.
MOST_TRIANGLES = 200_000
#: Albedo of triangles without a colour: that of the ball and of the box.
ALBEDO = 0.7
#: Suffixes of the files that are read.
SUFFIXES = (".glb", ".gltf", ".obj", ".off", ".ply", ".stl")
#: Largest number of meshes in a scene: trimesh needs the square of it if they hang on each other.
_MOST_MESHES = 1000
#: Memory for arrays of a small file: a kilobyte for each triangle.
_MOST_BYTES = MOST_TRIANGLES * 1024
#: Files whose colours are linear, as glTF has them; others hold sRGB.
_LINEAR = (".glb", ".gltf")


class Part(NamedTuple):
    """One mesh of a model, in its place."""

    vertices: NDArray[np.float64]
    """Positions, (n, 3)."""

    triangles: NDArray[np.int64]
    """Rows of vertices, (m, 3)."""

    albedo: NDArray[np.float64]
    """Linear albedo of each corner, (m, 3, 3)."""


def check_count(triangles: int) -> None:
    """Refuse a model without triangles, or with more than a page can show."""
    if triangles == 0:
        raise EnvLightsError(
            "a model must have at least one triangle; got none; export its surfaces as a mesh"
        )
    if triangles > MOST_TRIANGLES:
        raise EnvLightsError(
            f"a model may have up to {MOST_TRIANGLES} triangles; got {triangles}; simplify it,"
            " for example with trimesh's simplify_quadric_decimation or Blender's Decimate"
        )


def read(source: Any) -> list[Part]:
    """Parts of a file or of an object of trimesh."""
    is_path = isinstance(source, str | os.PathLike)
    trimesh = _library()
    if not is_path and not isinstance(source, trimesh.Trimesh | trimesh.Scene):
        raise EnvLightsError(
            "a model must be a path, an object of trimesh or an envlights.viewer.Model;"
            f" got {check.describe(source)}"
        )
    suffix = _suffix(Path(os.fsdecode(source))) if is_path else ""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            given = _load(trimesh, source) if is_path else source
            return list(_parts(trimesh, given, suffix in _LINEAR))
    except EnvLightsError:
        raise
    except (Exception, RecursionError) as error:
        said = f"{type(error).__name__}: {error}"[:200]
        raise EnvLightsError(
            f"it cannot be read as a model ({said}); export it again, for example as GLB"
        ) from None


def _suffix(path: Path) -> str:
    """Suffix of a file that exists and is of a kind that is read."""
    if not path.exists():
        raise MissingFileError("there is no such file; check its path")
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise EnvLightsError(
            f"a model must be a file of the kind {', '.join(SUFFIXES)}; export it as GLB"
        )
    return suffix


def _library() -> Any:
    try:
        return import_module("trimesh")
    except ImportError:
        raise EnvLightsError(
            "a model in a file needs the library trimesh; install envlights[models], or pass"
            " envlights.viewer.Model(vertices, triangles)"
        ) from None


def _load(trimesh: Any, path: str | os.PathLike[str]) -> Any:
    """Scene of a file, with the vertices as they are."""
    file = Path(os.fsdecode(path))
    if file.suffix.lower() in _LINEAR:
        check_size(file, _MOST_BYTES)
    return trimesh.load_scene(file, process=False)


def _parts(trimesh: Any, given: Any, is_linear: bool) -> Iterator[Part]:
    """Yield the meshes of a scene, each in its place, if they are not too many."""
    scene = trimesh.Scene(given) if isinstance(given, trimesh.Trimesh) else given
    if len(scene.graph.nodes_geometry) > _MOST_MESHES:
        raise EnvLightsError(
            f"a model may have up to {_MOST_MESHES} meshes; got"
            f" {len(scene.graph.nodes_geometry)}; join them, for example in Blender with Ctrl-J"
        )
    places = [scene.graph[node] for node in scene.graph.nodes_geometry]
    meshes = [(matrix, scene.geometry[name]) for matrix, name in places]
    meshes = [(matrix, mesh) for matrix, mesh in meshes if isinstance(mesh, trimesh.Trimesh)]
    check_count(sum(len(mesh.faces) for _, mesh in meshes))
    for matrix, mesh in meshes:
        triangles = np.asarray(mesh.faces, dtype=np.int64)
        points = np.asarray(mesh.vertices, dtype=np.float64)
        moved = points @ np.asarray(matrix)[:3, :3].T + np.asarray(matrix)[:3, 3]
        yield Part(moved, triangles, _albedo(mesh, triangles, is_linear))


def _albedo(mesh: Any, triangles: NDArray[np.int64], is_linear: bool) -> NDArray[np.float64]:
    """Linear albedo of each corner of a mesh, (m, 3, 3)."""
    visual = mesh.visual
    material = getattr(visual, "material", None)
    if material is not None:
        return _of_material(material, visual.uv, triangles)
    if visual.kind == "vertex":
        codes = np.asarray(visual.vertex_colors)[triangles]
    elif visual.kind == "face":
        codes = np.repeat(np.asarray(visual.face_colors)[:, None], 3, axis=1)
    else:
        return np.full((len(triangles), 3, 3), ALBEDO)
    colours = codes[..., :3] / 255
    return np.asarray(colours if is_linear else decode_srgb(colours), dtype=np.float64)


def _of_material(material: Any, uv: Any, triangles: NDArray[np.int64]) -> NDArray[np.float64]:
    """Albedo of a material: its colour times its texture at the corners."""
    image = getattr(material, "baseColorTexture", None) or getattr(material, "image", None)
    factor = getattr(material, "baseColorFactor", getattr(material, "diffuse", None))
    has_texture = image is not None and uv is not None
    plain = 1.0 if has_texture else ALBEDO
    colour = np.full(3, plain) if factor is None else np.asarray(factor)[:3] / 255
    albedo = np.broadcast_to(colour, (len(triangles), 3, 3))
    if has_texture:
        albedo = albedo * decode_srgb(_texels(image, np.asarray(uv, dtype=np.float64))[triangles])
    return np.asarray(albedo, dtype=np.float64)


def _texels(image: Any, uv: NDArray[np.float64]) -> NDArray[np.float64]:
    """Codes from 0 to 1 of a texture that repeats, (n, 3), at coordinates from its lower left."""
    (width, height), most = image.size, import_module("PIL.Image").MAX_IMAGE_PIXELS
    if most and width * height > most:
        raise EnvLightsError(
            f"a texture may have up to {most} pixels; got {width} x {height}; scale it down"
        )
    pixels = np.asarray(image.convert("RGB"))
    place = np.nan_to_num(uv % 1.0)
    columns = np.minimum((place[:, 0] * width).astype(np.int64), width - 1)
    rows = np.minimum(((1 - place[:, 1]) * height).astype(np.int64), height - 1)
    return np.asarray(pixels[rows, columns] / 255)
