"""Models of the user's: what is read, what is refused, and the textures of the shader."""

import base64
import json
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import envlights as el
from envlights._common.srgb import decode_srgb
from envlights.viewer import model_file, model_textures
from envlights.viewer.model_file import MOST_TRIANGLES

TRIANGLE = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


def cube(centre=(0, 0, 0), side=1.0):
    """Vertices and triangles of a cube, counterclockwise from outside."""
    corners = np.array([[code >> axis & 1 for axis in range(3)] for code in range(8)]) - 0.5
    faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
    rows = [[face[0], face[k], face[k + 1]] for face in faces for k in (1, 2)]
    return corners * side + centre, np.array(rows)


def gltf(path, **changes):
    """Write one triangle of a colour as glTF; `changes` replace members of the file."""
    positions = base64.b64encode(np.array(TRIANGLE, "<f4").tobytes()).decode()
    content = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "scale": [2, 2, 2]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0.25, 1]}}],
        "buffers": [{"byteLength": 36, "uri": f"data:application/octet-stream;base64,{positions}"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
    }
    path.write_text(json.dumps({**content, **changes}))
    return path


def texels(texture):
    """Texels of a texture as the page gets it, (n, channels)."""
    flat = np.frombuffer(base64.b64decode(texture["texels"]), "<u4")
    return flat.reshape(-1, texture["channels"])


def corners_of(data):
    """Positions in metres, normals and albedos of the corners of each triangle, (m, 3, 3) each."""
    low, high = texels(data["triangles"]).T.astype(np.uint64)
    packed = low | high << np.uint64(32)
    rows = np.stack([packed >> np.uint64(21 * k) & np.uint64(0x1FFFFF) for k in range(3)], axis=1)
    a, b, c, d = texels(data["corners"]).T
    grid = np.stack([a & 0xFFFF, a >> 16, b & 0xFFFF], axis=1)
    square = np.stack([b >> 16, c & 0xFFFF], axis=1) / 32767.5 - 1
    depth = 1 - np.abs(square).sum(axis=1)
    folded = (1 - np.abs(square[:, ::-1])) * np.where(square < 0, -1, 1)
    normals = np.column_stack([np.where(depth[:, None] < 0, folded, square), depth])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    codes = np.stack([c >> 16 & 0xFF, c >> 24, d & 0xFF], axis=1)
    points = grid * data["step"] + data["lower"]
    return points[rows], normals[rows], decode_srgb(codes / 255)[rows]


def test_a_model_stands_on_the_floor_in_metres():
    vertices, triangles = cube(centre=(5, 7, -3), side=200)
    model = el.viewer.Model(vertices, triangles, scale=0.01)
    used = model.vertices[model.triangles.ravel()]
    np.testing.assert_allclose(used.min(axis=0), [-1, 0, -1], atol=1e-12)
    np.testing.assert_allclose(used.max(axis=0), [1, 2, 1], atol=1e-12)
    assert model.notes == ()


def test_the_axis_of_a_file_that_points_up_becomes_y():
    model = el.viewer.Model([[0, 0, 0], [1, 0, 0], [0, 0, 3]], [[0, 1, 2]], up="z")
    np.testing.assert_allclose(model.size, [1, 3, 0])
    turn = np.array([model.vertices[k] - model.vertices[0] for k in (1, 2)])
    np.testing.assert_allclose(turn, [[1, 0, 0], [0, 3, 0]])


@pytest.mark.parametrize(("scale", "size"), [(500, "500"), (0.005, "0.005")])
def test_a_scale_that_is_probably_wrong_gets_a_note(scale, size):
    (note,) = el.viewer.Model(*cube(), scale=scale).notes
    assert note.startswith(f"the model is {size} m large")
    assert "scale=" in note


def test_triangles_without_area_are_left_out():
    model = el.viewer.Model([*TRIANGLE, [2, 0, 0]], [[0, 1, 2], [0, 1, 3], [1, 1, 2]])
    assert len(model.triangles) == 1
    assert model.notes == ("2 triangles without area are left out",)


@pytest.mark.parametrize(
    ("vertices", "triangles", "wanted"),
    [
        ([[0, 0, np.nan], *TRIANGLE[1:]], [[0, 1, 2]], "vertex 0 holds nan"),
        ([[0, 0, np.inf], *TRIANGLE[1:]], [[0, 1, 2]], "vertex 0 holds inf"),
        ([[0, 0, 1e13], *TRIANGLE[1:]], [[0, 1, 2]], "1e12"),
        (TRIANGLE, [[0, 1, 3]], "from 0 to 2; got 3"),
        (TRIANGLE, [[0, 1, -1]], "from 0 to 2; got -1"),
        (TRIANGLE, [[0, 1, 1]], "no triangle with an area"),
        (TRIANGLE, [[0.0, 1.0, 2.0]], "whole numbers"),
        (TRIANGLE, [[0, 1, 2, 0]], "split polygons"),
        (TRIANGLE, np.zeros((0, 3), int), "at least one triangle"),
        (np.zeros((0, 3)), [[0, 1, 2]], "got"),
        (TRIANGLE, np.zeros((MOST_TRIANGLES + 1, 3), int), "simplify"),
    ],
)
def test_what_is_no_model_is_refused(vertices, triangles, wanted):
    with pytest.raises(el.EnvLightsError, match=wanted):
        el.viewer.Model(vertices, triangles)


@pytest.mark.parametrize(
    "albedo", [[2, 0, 0], [np.nan, 0, 0], [0.5, 0.5], np.ones((4, 3)), [[1, 1, 1], [1]]]
)
def test_an_albedo_that_is_none_is_refused(albedo):
    with pytest.raises(el.EnvLightsError, match="albedo"):
        el.viewer.Model(TRIANGLE, [[0, 1, 2]], albedo)


def test_a_cube_keeps_its_edges_and_a_sphere_is_smooth():
    _, normals, _ = corners_of(model_textures.textures(el.viewer.Model(*cube())))
    np.testing.assert_allclose(np.sort(np.abs(normals), axis=-1), [[[0, 0, 1]] * 3] * 12, atol=1e-4)
    faces = el.kernels.icosphere(1280)[0]
    from scipy.spatial import ConvexHull

    hull = ConvexHull(faces)
    points, normals, _ = corners_of(model_textures.textures(el.viewer.Model(faces, hull.simplices)))
    radial = points - [0, np.ptp(faces[:, 1]) / 2, 0]
    radial /= np.linalg.norm(radial, axis=-1, keepdims=True)
    # Loops of the hull have either orientation, so neighbours may disagree on it: signs are free.
    assert np.median(np.abs(np.einsum("ijk,ijk->ij", normals, radial))) > 0.999


@given(st.integers(1, 60), st.integers(0, 2**32 - 1))
def test_textures_hold_the_model(count, seed):
    rng = np.random.default_rng(seed)
    vertices = rng.normal(size=(3 * count, 3))
    albedo = rng.uniform(size=(3 * count, 3))
    model = el.viewer.Model(vertices, np.arange(3 * count).reshape(-1, 3), albedo)
    points, normals, colours = corners_of(model_textures.textures(model))
    wanted = model.vertices[model.triangles]
    order = [np.abs(points - one).max(axis=(1, 2)).argmin() for one in wanted]
    step = model.size.max() / 65535
    assert np.abs(points[order] - wanted).max() <= 0.51 * step
    assert np.abs(colours[order] - model.albedo).max() < 0.006
    np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1)


