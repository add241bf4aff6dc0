"""Light sources of a pbrt-v4 file, read by the definitions in its book (Pharr et al. 2023).

Section 12.2 has the distant light, whose L is irradiance at normal incidence, 12.5 the infinite
lights, 3.8.3 the equal-area octahedron. All directions are in pbrt's own frame.
"""

import os
import re
from pathlib import Path

import numpy as np

import envlights as el

#: Comments, brackets, strings and other words, as the tokenizer of pbrt-v4 cuts them.
_TOKEN = re.compile(
    rb'[ \n\t\r]*(?:(?P<comment>#[^\n\r]*)|(?P<bracket>[][])|"(?P<string>(?:\\[^\n]|[^"\\\n])*)"'
    rb'|(?P<word>[^ \n\t\r"\[\]]+))'
)
#: Its escapes; it ends at any other.
_ESCAPES = dict(zip(b"bfnrt\\'\"", b"\b\f\n\r\t\\'\"", strict=True))


def light_sources(path):
    """Kind and parameters of each light source: arrays, or text."""
    found = []
    name = None
    for kind, token in tokens(Path(path).read_bytes().rstrip()):
        if kind == "comment":
            continue
        if kind == "word" and token == "LightSource":
            found.append(())
        elif kind == "word":
            found[-1][1][name].append(float(token))
        elif kind == "string" and found[-1] == ():
            found[-1] = (token, {})
        elif kind == "string" and name is None:
            name = token.split()[1]
            found[-1][1][name] = []
        elif kind == "string":
            found[-1][1][name], name = token, None
        elif token == "]":
            found[-1][1][name], name = np.array(found[-1][1][name]), None
    return found


def tokens(text):
    """Kind and text of each token."""
    place = 0
    while place < len(text):
        match = _TOKEN.match(text, place)
        assert match, f"no token at {text[place : place + 40]}"
        place = match.end()
        token = match[match.lastgroup]
        if match.lastgroup == "string":
            token = re.sub(rb"\\(.)", lambda escape: bytes([_ESCAPES[escape[1][0]]]), token)
        yield match.lastgroup, os.fsdecode(token)


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


def square_directions(side):
    """Directions of the pixels of an equal-area map, (side * side, 3), by rows (Clarberg 2008)."""
    grid = 2 * (np.arange(side) + 0.5) / side - 1
    u, v = (each.ravel() for each in np.meshgrid(grid, grid))
    inside = 1 - np.abs(u) - np.abs(v)
    r = 1 - np.abs(inside)
    azimuth = ((np.abs(v) - np.abs(u)) / np.maximum(r, np.finfo(float).tiny) + 1) * np.pi / 4
    planar = r * np.sqrt(2 - r**2)
    x, y = np.copysign(planar * np.cos(azimuth), u), np.copysign(planar * np.sin(azimuth), v)
    return np.stack([x, y, np.copysign(1 - r**2, inside)], axis=1)
