"""three.js, checked by its own loader and by the formulas of its shaders."""

import colorsys

import numpy as np
import pytest

import envlights as el
from envlights.export import AXES, three
from tests.export import cards, node
from tests.export.rigs import DISCS, POINTS, relative, relative_error, rigs
from tests.helpers import NORMALS

RIGS = rigs(POINTS)
KINDS = {
    "none": [],
    "constant": ["AmbientLight"],
    "floor": ["HemisphereLight"],
    "harmonics": ["LightProbe"],
}


def irradiance(found, normals):
    """Irradiance as `lights_pars_begin.glsl.js` of three.js adds it up."""
    total = np.zeros((len(normals), 3)) + found["ambient"]
    for direction, colour in found["directional"]:
        total += np.maximum(normals @ direction, 0)[:, None] * colour
    for direction, sky, ground in found["hemisphere"]:
        weight = (0.5 * (normals @ direction) + 0.5)[:, None]
        total += weight * sky + (1 - weight) * ground
    for middle, across, down, colour in found["rectangles"]:
        total += _rectangle(*map(np.array, (middle, across, down, colour)), normals)
    return total + _probe(normals) @ found["probe"]


def _rectangle(middle, across, down, colour, normals):
    """Irradiance of a rectangle of one radiance, from its centre and its half sides."""
    matrix = np.stack([2 * across, 2 * down, middle - across - down], axis=1)
    texture = np.broadcast_to(colour, (8, 8, 3))
    return cards.irradiance(el.Cards(["rectangle"], [matrix], [[1, 1, 1]], [texture]), normals)


def _probe(normals):
    """`shGetIrradianceAt`, with its constants."""
    x, y, z = normals.T
    first = [0.886227 + 0 * x, 1.023328 * y, 1.023328 * z, 1.023328 * x]
    second = [0.858086 * x * y, 0.858086 * y * z, 0.743125 * z * z - 0.247708]
    return np.stack([*first, *second, 0.858086 * x * z, 0.429043 * (x * x - y * y)], axis=1)


def irradiance_of_file(path):
    """Irradiance of the lights that the loader of three.js reads, summed as its shaders do."""
    found = node.report("three_lights.mjs", path)
    return irradiance(found, AXES["three"].to_target(NORMALS))


#: Packages of releases that people have.
RELEASES = [
    pytest.param(name, marks=node.needs(name))
    for name in ("three-150", "three-160", "three-180", "three")
]


@pytest.mark.parametrize("release", RELEASES)
@pytest.mark.parametrize("name", RIGS)
def test_the_irradiance_that_three_js_reads_is_that_of_the_rig(name, release, tmp_path):
    rig = RIGS[name]
    rig.save(tmp_path / "rig.three.json")
    found = node.report("three_lights.mjs", tmp_path / "rig.three.json", release)
    assert found["kinds"] == ["DirectionalLight"] * len(rig.lights) + KINDS[name]
    there = irradiance(found, AXES["three"].to_target(NORMALS))
    assert relative_error(there, rig) < 1e-6


@node.needs("three")
def test_a_window_lights_as_one_at_infinity(tmp_path):
    """In one colour: the lights of three.js have no textures."""
    window = cards.WINDOW
    with pytest.warns(UserWarning, match="in one colour"):
        el.export.save(window, tmp_path / "a.three.json")
    there = irradiance_of_file(tmp_path / "a.three.json")
    matrix, texture = window.matrix[0], window.texture(0)
    even = cards.card("rectangle", matrix, np.broadcast_to(texture.mean((0, 1)), (8, 8, 3)))
    assert relative(there, cards.irradiance(even, NORMALS)) < 0.01
    assert relative(there, window.probe(NORMALS, uniform=["rectangle"])) < 0.01


@node.needs("three")
def test_a_map_lies_where_the_lights_are(tmp_path):
    """Each texel of the map, at the direction at which three.js looks it up, beside the lights."""
    env = el.Lights(POINTS.direction, POINTS.irradiance, [0.2] * 5).to_map(16)
    POINTS.save(tmp_path / "rig.three.json", environment=env)
    found = node.report("three_lights.mjs", tmp_path / "rig.three.json")
    texture = found["map"]
    assert (texture["mapping"], texture["flipY"], found["isBackground"]) == (303, True, True)
    assert found["turns"] == [[0, 0, 0], [0, 0, 0]]
    data = np.reshape(texture["data"], (texture["height"], texture["width"], 4))
    np.testing.assert_allclose(data[..., :3], env.radiance, rtol=1e-6)
    # `equirectUv` of three.js: v grows upwards, and a flipped image has its first row on top.
    directions = el.kernels.pixel_directions(16, 32).reshape(-1, 3)
    x, y, z = AXES["three"].to_target(directions).T
    u, v = (np.arctan2(z, x) / (2 * np.pi) + 0.5) % 1, np.arcsin(y) / np.pi + 0.5
    looked_up = data[(16 * (1 - v)).astype(int), (32 * u).astype(int), :3]
    np.testing.assert_allclose(looked_up, env.radiance.reshape(-1, 3), rtol=1e-6)


@pytest.mark.parametrize("name", ["none", "constant"])
def test_the_colours_of_a_file_have_the_irradiance_of_the_rig(name):
    """Read without three.js: hue, saturation and lightness of sRGB codes, times intensity."""
    children = three(RIGS[name])["object"]["children"]
    lit = np.array([_colour(child["color"]) * child["intensity"] for child in children])
    lights = len(RIGS[name].lights)
    np.testing.assert_allclose(lit[:lights], RIGS[name].lights.irradiance, rtol=1e-6)
    np.testing.assert_allclose(lit[lights:].sum(axis=0), np.pi * RIGS[name].ambient, atol=1e-6)


def _colour(text):
    """Linear RGB of ``hsl(...)``."""
    hue, saturation, lightness = (float(part.strip("%")) for part in text[4:-1].split(","))
    codes = np.array(colorsys.hls_to_rgb(hue / 360, lightness / 100, saturation / 100))
    return np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)


def test_sizes_stand_in_the_user_data():
    children = three(DISCS)["object"]["children"]
    radii = [child["userData"]["angular_radius"] for child in children]
    assert radii == DISCS.angular_radius.tolist()


def test_colours_have_no_exponent_and_no_more_than_all_digits():
    """The pattern by which three.js reads a colour knows no exponents."""
    dim = el.Lights([[0, 1, 0]], [[1, 1e-9, 1e-30]])
    colour = three(dim)["object"]["children"][0]["color"]
    assert "e" not in colour
    assert three(el.Lights([[0, 1, 0]], [[0, 0, 0]]))["object"]["children"][0]["intensity"] == 0


def test_by_the_formula_of_three_js_a_light_is_where_the_map_shows_it():
    """`equirectUv` of three.js, by which a background without rotation is looked up."""
    lights = three(POINTS)["object"]["children"]
    places = np.array([light["matrix"][12:15] for light in lights if "matrix" in light])
    x, y, z = (places / np.linalg.norm(places, axis=1, keepdims=True)).T
    u, v = (np.arctan2(z, x) / (2 * np.pi) + 0.5) % 1, np.arcsin(y) / np.pi + 0.5
    expected = el.kernels.direction_to_uv(POINTS.direction)
    np.testing.assert_allclose(np.stack([u, 1 - v], axis=1), expected, atol=1e-12)