def test_a_triangle_costs_few_bytes():
    turns, rings = np.meshgrid(np.arange(200), np.arange(100))
    around, along = 2 * np.pi * turns / 200, np.pi * (rings + 1) / 101
    points = np.stack(
        [np.sin(along) * np.cos(around), np.cos(along), np.sin(along) * np.sin(around)]
    )
    cell = (200 * rings + turns)[:-1].ravel()
    right = (200 * rings + (turns + 1) % 200)[:-1].ravel()
    rows = np.concatenate(
        [np.stack([cell, right, cell + 200], 1), np.stack([right, right + 200, cell + 200], 1)]
    )
    data = model_textures.textures(el.viewer.Model(points.reshape(3, -1).T, rows))
    text = sum(len(data[name]["texels"]) for name in ("nodes", "triangles", "corners"))
    assert text / len(rows) < 60


trimesh = pytest.importorskip("trimesh", reason="needs trimesh")


@pytest.mark.parametrize("kind", ["glb", "obj", "ply", "stl", "off"])
def test_files_hold_the_same_cube(tmp_path, kind):
    path = tmp_path / f"cube.{kind}"
    trimesh.Trimesh(*cube(), process=False).export(path)
    model = el.viewer.Model.open(path, scale=2)
    np.testing.assert_allclose(model.size, 2)
    assert len(model.triangles) == 12
    np.testing.assert_allclose(model.albedo, 0.7, atol=0.3)


def test_a_scene_keeps_its_places_and_colours(tmp_path):
    model = el.viewer.Model.open(gltf(tmp_path / "one.gltf"))
    np.testing.assert_allclose(model.size, [2, 2, 0])
    np.testing.assert_allclose(model.albedo[0, 0], [1, 0.5, 0.25], atol=0.003)


