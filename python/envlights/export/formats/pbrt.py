"""pbrt-v4: light sources, to be included in a scene."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights.environment.layouts.picture_layout import PBRT, PictureLayout, equirectangular
from envlights.environment.reading import AnyMap
from envlights.environment.resample import resample
from envlights.export.discs import split_by_size, with_discs
from envlights.export.files import AnyPath, check_link
from envlights.export.panels import Panel, crop_names
from envlights.export.scene import Exportable, Scene, scene_of
from envlights.export.targets import AXES
from envlights.export.textures import Beside, save_beside

#: Angular radius in radians below which a light has no size in pbrt: 0.7 degrees, which is four
#: pixels in the largest map of discs.
_NARROW = 4 * np.pi / 1024
#: Pixels along a side of pbrt's map for each row of ours: about the same at the horizon.
_SIDE = 1.25
#: Escapes of pbrt in a string.
_ESCAPES = str.maketrans(
    {
        **{"\\": r"\\", '"': r"\""},
        **{"\b": r"\b", "\f": r"\f", "\n": r"\n", "\r": r"\r", "\t": r"\t"},
    }
)
#: Card that reflects no light.
_MATTER = """AttributeBegin
  Material "diffuse" "rgb reflectance" [0 0 0]
  AreaLightSource "diffuse" {light}
  {shape}
