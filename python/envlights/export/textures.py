"""Texture files of a scene: their names, and writing them with the scene."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._common.files import as_path
from envlights.export.files import AnyPath, save_scene
from envlights.export.panels import Panel, crop_names
from envlights.export.scene import Scene
from envlights.export.targets import PANORAMA, TARGETS


class Beside(NamedTuple):
    """Names of the texture files of a scene."""

    map: str
    """Name of the map."""

    prefix: str = ""
    """Prefix for the names of card textures."""


def _cells(scene: Scene) -> NDArray[np.float32] | None:
    return None if scene.environment is None else scene.environment.cells()


def save_beside(
    path: AnyPath,
    scene: Scene,
    target: str,
    content_of: Callable[[Scene, Beside], str | bytes],
    texture: str | None = None,
    *,
    map_of: Callable[[Scene], NDArray[Any] | None] = _cells,
    crop_of: Callable[[Panel], NDArray[Any]] | None = None,
) -> None:
    """Write a scene together with its textures.

    Parameters
    ----------
    path : path-like
        File of the scene.
    scene : Scene
    target : str
        Name of the target, which determines the names of textures.
    content_of : callable
        Content of the file, for the names of its textures.
    texture : str, optional
        Name of an existing file of the map. By default, the map is written: in
        ``scene.ambient.exr`` beside ``scene.usda``, or in a file of the target's own.
    map_of : callable
        Samples of the map in the form of the target; None without a map.
    crop_of : callable, optional
        Samples of the texture of a card in the form of the target.
    """
    stem, ends = as_path(path).stem, {each.name: each.texture for each in TARGETS}
    names = Beside(texture or f"{stem}{ends.get(target) or PANORAMA}", f"{stem}.")
    drawn = map_of(scene) if texture is None else None
    textures = {} if drawn is None else {names.map: drawn}
    if crop_of is not None:
        crops = crop_names(scene.panels, names.prefix, target)
        textures |= {n: crop_of(each) for n, each in zip(crops, scene.panels, strict=True) if n}
    save_scene(path, content_of(scene, names), textures)
