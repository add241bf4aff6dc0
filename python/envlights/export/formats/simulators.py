"""SAPIEN and Genesis: a Python script whose function gives the lights to a scene."""

from __future__ import annotations

from typing import Any

from envlights._common.words import fill_template
from envlights.environment.reading import AnyMap
from envlights.export.exposure import with_exposure
from envlights.export.files import AnyPath, save_scene
from envlights.export.scene import Exportable
from envlights.export.targets import AXES

_NUMBERS = """
import math

# Units: @UNITS@.
# z is up; the centre of the map is along x. Colours are linear Rec.709.
# Direction in which each light travels, and its irradiance at normal incidence.
LIGHTS = [
@LIGHTS@]
# Radiance from all directions.
AMBIENT = @AMBIENT@
# Linear value of a white matte pixel over its irradiance; pixels are clipped at 1.
SCALE = @SCALE@
FACTOR = math.pi * SCALE

"""
_SAPIEN = f'''\
"""SAPIEN, ManiSkill: runpy.run_path("FILE")["add_lights"](scene) adds lights of envlights."""
{_NUMBERS}
def add_lights(scene):
    """Add the lights to a scene; the first one casts shadows, as SAPIEN has one such light."""
    scene.set_ambient_light([FACTOR * x for x in AMBIENT])
    for j, (direction, rgb) in enumerate(LIGHTS):
        scene.add_directional_light(direction, [FACTOR * x for x in rgb], shadow=j == 0)
'''
_GENESIS = f'''\
"""Genesis: gs.Scene(vis_options=runpy.run_path("FILE")["vis_options"]()) has our lights."""
{_NUMBERS}
def vis_options(**more):
    """Options of a scene with these lights, and with more options."""
    import genesis as gs

    most = max([x for _, rgb in LIGHTS for x in rgb] or [1]) or 1
    kind = {{"type": "directional", "intensity": FACTOR * most}}
    lights = [{{**kind, "dir": to, "color": tuple(x / most for x in rgb)}} for to, rgb in LIGHTS]
    ambient = tuple(min(1, FACTOR * x) for x in AMBIENT)  # Genesis refuses more than 1
    return gs.options.VisOptions(lights=lights, ambient_light=ambient, **more)
'''


def sapien(
    rig: Exportable, environment: AnyMap | None = None, *, scale: float | None = None
) -> str:
    """A script with a function ``add_lights(scene)``, for SAPIEN and ManiSkill.

    As `mujoco`, with its axes and its `scale`, but three lights, and shadows of the first.
    Pixels are encoded by 1 / 2.2; ``scale=1 / pi`` gives SAPIEN the numbers of the map.

    Examples
    --------
    >>> import envlights as el
    >>> script = el.export.sapien(el.Lights([[0, 1, 0]], [[4, 2, 1]]))
    >>> next(line for line in script.splitlines() if line.startswith("    ("))
    '    ([0.0, 0.0, -1.0], [4.0, 2.0, 1.0]),'
    """
    return _script(_SAPIEN, "sapien", rig, environment, scale)


def genesis(
    rig: Exportable, environment: AnyMap | None = None, *, scale: float | None = None
) -> str:
    """A script with a function ``vis_options()``, for the scene of Genesis.

    As `sapien`, but four lights that all cast shadows, and an ambient light of at most 1.
    """
    return _script(_GENESIS, "genesis", rig, environment, scale)


def save_sapien(
    rig: Exportable, path: AnyPath, environment: AnyMap | None = None, *, scale: float | None = None
) -> None:
    """Write `sapien` at `path`."""
    save_scene(path, sapien(rig, environment, scale=scale))


def save_genesis(
    rig: Exportable, path: AnyPath, environment: AnyMap | None = None, *, scale: float | None = None
) -> None:
    """Write `genesis` at `path`."""
    save_scene(path, genesis(rig, environment, scale=scale))


def _script(template: str, target: str, *parts: Any) -> str:
    scene, factor = with_exposure(target, *parts)
    travels = (0.0 - AXES[target].to_target(scene.lights.direction)).tolist()
    rows = zip(travels, scene.lights.irradiance.tolist(), strict=True)
    return fill_template(
        template,
        units=scene.statement,
        lights="".join(f"    ({there}, {rgb}),\n" for there, rgb in rows),
        ambient=str(scene.constant.tolist()),
        scale=repr(factor),
    )
