"""Cards in glTF and three.js, read by their specifications and by the loaders of three.js."""

import base64
import io
import json

import numpy as np
import pytest
from PIL import Image

import envlights as el
from envlights._common.srgb import decode_srgb
from envlights.export import AXES
from tests.export import cards, node
from tests.export.rigs import POINTS

QUARTERS = cards.CORNERS.reshape(-1, 3)


def bytes_of(uri):
    return base64.b64decode(uri.split(",", 1)[1])


def at(points, places, triangles, directions):
    """Texture coordinates where rays from the origin meet triangles from their front."""
    found = []
    for towards in directions:
        for triangle in triangles:
            corners = points[triangle]
            weights = np.linalg.solve(corners.T, towards)
            if (weights >= -1e-9).all():
                normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
                assert normal @ towards < 0
                found.append(weights @ places[triangle] / weights.sum())
                break
    return np.array(found)


def gltf_mesh(asset, mesh=0):
    """Points, texture coordinates, triangles and texture of a mesh."""
    data = bytes_of(asset["buffers"][0]["uri"])

    def array(index, kind):
        accessor = asset["accessors"][index]
        view = asset["bufferViews"][accessor["bufferView"]]
        part = data[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
        return np.frombuffer(part, kind).reshape(accessor["count"], -1)

    (primitive,) = asset["meshes"][mesh]["primitives"]
    points = array(primitive["attributes"]["POSITION"], "<f4").astype(float)
    places = array(primitive["attributes"]["TEXCOORD_0"], "<f4").astype(float)
    triangles = array(primitive["indices"], "<u2").reshape(-1, 3)
    codes = np.asarray(Image.open(io.BytesIO(bytes_of(asset["images"][mesh]["uri"]))))
    strength = asset["materials"][mesh]["extensions"]["KHR_materials_emissive_strength"]
    return points, places, triangles, decode_srgb(codes / 255) * strength["emissiveStrength"]


#: Lists that the indices of the glTF specification point into.
INDICES = {"scene": "scenes", "mesh": "meshes", "material": "materials", "buffer": "buffers",
           "bufferView": "bufferViews", "sampler": "samplers", "source": "images"}  # fmt: skip


def indices_of(part):
    """Pairs of a list and an index into it, in all parts of an asset."""
    for key, value in part.items() if isinstance(part, dict) else enumerate(part):
        if key in INDICES:
            yield INDICES[key], value
        elif isinstance(value, dict | list):
            yield from indices_of(value)


def test_each_index_of_gltf_points_at_an_entry():
    asset = el.export.gltf(cards.ALL["window"])
    found = list(indices_of(asset))
    assert {key for key, _ in found} == set(INDICES.values())
    assert all(0 <= index < len(asset[key]) for key, index in found)
    assert el.export.gltf(POINTS)["scene"] == 0


def test_buffers_and_samplers_of_gltf_have_the_constants_of_the_specification():
    asset = el.export.gltf(cards.ALL["window"])
    (primitive,) = asset["meshes"][0]["primitives"]

    def target(accessor):
        return asset["bufferViews"][asset["accessors"][accessor]["bufferView"]]["target"]

    assert {target(index) for index in primitive["attributes"].values()} == {34962}
    assert target(primitive["indices"]) == 34963
    assert asset["samplers"] == [{"wrapS": 33071, "wrapT": 33071}]


def test_textures_of_three_js_are_clamped_at_their_edges():
    (texture,) = el.export.three(cards.ALL["window"])["textures"]
    assert (texture["mapping"], texture["wrap"]) == (300, [1001, 1001])


@pytest.mark.parametrize("name", ["window", "oblique"])
def test_each_corner_of_a_gltf_plane_has_its_colour(name):
    card = cards.ALL[name]
    points, places, triangles, picture = gltf_mesh(el.export.gltf(card))
    uv = at(points, places, triangles, AXES["gltf"].to_target(cards.directions(card)))
    rows, columns = (uv[:, ::-1] * picture.shape[:2]).astype(int).T  # (0, 0) is the upper left
    np.testing.assert_allclose(picture[rows, columns], QUARTERS, atol=0.03)


def test_a_gltf_disc_has_the_angle_of_the_lamp():
    points, *_ = gltf_mesh(el.export.gltf(cards.LAMP))
    cosine = points @ cards.LAMP.direction[0] / np.linalg.norm(points, axis=1)
    np.testing.assert_allclose(np.degrees(np.arccos(cosine)), 10, atol=1e-3)


@node.needs("gltf-validator")
@pytest.mark.parametrize("name", cards.ALL)
def test_the_khronos_validator_has_nothing_to_say(name, tmp_path):
    el.export.save(cards.ALL[name], tmp_path / "scene.gltf")
    report = node.report("validate_gltf.mjs", tmp_path / "scene.gltf")
    assert report["issues"]["messages"] == []


@pytest.mark.parametrize("name", ["window", "oblique"])
def test_each_corner_of_a_plane_of_three_js_has_its_colour(name):
    card = cards.ALL[name]
    scene = el.export.three(card)
    attributes = scene["geometries"][0]["data"]["attributes"]
    points, uv = (
        np.reshape(attributes[key]["array"], (-1, attributes[key]["itemSize"]))
        for key in ("position", "uv")
    )
    triangles = np.reshape(scene["geometries"][0]["data"]["index"]["array"], (-1, 3))
    content = scene["images"][0]["url"]
    picture = np.reshape(content["data"], (content["height"], content["width"], 4))[..., :3]
    seen = at(points, uv, triangles, AXES["three"].to_target(cards.directions(card)))
    rows = ((1 - seen[:, 1]) * len(picture)).astype(int)  # flipY: the first row is on top
    columns = (seen[:, 0] * picture.shape[1]).astype(int)
    np.testing.assert_allclose(picture[rows, columns], QUARTERS, rtol=1e-6)


@pytest.mark.parametrize("name", cards.ALL)
def test_an_area_light_of_three_js_has_area_and_radiance_of_the_card(name):
    card = cards.ALL[name].at(5.0)
    (light,) = (
        each
        for each in el.export.three(card)["object"]["children"]
        if each["type"] == "RectAreaLight"
    )
    matrix = np.reshape(light["matrix"], (4, 4)).T
    assert np.linalg.det(matrix) == pytest.approx(1)
    towards = AXES["three"].to_target(card.direction)[0]
    np.testing.assert_allclose(matrix[:3, 3], 5 * towards, atol=1e-9)
    facing = AXES["three"].to_target(card.normal)[0]
    np.testing.assert_allclose(-matrix[:3, 2], facing, atol=1e-9)  # shines along -z
    u, v, _ = card.matrix[0].T
    area = np.linalg.norm(np.cross(u, v)) * (np.pi / 4 if name == "lamp" else 1)
    assert light["width"] * light["height"] == pytest.approx(area)
    assert light["intensity"] == pytest.approx(card.radiance.max())


@node.needs("three")
@pytest.mark.filterwarnings("ignore:.* in one colour")
@pytest.mark.parametrize("name", cards.ALL)
def test_three_js_reads_light_and_plane(name, tmp_path):
    el.export.save(cards.ALL[name], tmp_path / "scene.three.json")
    found = node.report("three_cards.mjs", tmp_path / "scene.three.json")
    written = json.loads((tmp_path / "scene.three.json").read_text())
    assert found["lights"][0]["type"] == "RectAreaLight"
    (light, _) = written["object"]["children"]
    assert found["lights"][0]["width"] == pytest.approx(light["width"])
    radiance = np.array(found["lights"][0]["color"]) * found["lights"][0]["intensity"]
    np.testing.assert_allclose(radiance, cards.ALL[name].radiance[0], rtol=1e-5)
    assert found["planes"][0]["texture"] == [
        written["images"][0]["url"]["width"],
        written["images"][0]["url"]["height"],
    ]
