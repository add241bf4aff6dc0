"""Radiance: a description of lights, for `oconv`."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import describe
from envlights._native import EnvLightsError
from envlights.environment.envmap import EnvMap
from envlights.environment.reading import AnyMap
from envlights.export.discs import split_by_size, with_discs
from envlights.export.files import CONTROLS, AnyPath, check_link
from envlights.export.look_up import looked_up
from envlights.export.scene import Exportable, Scene, scene_of
from envlights.export.targets import AXES
from envlights.export.textures import Beside, save_beside

#: Angular radius in radians above which a light is drawn into the sky. Radiance samples a source
#: near its centre only: the error is 0.9 % for a radius of 0.25, and 2.2 % for 0.6.
_WIDE = 0.2
#: Largest radiance, because Radiance has single precision.
_LARGEST = float(np.finfo(np.float32).max)
#: Angular radius of a point; a source must have one.
_POINT = 1e-4
_HEADER = (
    "Lights of envlights, z up. Units: {units}.",
    "rtrace and rpict: -ab 1 or more for the ambient term and wide lights, -dj 1 for soft shadows.",
)


def radiance(
    rig: Exportable, environment: AnyMap | None = None, texture: str = "ambient.hdr"
) -> str:
    r"""A description with a `source` for each light, and one for the sky.

    Axes: our x, y, z are y, z, x in Radiance, +z up, as in Blender; the centre of a map is in the
    east, along +x.

    Units: a source has radiance and the full angle of its disc in degrees; the radiance is
    irradiance over :math:`\pi \sin^2 a` for the angular radius a. Radiance reads the numbers as
    W/m²/sr. After `EnvMap.calibrated` they are cd/m² over Radiance's 179 lm/W: 179 times the result
    of `rtrace -I` is lux, with the weights 0.2126, 0.7152 and 0.0722 of Rec.709. The numbers of
    other maps have the scale of the map; `pfilt` and `ximage` set the exposure of a picture.

    Kept: directions, irradiances, sizes; a constant ambient term as `glow`; harmonics, an ambient
    term over a floor, and lights wider than 11 degrees in radius as a picture on a `glow`, which is
    sampled with the ambient light. A source hides the sky behind it, so the radiance of the sky
    is added to it. Lost: negative parts of harmonics, and up to 0.8 % in each sample of a picture,
    without bias.

    Parameters
    ----------
    rig : Rig or Lights
    environment : EnvMap or array_like, optional
        Map that replaces the ambient term.
    texture : str
        Name of the picture of the sky, if there is one; `save_radiance` writes it. Radiance looks
        for it in the working directory, then in the folders of RAYPATH.

    Examples
    --------
    >>> import envlights as el
    >>> text = el.export.radiance(el.Lights([[0, 1, 0]], [[3, 2, 1]], [0.1]))
    >>> print(*text.splitlines()[-8:], sep="\n")
    void light light_0_colour
    0
    0
    3 95.8119134 63.8746089 31.9373045
    light_0_colour source light_0
    0
    0
    4 0 0 1 11.4591559
    """
    return _description(_scene(rig, environment), Beside(texture))


def save_radiance(rig: Exportable, path: AnyPath, environment: AnyMap | None = None) -> None:
    """Write `radiance` at `path`, and the picture of the sky beside it, if there is one."""
    save_beside(path, _scene(rig, environment), "radiance", _description, map_of=_picture)


def _scene(rig: Exportable, environment: AnyMap | None) -> Scene:
    """Lights that are sampled one by one, with the wide lights in the sky around them."""
    scene = scene_of(rig, environment, target="radiance")
    narrow, wide = split_by_size(scene.lights, least=_WIDE)
    return with_discs(scene, wide)._replace(lights=narrow)


def _description(scene: Scene, names: Beside) -> str:
    lights = scene.lights
    radius = np.maximum(lights.angular_radius, _POINT)
    seen = lights.irradiance / (np.pi * np.sin(radius) ** 2)[:, None] + _sky(scene)
    if seen.max(initial=0) > _LARGEST:
        raise EnvLightsError(
            f"Radiance has single precision (up to {_LARGEST:.3g}), and a light has the"
            f" radiance {seen.max():.3g}; scale the rig, or give its lights a size"
        )
    towards = AXES["radiance"].to_target(lights.direction)
    sources = [
        _source("light", f"light_{j}", rgb, direction, 2 * angle)
        for j, (rgb, direction, angle) in enumerate(zip(seen, towards, radius, strict=True))
    ]
    header = "".join(_comment(line.format(units=scene.statement)) for line in _HEADER)
    return "\n".join([header, *sources, *_glow(scene, names.map)])


def _sky(scene: Scene) -> NDArray[np.float64]:
    """Radiance of the sky behind each light, (n, 3)."""
    if scene.environment is not None:
        return looked_up(scene.environment, scene.lights.direction).astype(np.float64)
    return scene.constant


def _glow(scene: Scene, name: str) -> list[str]:
    """A source in all directions with a constant or a picture; none for a black sky."""
    up, around = np.array([0, 0, 1]), 2 * np.pi
    if scene.environment is not None:
        where = f"{_word(name)} . {_look_up(scene.environment)}"
        picture = f"void colorpict sky_map\n7 red green blue {where}\n0\n0\n"
        return [picture + _source("glow", "sky", np.ones(3), up, around, "sky_map")]
    if scene.ambient is not None:
        return [_source("glow", "sky", scene.ambient, up, around)]
    return []


def _picture(scene: Scene) -> NDArray[np.float32] | None:
    """Pixels of a map with one more pixel on each side, because Radiance does not wrap pictures."""
    if scene.environment is None:
        return None
    rows = np.pad(scene.environment.radiance, ((1, 1), (0, 0), (0, 0)), "edge")
    return np.pad(rows, ((0, 0), (1, 1), (0, 0)), "wrap")


def _look_up(env: EnvMap) -> str:
    """Column and row of `_picture` in a direction of the sky; the centre looks along +x.

    Radiance interpolates between pixels; the outer ones lie on the edges of the picture, at 0 and
    1, or at the aspect ratio along the longer side.
    """
    width, height = env.width, env.height
    aspect = (width + 2) / (height + 2)
    column = f"{aspect!r}*({width / 2!r}*(1-atan2(Dy,Dx)/PI)+0.5)/{width + 1}"
    row = f"({height}*(0.5+atan2(Dz,sqrt(Dx*Dx+Dy*Dy))/PI)+0.5)/{height + 1}"
    return f"{column} {row}"


def _comment(text: str) -> str:
    """Lines of a comment; the space at their ends hides a backslash, which would join two lines.

    Radiance reads 2047 bytes of a comment and parses the rest as a part of the scene, where an
    exclamation mark begins a command. A character has up to 4 bytes.
    """
    return "".join(f"# {text[start : start + 500]} \n" for start in range(0, len(text), 500))


def _word(name: str) -> str:
    """File name as one word of a description, in quotes where that is necessary."""
    # Versions that know no quotes would run what follows a line break and an exclamation mark.
    check_link(name, "Radiance", CONTROLS)
    quotes = [quote for quote in "\"'" if quote not in name]
    if not quotes or name.startswith("~"):
        raise EnvLightsError(
            "Radiance cannot read the name of a picture that begins with ~ or holds both kinds of"
            f" quotes; got {describe(name)}; give the scene another name"
        )
    is_plain = len(quotes) == 2 and not any(letter.isspace() for letter in name)
    return name if is_plain else f"{quotes[0]}{name}{quotes[0]}"


def _source(
    kind: str,
    name: str,
    values: NDArray[np.float64],
    direction: NDArray[np.float64],
    angle: float,
    pattern: str = "void",
) -> str:
    """A material and a disc of it at infinity; `glow` is not sampled as a direct light."""
    values = np.append(values, [0.0] if kind == "glow" else [])
    disc = [*direction, np.rad2deg(angle)]
    material = f"{pattern} {kind} {name}_colour\n0\n0\n{len(values)} {_numbers(values)}\n"
    return f"{material}{name}_colour source {name}\n0\n0\n4 {_numbers(disc)}\n"


def _numbers(values: ArrayLike) -> str:
    return " ".join(f"{value + 0.0:.9g}" for value in np.asarray(values, float))
