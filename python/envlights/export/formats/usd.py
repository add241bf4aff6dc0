"""OpenUSD: distant lights and a dome, as text (.usda) or as a binary crate (.usdc)."""

from __future__ import annotations

import importlib
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from envlights._common.files import as_path
from envlights._common.words import fill_template
from envlights._native import EnvLightsError
from envlights.environment.envmap import AnyMap
from envlights.export.files import AnyPath
from envlights.export.formats import usd_cards
from envlights.export.formats.usd_text import asset, colour, prim, string
from envlights.export.scene import Exportable, Scene, scene_of
from envlights.export.targets import AXES
from envlights.export.textures import Beside, save_beside

_HEAD = """#usda 1.0
(
    defaultPrim = "rig"
    doc = @UNITS@
    metersPerUnit = 1
    upAxis = "Y"
)

def Xform "rig"
{
"""
#: Quantities in a stage.
QUANTITIES = "Lights: irradiance at normal incidence; dome: radiance; linear Rec.709 RGB; "


def usd(rig: Exportable, environment: AnyMap | None = None, *, texture: str = "ambient.exr") -> str:
    r"""A stage of lights as text, to be referenced or opened.

    Parameters
    ----------
    rig : Rig, Lights or Cards
    environment : EnvMap or array_like, optional
        Map that replaces the ambient term.
    texture : str
        Name of the map's file beside the stage, if there is a map; `save_usd` writes it.

    Returns
    -------
    str
        ``DistantLight``: along its local -z, `angle` is the full angle in degrees, and `normalize`
        makes intensity times color our irradiance, in W m\ :sup:`-2`, whatever the angle.
        ``DomeLight``: intensity times color is our radiance; or a latlong texture with our
        orientation. The stage has +y up. After `EnvMap.calibrated` the numbers are lux and cd/m2,
        the units of UsdLux at exposure 0.

    Examples
    --------
    >>> import envlights as el
    >>> text = el.export.usd(el.Lights([[0, 1, 0]], [[3, 1.5, 0]], [0.1]))
    >>> "float inputs:intensity = 3.0" in text, "color3f inputs:color = (1.0, 0.5, 0.0)" in text
    (True, True)
    """
    return _text(scene_of(rig, environment, target="usd"), Beside(texture))


def save_usd(
    rig: Exportable, path: AnyPath, environment: AnyMap | None = None, *, texture: str | None = None
) -> None:
    """Write `usd` as text (.usda, .usd), or as a crate (.usdc), which needs the extra `usd`.

    A map goes beside it, ``scene.ambient.exr``, unless it is the file `texture`.
    """
    scene = scene_of(rig, environment, target="usd")
    is_crate = as_path(path).suffix.lower() == ".usdc"

    def content(scene: Scene, names: Beside) -> str | bytes:
        text = _text(scene, names)
        return crate(text) if is_crate else text

    save_beside(path, scene, "usd", content, texture, crop_of=usd_cards.texture)


def _text(scene: Scene, names: Beside) -> str:
    lights = scene.lights
    rows = zip(lights.direction, lights.irradiance, lights.angular_radius, strict=True)
    prims = [_light(f"light_{j}", *row) for j, row in enumerate(rows)]
    prims += usd_cards.prims(scene.panels, names.prefix)
    if scene.environment is not None:
        file = [
            f"asset inputs:texture:file = {asset(names.map)}",
            'token inputs:texture:format = "latlong"',
        ]
        prims.append(prim("DomeLight", "ambient", ["float inputs:intensity = 1.0", *file]))
    elif scene.ambient is not None:
        prims.append(prim("DomeLight", "ambient", colour(scene.ambient)))
    units = string(f"{QUANTITIES}{scene.statement}")
    return fill_template(_HEAD, units=units) + "\n".join(prims) + "}\n"


def _light(
    name: str, direction: NDArray[np.float64], irradiance: NDArray[np.float64], radius: float
) -> str:
    """A distant light whose local +z points towards the light."""
    return prim(
        "DistantLight",
        name,
        [
            f"float inputs:angle = {float(2 * np.rad2deg(radius))!r}",
            *colour(irradiance),
            "bool inputs:normalize = 1",
            f"matrix4d xformOp:transform = {light_matrix(direction)}",
            'uniform token[] xformOpOrder = ["xformOp:transform"]',
        ],
    )


def light_matrix(direction: NDArray[np.float64]) -> str:
    """Rotation of a light with its local +z towards `direction`, as a literal."""
    z = AXES["usd"].to_target(direction)
    # The rotation about the light's own axis is arbitrary.
    x = np.cross([0.0, 1.0, 0.0] if abs(z[1]) < 0.9 else [1.0, 0.0, 0.0], z)
    x /= np.linalg.norm(x)
    rows = [(*axis.tolist(), 0.0) for axis in (x, np.cross(z, x), z)]
    return f"( {', '.join(map(repr, [*rows, (0.0, 0.0, 0.0, 1.0)]))} )"


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
