"""Data of a page: rigs, the map as a picture, its irradiance, and the albedo of its ground."""

from __future__ import annotations

import base64
import io
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.srgb import encode_srgb
from envlights._native import EnvLightsError
from envlights.environment.envmap import EnvMap
from envlights.environment.harmonics import FACTORS
from envlights.fitting.fit import fit
from envlights.kernels import sphere, thumbnails
from envlights.kernels.image import LUMINANCE
from envlights.kernels.probe import working_irradiance
from envlights.rigs.lights import Lights
from envlights.rigs.rig import Rig
from envlights.scene.panorama_floor import floor_albedo, floor_irradiance, measured_floor_albedo

#: Largest number of lights that are fitted beforehand; the shader has an array of this length.
MOST_LIGHTS = 8
#: Columns of the picture.
_COLUMNS = 2048
#: Radiance of the largest code over the white of a picture of the map: exposure can go down by 2
#: stops before clipped parts turn grey.
_HEADROOM = 4.0
#: Radiance of a white surface that faces up, over that of a white pixel.
_TOP = 0.5
#: Qualities that are tried until the picture has at most this number of bytes. Below 90, smooth
#: walls show blocks.
_QUALITIES, _MOST_BYTES = (97, 94, 90, 80, 60), 300_000
#: Rows of the map that is drawn for a rig without a map, and the albedo of its ground.
_ROWS_OF_RIG, _GROUND_OF_RIG = 512, 0.25
#: Rows of the table of the map's irradiance over all normals, which is smooth.
_ROWS = 28
#: Angle in radians from the brightest light to the camera: a little behind the things.
_ACROSS = 1.9


def fitted_rigs(env: EnvMap) -> dict[str, list[Rig]]:
    """Rigs of 1 to 8 lights for each ambient term and shape of lights.

    Those with a constant ambient term are fitted over a floor. Harmonics cannot be.
    """
    counts = range(1, MOST_LIGHTS + 1)
    rigs = {}
    for shape, sizes in (("discs", True), ("points", False)):
        rigs[f"constant {shape}"] = [fit(env, n, sizes=sizes, floor=True) for n in counts]
        rigs[f"harmonics {shape}"] = [fit(env, n, sizes=sizes, ambient="sh2") for n in counts]
    return rigs


def rigs_of(rig: Rig) -> dict[str, list[Rig]]:
    """Rig with its discs and, if it has any, with points in their place."""
    name = "constant" if rig.ambient.ndim == 1 else "harmonics"
    rigs = {f"{name} discs": [rig]}
    if rig.lights.angular_radius.any():
        points = Lights(rig.lights.direction, rig.lights.irradiance)
        rigs[f"{name} points"] = [Rig(rig.ambient, points, 0.0, floor=rig.floor)]
    return rigs


def map_of(rig: Rig) -> EnvMap:
    """Map of the lights of a rig; over a floor, with a grey ground that they light."""
    env = rig.to_map(_ROWS_OF_RIG)
    if not rig.floor:
        return env
    radiance = env.radiance.copy()
    radiance[_ROWS_OF_RIG // 2 :] = _GROUND_OF_RIG / np.pi * rig.probe([0.0, 1.0, 0.0])
    return EnvMap(radiance)


def rig_data(rig: Rig) -> dict[str, Any]:
    """Rig as the page takes it: radiance or harmonics of irradiance, and seven numbers a light."""
    ambient = np.atleast_2d(rig.ambient)
    lights = rig.lights
    columns = (lights.direction, lights.irradiance, lights.angular_radius[:, None])
    return {
        "ambient": (ambient if len(ambient) == 1 else FACTORS[:, None] * ambient).tolist(),
        "floor": rig.floor,
        "error": None if rig.error is None else float(f"{rig.error:.3g}"),
        "lights": np.hstack(columns).tolist(),
        "origin": lights.origin,
    }


def rig_file(rig: Rig) -> dict[str, Any]:
    """Content of the file of a rig of the page: all but what the page shows, and no report."""
    empty = Rig(np.zeros(3), rig.lights[:0], notes=rig.notes)
    return {"file": empty.to_dict(), "factors": FACTORS.tolist(), "luminance": LUMINANCE.tolist()}


def picture(env: EnvMap) -> dict[str, Any]:
    """Map as an encoded picture, the radiance of its largest code, and an exposure.

    The exposure is that of pictures of the map, or up to one stop off for things that would be dim
    or white.
    """
    radiance = env.radiance
    white, _ = thumbnails.white_of(radiance)
    bright = _TOP * np.pi / float(floor_irradiance(env) @ LUMINANCE)
    small = thumbnails.shrink(radiance, _COLUMNS)
    codes = np.round(255 * encode_srgb(small / (_HEADROOM * white))).astype(np.uint8)
    return {
        "map": address(codes),
        "white": _HEADROOM * white,
        "exposure": float(np.clip(bright, 0.5 / white, 2 / white)),
    }


def address(codes: NDArray[np.uint8]) -> str:
    """A picture as an address that holds it: WebP, or JPEG where the image library lacks it."""
    try:
        from PIL import Image, features
    except ImportError:
        raise EnvLightsError(
            "view needs Pillow for the picture of the map: pip install 'envlights[models]', or pip"
            " install pillow"
        ) from None
    kind = "webp" if features.check("webp") else "jpeg"
    image, content = Image.fromarray(codes), b""
    for quality in _QUALITIES:
        file = io.BytesIO()
        image.save(file, kind, quality=quality)
        content = file.getvalue()
        if len(content) <= _MOST_BYTES:
            break
    return f"data:image/{kind};base64,{base64.b64encode(content).decode()}"


def irradiance_table(env: EnvMap, unit: float, over_floor: bool) -> dict[str, Any]:
    """Irradiance over all normals in units of `unit`, as half floats; of the upper half if wanted.

    Half floats end at 65504, which a sun in physical units exceeds.
    """
    radiance = env.radiance
    if over_floor:
        radiance = radiance.copy()
        radiance[env.height // 2 :] = 0
    normals = sphere.pixel_directions(_ROWS, 2 * _ROWS).reshape(-1, 3)
    values, _ = working_irradiance(radiance, normals, border_sampled=env.is_border_sampled)
    halves = (values / unit).astype("<f2").tobytes()
    return {"size": [2 * _ROWS, _ROWS], "halves": base64.b64encode(halves).decode()}


def floor_of(env: EnvMap) -> tuple[NDArray[np.float64], list[str]]:
    """Albedo of the ground of the map by channel, and a note if it is not plausible."""
    albedo, measured = floor_albedo(env), measured_floor_albedo(env)
    if np.array_equal(albedo, measured):
        return albedo, []
    figure = f"{measured @ LUMINANCE:.2g}" if np.isfinite(measured).all() else "unknown"
    return albedo, [
        f"The ground of the map reflects {figure} of the light that reaches it, which is not"
        f" plausible; the page uses {albedo @ LUMINANCE:.2g}."
    ]


def azimuth(rigs: dict[str, list[Rig]]) -> float:
    """Azimuth of the camera: across the brightest light, whose shadow then falls to the side."""
    lights = next(iter(rigs.values()))[-1].lights
    if not len(lights):
        return 0.0
    x, _, z = lights.direction[int(np.argmax(lights.irradiance @ LUMINANCE))]
    return float(np.arctan2(x, z) + _ACROSS)
