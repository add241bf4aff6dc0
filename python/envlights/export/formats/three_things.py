"""Objects of three.js in the form that its ObjectLoader reads."""

from __future__ import annotations

import colorsys
import uuid
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.srgb import encode_srgb

#: Constants of three.js: FloatType, RGBAFormat, LinearFilter.
_FLOATS = {
    "type": 1015,
    "format": 1023,
    "minFilter": 1006,
    "magFilter": 1006,
    "colorSpace": "srgb-linear",
    "flipY": True,
    "generateMipmaps": False,
}


def thing_of(kind: str, name: str, **parts: Any) -> dict[str, Any]:
    """Object of a scene."""
    return {"uuid": uuid_of(name), "type": kind, "name": name, **parts}


def colour_of(values: NDArray[np.float64]) -> dict[str, Any]:
    """Colour and intensity with the product `values`.

    A hexadecimal colour has only 8 bits, so the colour is given as hue, saturation and lightness.
    three.js decodes it from sRGB.
    """
    most = float(values.max())
    codes = encode_srgb(values / (most or 1.0))
    hue, lightness, saturation = colorsys.rgb_to_hls(*codes.tolist())
    colour = f"hsl({360 * hue:.12f},{100 * saturation:.12f}%,{100 * lightness:.12f}%)"
    return {"color": colour, "intensity": most}


def image_of(name: str, radiance: NDArray[np.float32]) -> dict[str, Any]:
    """Image in the form of `DataTexture`."""
    height, width, _ = radiance.shape
    opaque = np.ones((height, width, 1), np.float32)
    samples = np.concatenate([radiance, opaque], axis=2)
    data = [float(f"{sample:.7g}") for sample in samples.ravel().tolist()]
    content = {"data": data, "width": width, "height": height, "type": "Float32Array"}
    return {"uuid": uuid_of(name), "url": content}


def texture_of(key: str, name: str, image: dict[str, Any], **parts: Any) -> dict[str, Any]:
    """Texture of an image of floats; `key` gives its identifier."""
    return {"uuid": uuid_of(key), "name": name, "image": image["uuid"], **parts, **_FLOATS}


def uuid_of(name: str) -> str:
    """Identifier that depends on the name alone, so that files can be compared."""
    return str(uuid.uuid5(uuid.NAMESPACE_URL, f"envlights/{name}"))
