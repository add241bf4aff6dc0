"""Light sources of a pbrt-v4 file, read by the definitions in its book (Pharr et al. 2023).

Section 12.2 has the distant light, whose L is irradiance at normal incidence, 12.5 the infinite
lights, 3.8.3 the equal-area octahedron. All directions are in pbrt's own frame.
"""

import re
from pathlib import Path

import numpy as np

import envlights as el

_SOURCE = re.compile(r'LightSource "(\w+)" (.*)')
_PARAMETER = re.compile(r'"(\w+) (\w+)" (?:\[([^]]*)\]|"([^"]*)")')


def light_sources(path):
    """Kind and parameters of each light source: arrays, or text."""
    lines = [line for line in Path(path).read_text().splitlines() if line and line[0] != "#"]
    found = []
    for line in lines:
        kind, rest = _SOURCE.fullmatch(line).groups()
        parameters = {
            name: np.array(numbers.split(), float) if text == "" else text
            for _, name, numbers, text in _PARAMETER.findall(rest)
        }
        found.append((kind, parameters))
    return found


def irradiance(path, normals, height=1024):
    """Irradiance under the light sources of a file, (n, 3)."""
    total = np.zeros((len(normals), 3))
    for kind, given in light_sources(path):
        if kind == "distant":
            towards = (given["from"] - given["to"]) / np.linalg.norm(given["from"] - given["to"])
            total += np.maximum(normals @ towards, 0)[:, None] * given["L"]
        elif "L" in given:
            total += np.pi * given["L"]
        else:
            # Look the map up on a grid of its own, whose pixels have known solid angles.
            directions = el.kernels.pixel_directions(height, 2 * height).reshape(-1, 3)
            seen = radiance(
                el.io.read_image(Path(path).parent / given["filename"]).pixels, directions
            )
            around = el.EnvMap(seen.reshape(height, 2 * height, 3))
            total += around.probe(normals)
    return total


def radiance(square, directions):
    """The pixel of an equal-area map in each direction."""
    assert square.shape[0] == square.shape[1]
    pixels = np.minimum((len(square) * sphere_to_square(directions)).astype(int), len(square) - 1)
    return square[pixels[:, 1], pixels[:, 0]]


def sphere_to_square(directions):
    """Section 3.8.3: points of the unit square, (n, 2), u to the right and v down the rows."""
    x, y, z = np.abs(directions).T
    r = np.sqrt(np.maximum(1 - z, 0))
    v = r * np.arctan2(y, x) * 2 / np.pi
    u = r - v
    below = directions[:, 2] < 0
    u, v = np.where(below, 1 - v, u), np.where(below, 1 - u, v)
    uv = np.copysign(np.stack([u, v], axis=1), directions[:, :2])
    return (uv + 1) / 2