def test_textures_and_colours_of_files_become_albedos(tmp_path):
    from PIL import Image

    codes = np.array([[[255, 0, 0], [0, 188, 0]], [[0, 0, 255], [188, 188, 188]]], np.uint8)
    Image.fromarray(codes).save(tmp_path / "codes.png")
    (tmp_path / "one.mtl").write_text("newmtl one\nKd 1 1 1\nmap_Kd codes.png\n")
    corners = "".join(f"vt {u} {v}\n" for u, v in ((0.25, 0.25), (0.75, 0.25), (0.75, 0.75)))
    points = "".join(f"v {x} {y} {z}\n" for x, y, z in TRIANGLE)
    path = tmp_path / "one.obj"
    path.write_text(f"mtllib one.mtl\nusemtl one\n{points}{corners}f 1/1 2/2 3/3\n")
    half = decode_srgb(np.array(188 / 255))
    wanted = [[0, 0, 1], [half, half, half], [0, half, 0]]
    np.testing.assert_allclose(el.viewer.Model.open(path).albedo[0], wanted, atol=1e-6)


HOSTILE = {
    "empty.glb": b"",
    "cut.glb": b"glTF\2\0\0\0" + bytes(8),
    "empty.obj": b"",
    "text.obj": b"v a b c\nf x y z\n",
    "missing.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
    "nan.obj": b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "flat.obj": b"v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n",
    "long.stl": bytes(80) + struct.pack("<I", 2**31) + bytes(50),
    "long.ply": b"ply\nformat ascii 1.0\nelement vertex 3000000000\nproperty float x\nend_header\n",
    "model.zip": b"PK\3\4",
}
CHANGES = {
    "circle": {"nodes": [{"children": [1], "mesh": 0}, {"children": [0], "mesh": 0}]},
    "long": {
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 10**12, "type": "VEC3"}]
    },
    "elsewhere": {"buffers": [{"byteLength": 36, "uri": "../../../etc/passwd"}]},
    "network": {"buffers": [{"byteLength": 36, "uri": "http://127.0.0.1:9/x"}]},
    "chain": {"nodes": [{"children": [k + 1], "mesh": 0} for k in range(3000)] + [{"mesh": 0}]},
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_damaged_file_is_refused_by_name(tmp_path, name):
    (tmp_path / name).write_bytes(HOSTILE[name])
    with pytest.raises(el.EnvLightsError, match=name) as refusal:
        el.viewer.Model.open(tmp_path / name)
    assert not isinstance(refusal.value, FileNotFoundError)


@pytest.mark.parametrize("name", CHANGES)
def test_a_hostile_scene_is_refused(tmp_path, name):
    with pytest.raises(el.EnvLightsError):
        el.viewer.Model.open(gltf(tmp_path / "one.gltf", **CHANGES[name]))


#: An array without data is zeros; many meshes may share one; negative counts are taken away.
ZEROS = {"componentType": 5126, "count": 2 * 10**7, "type": "VEC3"}
CLAIMS = {
    "zeros": {"accessors": [ZEROS]},
    "sum": {"accessors": [{**ZEROS, "count": 10**5}] * 200},
    "negative": {"accessors": [ZEROS, {**ZEROS, "count": -2 * 10**7}]},
    "copies": {
        "accessors": [{**ZEROS, "count": 10**6}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}] * 100,
    },
}


@pytest.mark.parametrize("name", CLAIMS)
@pytest.mark.parametrize("kind", ["gltf", "glb"])
def test_a_file_that_claims_much_more_than_it_holds_is_refused(tmp_path, monkeypatch, name, kind):
    """Before the library reads it; 400 bytes took 2 GB."""
    path = gltf(tmp_path / "one.gltf", **CLAIMS[name])
    if kind == "glb":
        text = path.read_bytes()
        path = tmp_path / "one.glb"
        path.write_bytes(struct.pack("<4sIIII", b"glTF", 2, 20 + len(text), len(text), 0) + text)
    monkeypatch.setattr(trimesh, "load_scene", lambda *_, **__: pytest.fail("it was read"))
    with pytest.raises(el.EnvLightsError, match=r"arrays would need \d+ MB"):
        el.viewer.Model.open(path)


def test_data_beside_a_file_counts(tmp_path):
    vertices, triangles = cube()
    scene = trimesh.Scene([trimesh.Trimesh(vertices, triangles, process=False)] * 2)
    for name, content in trimesh.exchange.gltf.export_gltf(scene).items():
        (tmp_path / name).write_bytes(content)
    assert len(el.viewer.Model.open(tmp_path / "model.gltf").triangles) == 24


def test_a_texture_of_too_many_pixels_is_refused_before_it_is_decoded():
    from PIL import Image

    with pytest.raises(el.EnvLightsError, match="pixels; got 10000 x 10000"):
        model_file._texels(Image.new("1", (10_000, 10_000)), np.zeros((1, 2)))


def test_a_missing_file_is_not_found(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"none\.glb"):
        el.viewer.Model.open(tmp_path / "none.glb")


@pytest.mark.parametrize("source", [3, None, object(), b"x"])
def test_what_is_no_file_is_refused(source):
    with pytest.raises(el.EnvLightsError, match="must be a path"):
        el.viewer.Model.open(source)
