"""MuJoCo: lights and the ambient part of the headlight, as MJCF for its classic renderer.

That renderer is the fixed-function pipeline of OpenGL: a pixel is the colour of the material times
the sum of the lights, without 1 / pi, without a transfer function, and clipped at 1. It has eight
lights, and the headlight is one of them.
"""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from envlights._common.words import fill_template
from envlights.environment.reading import AnyMap
from envlights.export.exposure import with_exposure
from envlights.export.files import AnyPath, save_scene
from envlights.export.formats.xml_text import comment, document
from envlights.export.scene import Discs, Exportable
from envlights.export.targets import AXES, CASTERS

#: Metres from the origin to each lamp, where its shadow map begins. MuJoCo draws shadow maps to 50
#: times the extent of the model, so shadows need an extent of 0.2 to 10 metres.
_DISTANCE = 10.0

_COMMENT = """
  Lights of envlights for the classic renderer of MuJoCo. z is up; the centre of the map is along x.
  A white matte surface has the pixel value envlights_scale times its irradiance in the map's unit,
  linear and from 0 to 1: apply the sRGB curve to the picture for a display.
  @UNITS@
"""


def mujoco(
    rig: Exportable, environment: AnyMap | None = None, *, scale: float | None = None
) -> str:
    """MJCF of up to seven directional lights, and an ambient term in the headlight.

    Include it in a model, ``<include file="hall.mujoco.xml"/>``, or open it as one. A ``headlight``
    after that line changes the ambient term.

    Axes: our x, y, z are y, z, x in MuJoCo, +z up. The centre of the map is along +x, the front of
    robots by custom; its left quarter is along +y.

    Units: MuJoCo multiplies the colour of a material by the sum of its lights, clips the result at
    1, and shows it without a transfer function. So a white matte surface has the pixel value
    `scale` times its irradiance, linear: apply the sRGB curve to the picture for a display.

    Kept: directions, irradiances, the mean of the ambient term or of the map. The three brightest
    lights cast shadows; each is a further pass of 8 bits, so that seven would lose 3 of 255 codes.
    Lost: sizes; an ambient term over a floor also comes from below. Beyond seven lights, the
    others become part of the ambient term.

    Parameters
    ----------
    rig : Rig or Lights
    environment : EnvMap or array_like, optional
        Map that replaces the ambient term; only its mean radiance is used.
    scale : float, optional
        Pixel value of a white matte surface per unit of its irradiance. Default: the largest
        one that clips no white surface, whatever its normal. ``1 / pi`` gives radiance.

    Returns
    -------
    str
        XML; its ``numeric`` element ``envlights_scale`` has the scale.

    Raises
    ------
    EnvLightsError
        If `scale` is negative or not finite.

    Notes
    -----
    Shadows need a model with an extent of 0.2 to 10 metres around the origin. The Filament renderer
    of MuJoCo shows one directional light and has its own ambient light. Source: `render_gl3.c` and
    `engine_vis_visualize.c` of MuJoCo 3.12.

    Examples
    --------
    >>> import envlights as el
    >>> model = el.export.mujoco(el.Lights([[0, 0, 1]], [[4, 2, 1]]))
    >>> lamp = ElementTree.fromstring(model).find("worldbody/light")
    >>> lamp.get("dir"), lamp.get("diffuse")
    ('-1.0 0.0 0.0', '1.0 0.5 0.25')
    """
    scene, factor = with_exposure("mujoco", rig, environment, scale)
    root = ElementTree.Element("mujoco", model="envlights")
    root.append(comment(fill_template(_COMMENT, units=scene.statement)))
    custom = ElementTree.SubElement(root, "custom")
    ElementTree.SubElement(custom, "numeric", name="envlights_scale", data=repr(factor))
    # Its other parts would light what the camera sees from the camera.
    colours = {
        "ambient": _numbers(factor * np.pi * scene.constant),
        "diffuse": "0 0 0",
        "specular": "0 0 0",
    }
    ElementTree.SubElement(ElementTree.SubElement(root, "visual"), "headlight", colours)
    world = ElementTree.SubElement(root, "worldbody")
    for j, attributes in enumerate(_lamps(scene.lights, factor)):
        ElementTree.SubElement(world, "light", {"name": f"envlights_{j}", **attributes})
    return document(root)


def save_mujoco(
    rig: Exportable, path: AnyPath, environment: AnyMap | None = None, *, scale: float | None = None
) -> None:
    """Write `mujoco` at `path`."""
    save_scene(path, mujoco(rig, environment, scale=scale))


def _lamps(lights: Discs, factor: float) -> list[dict[str, str]]:
    """Attributes of each light; its highlights on a material are as bright as its diffuse light."""
    return [
        {
            "directional": "true",  # `type` needs MuJoCo 3.3.3
            "pos": _numbers(_DISTANCE * towards),
            "dir": _numbers(0.0 - towards),
            "diffuse": _numbers(factor * irradiance),
            "specular": _numbers(factor * irradiance),
            "castshadow": "true" if j < CASTERS else "false",
        }
        for j, (towards, irradiance) in enumerate(
            zip(AXES["mujoco"].to_target(lights.direction), lights.irradiance, strict=True)
        )
    ]


def _numbers(values: NDArray[Any]) -> str:
    return " ".join(map(repr, values.tolist()))
