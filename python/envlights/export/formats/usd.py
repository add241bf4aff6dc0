"""OpenUSD: distant lights and a dome, as text (.usda) or as a binary crate (.usdc)."""

from __future__ import annotations

import importlib
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from envlights._common.files import as_path
from envlights._native import EnvLightsError
from envlights.environment.reading import AnyMap
from envlights.export.files import AnyPath
from envlights.export.formats import usd_cards
from envlights.export.formats.usd_stage import Stage
from envlights.export.formats.usd_text import asset, colour, prim
from envlights.export.scene import Exportable, Scene, scene_of
from envlights.export.textures import Beside, save_beside


def usd(
    rig: Exportable,
    environment: AnyMap | None = None,
    *,
    texture: str = "ambient.exr",
    up: str = "y",
    metres_per_unit: float = 1.0,
) -> str:
    r"""A stage of lights as text, to be referenced or opened.

    Parameters
    ----------
    rig : Rig, Lights or Cards
    environment : EnvMap or array_like, optional
        Map that replaces the ambient term.
    texture : str
        Name of the map's file beside the stage, if there is a map; `save_usd` writes it.
    up : {"y", "z"}
        Up axis of the stage. "z" is that of Isaac Sim and most robot simulators: our x, y, z are
        x, z, -y there, as OpenUSD turns a dome (``OrientToStageUpAxis``), so the centre of the map
        is along -y. A stage does not turn what it references: give the axis of your own stage.
    metres_per_unit : float
        Length of a unit of the stage in metres (``metersPerUnit``), such as 0.01 for centimetres.

    Returns
    -------
    str
        ``DistantLight``: along its local -z, `angle` is the full angle in degrees, and `normalize`
        makes intensity times color our irradiance, in W m\ :sup:`-2`, whatever the angle.
        ``DomeLight``: intensity times color is our radiance; or a latlong texture with our
        orientation. After `EnvMap.calibrated` the numbers are lux and cd/m2,
        the units of UsdLux at exposure 0.

    Examples
    --------
    >>> import envlights as el
    >>> text = el.export.usd(el.Lights([[0, 1, 0]], [[3, 1.5, 0]], [0.1]))
    >>> "float inputs:intensity = 3.0" in text, "color3f inputs:color = (1.0, 0.5, 0.0)" in text
    (True, True)
    >>> robots = el.export.usd(el.Lights([[0, 1, 0]], [[3, 1.5, 0]]), up="z")
    >>> 'upAxis = "Z"' in robots, "(0.0, 0.0, 1.0, 0.0)" in robots
    (True, True)
    """
    stage = Stage(up, metres_per_unit).checked()
    return _text(scene_of(rig, environment, target="usd"), Beside(texture), stage)


def save_usd(
    rig: Exportable,
    path: AnyPath,
    environment: AnyMap | None = None,
    *,
    texture: str | None = None,
    up: str = "y",
    metres_per_unit: float = 1.0,
) -> None:
    """Write `usd` as text (.usda, .usd), or as a crate (.usdc), which needs the extra `usd`.

    A map goes beside it, ``scene.ambient.exr``, unless it is the file `texture`.
    """
    stage = Stage(up, metres_per_unit).checked()
    scene = scene_of(rig, environment, target="usd")
    is_crate = as_path(path).suffix.lower() == ".usdc"

    def content(scene: Scene, names: Beside) -> str | bytes:
        text = _text(scene, names, stage)
        return crate(text) if is_crate else text

    save_beside(path, scene, "usd", content, texture, crop_of=usd_cards.texture)


def _text(scene: Scene, names: Beside, stage: Stage) -> str:
    lights = scene.lights
    rows = zip(lights.direction, lights.irradiance, lights.angular_radius, strict=True)
    prims = [_light(stage, f"light_{j}", *row) for j, row in enumerate(rows)]
    prims += usd_cards.prims(stage.placed(scene.panels), names.prefix)
    if scene.environment is not None:
        file = [
            f"asset inputs:texture:file = {asset(names.map)}",
            'token inputs:texture:format = "latlong"',
        ]
        prims.append(
            prim("DomeLight", "ambient", ["float inputs:intensity = 1.0", *file, *stage.dome_turn])
        )
    elif scene.ambient is not None:
        prims.append(prim("DomeLight", "ambient", colour(scene.ambient)))
    return stage.text(prims, scene.statement)


def _light(
    stage: Stage,
    name: str,
    direction: NDArray[np.float64],
    irradiance: NDArray[np.float64],
    radius: float,
) -> str:
    """A distant light whose local +z points towards the light."""
    return prim(
        "DistantLight",
        name,
        [
            f"float inputs:angle = {float(2 * np.rad2deg(radius))!r}",
            *colour(irradiance),
            "bool inputs:normalize = 1",
            f"matrix4d xformOp:transform = {stage.light_matrix(direction)}",
            'uniform token[] xformOpOrder = ["xformOp:transform"]',
        ],
    )


def crate(text: str) -> bytes:
    """The binary form of a stage, which only the library of OpenUSD writes."""
    try:
        # Import it only when needed: it is in the extra `usd`.
        sdf = importlib.import_module("pxr.Sdf")
    except ImportError as error:
        raise EnvLightsError(
            f"OpenUSD cannot be imported: {error}; install it with pip install 'envlights[usd]', or"
            " save an .usda, which needs no OpenUSD"
        ) from None
    layer = sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(text)
    with tempfile.TemporaryDirectory() as folder:
        crate = Path(folder, "scene.usdc")
        try:
            layer.Export(str(crate))
            return crate.read_bytes()
        except (RuntimeError, OSError) as error:  # as on a full disk
            raise EnvLightsError(
                "OpenUSD cannot write a crate; save an .usda, or set TMPDIR to a folder with room"
            ) from error