AttributeEnd"""
_HEADER = "# Lights of envlights for pbrt-v4: Include this file after WorldBegin."


def pbrt(
    rig: Exportable, environment: AnyMap | None = None, texture: str = "ambient.pbrt.exr"
) -> str:
    """Light sources for pbrt-v4, to be included after ``WorldBegin``.

    Axes: our x, y, z are y, z, -x in pbrt, with +z up; pbrt is left-handed. So the lights fit the
    infinite light that ``imgtool makeequiarea`` makes of the panorama. If a scene is mirrored to be
    right-handed (``Scale -1 1 1``), the lights are mirrored with it.

    Units: ``rgb L`` of a distant light is irradiance at normal incidence; that of an infinite light
    is radiance, and so are the pixels of its map. pbrt scales an RGB of 1 to 1 lux or 1 cd/m2, so
    after `EnvMap.calibrated` the numbers are those. The film sets the exposure with ``iso`` and
    ``exposuretime``.

    Kept: directions, irradiances; a constant ambient term; harmonics, an ambient term over a floor,
    and lights with a radius of 0.7 degrees or more in an equal-area map. Lost: smaller sizes, such
    as that of the sun, because pbrt's distant lights have none; negative parts of harmonics.

    Parameters
    ----------
    rig : Rig, Lights or Cards
    environment : EnvMap or array_like, optional
        Map that replaces the ambient term.
    texture : str
        Name of the map's file, if there is an infinite light with a map; `save_pbrt` writes it.

    Examples
    --------
    >>> import envlights as el
    >>> print(el.export.pbrt(el.Lights([[0, 1, 0]], [[3, 2, 1]])).splitlines()[-1])
    LightSource "distant" "rgb L" [3 2 1] "point3 from" [0 0 1] "point3 to" [0 0 0]
    """
    return _sources(_scene(rig, environment), Beside(texture))


def save_pbrt(rig: Exportable, path: AnyPath, environment: AnyMap | None = None) -> None:
    """Write `pbrt` at `path`, and the map of an infinite light beside it, if there is one."""
    scene = _scene(rig, environment)
    save_beside(path, scene, "pbrt", _sources, map_of=_equal_area, crop_of=_crop)


def _crop(panel: Panel) -> NDArray[np.float32]:
    """Texture of a card; it hides the map, so it shows it too."""
    return panel.opaque_texture


def _scene(rig: Exportable, environment: AnyMap | None) -> Scene:
    """Distant lights, with the larger lights in the map around them."""
    scene = scene_of(rig, environment, target="pbrt")
    narrow, wide = split_by_size(scene.lights, least=_NARROW)
    return with_discs(scene, wide)._replace(lights=narrow)


def _sources(scene: Scene, names: Beside) -> str:
    lights = scene.lights
    towards = AXES["pbrt"].to_target(lights.direction)
    lines = [
        f'LightSource "distant" "rgb L" {_numbers(irradiance)}'
        f' "point3 from" {_numbers(direction)} "point3 to" [0 0 0]'
        for direction, irradiance in zip(towards, lights.irradiance, strict=True)
    ]
    crops = crop_names(scene.panels, names.prefix, "pbrt")
    lines += [_card(*each) for each in zip(scene.panels, crops, strict=True)]
    if scene.environment is not None:
        lines.append(f'LightSource "infinite" "string filename" {_string(names.map)}')
    elif scene.ambient is not None:
        lines.append(f'LightSource "infinite" "rgb L" {_numbers(scene.ambient)}')
    return "\n".join([_HEADER, f"# Units: {scene.statement}.", *lines]) + "\n"


def _card(panel: Panel, name: str) -> str:
    """A black surface that shines to the side of its normal."""
    if panel.shape in ("disc", "sphere"):
        light = f'"rgb L" {_numbers(panel.opaque_radiance)}'
        return _MATTER.format(light=light, shape=_round(panel))
    return _MATTER.format(light=f'"string filename" {_string(name)}', shape=_patch(panel))


def _patch(panel: Panel) -> str:
    """A bilinear patch whose (u, v) run from the lower left, because row 0 of an image is at v = 1.

    Its normal is the cross product of the derivatives, which points to the origin.
    """
    u, v, facing, centre = panel.axes("pbrt")
    if np.cross(u, -v) @ facing > 0:
        corners, uv = [-u + v, u + v, -u - v, u - v], "0 0 1 0 0 1 1 1"
    else:  # a frame that mirrors
        corners, uv = [-u + v, -u - v, u + v, u - v], "0 0 0 1 1 0 1 1"
    points = _numbers(np.ravel([centre + corner / 2 for corner in corners]))
    return f'Shape "bilinearmesh" "point3 P" {points} "point2 uv" [{uv}]'


def _round(panel: Panel) -> str:
    """A sphere, a disk, or a polygon for an ellipse: pbrt measures disks without their scale."""
    u, _, facing, centre = panel.axes("pbrt")
    if panel.shape == "sphere":
        translate = _numbers(centre).strip("[]")
        return f'Translate {translate} Shape "sphere" "float radius" {panel.radius:.9g}'
    if not (panel.is_rectangle and np.isclose(*panel.size)):
        return _ellipse(panel)
    x = u / np.linalg.norm(u)
    columns = [x, np.cross(facing, x), facing, centre]
    rows = [[*column, place] for column, place in zip(columns, (0, 0, 0, 1), strict=True)]
    radius = np.sqrt(panel.size.prod()) / 2
    return f'ConcatTransform {_numbers(np.ravel(rows))} Shape "disk" "float radius" {radius:.9g}'


def _ellipse(panel: Panel) -> str:
    """A fan of triangles whose normal, the cross product of two edges, points to the origin.

    An ellipse of 53 by 29 degrees as a disk made the error of a scene 7 % instead of 5 %.
    """
    points, _ = panel.outline("pbrt")
    _, _, facing, _ = panel.axes("pbrt")
    if np.cross(points[1] - points[0], points[2] - points[0]) @ facing < 0:
        points = points[::-1]
    fan = " ".join(f"0 {k} {k + 1}" for k in range(1, len(points) - 1))
    mesh = f'"point3 P" {_numbers(points.ravel())} "integer indices" [{fan}]'
    return f'Shape "trianglemesh" {mesh}'


def _string(name: str) -> str:
    """A name in quotes; pbrt knows few escapes, and none for letters beyond ASCII."""
    check_link(name, "pbrt")
    return f'"{name.translate(_ESCAPES)}"'


def _equal_area(scene: Scene) -> NDArray[np.float32] | None:
    """Map of a scene in the form of pbrt: a square of pixels with equal solid angles."""
    env = scene.environment
    if env is None:
        return None
    side = int(np.ceil(_SIDE * env.height))
    square = PictureLayout("octahedral-equal-area", side, side, axes=PBRT)
    return resample(env.radiance, None, equirectangular(env.height), square)[0]


def _numbers(values: NDArray[np.float64]) -> str:
    return f"[{' '.join(f'{value + 0.0:.9g}' for value in values)}]"
