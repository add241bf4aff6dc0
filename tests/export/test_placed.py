"""Lights in metres: the irradiance of each program's file at points of a room.

Each file is read by the program itself, or by the formulas of its specification, and compared with
the room in closed form at the point whose remainder surrounds the lights. The map in a file has
finer walls than the 512 patches of `PlacedLights.irradiance`, and is nearer to the truth.
"""

import json
import re
from functools import cache

import numpy as np
import pytest

import envlights as el
from envlights.export import AXES
from envlights.frames import FRAMES
from tests.export import node
from tests.export.rigs import relative
from tests.export.test_blender import needs_bpy, run_blender
from tests.export.test_cards_gltf import gltf_mesh
from tests.helpers import NORMALS
from tests.placing.rooms import OFFSETS, room, seen
from tests.reference import pbrt

#: Points 0.5 and 2 m from the camera.
POINTS = {"0.5 m": OFFSETS[0], "2 m": OFFSETS[4]}
_SUN_CARD = np.array([[0, 0, 0.02], [0, -0.02, 0], [0.6, 0.81, -0.01]]).T
SUN = el.placing.PlacedLight(
    *("sun", True, _SUN_CARD, np.array([3.0, 2.0, 1.0]), 0.01, np.ones((1, 1, 3), np.float32))
)
#: Spheres in each room.
SPHERES = {"sunny": 2, "downlights": 1, "pendants": 4}
#: Largest error: lamps and map have 0.1 to 0.6 %, and the noise of renderers adds up to 0.5 %.
LIMIT = 0.01
#: The same where balls are points: one of 0.11 m, 0.63 m away, has 1.02 % as a point.
LIMIT_OF_POINTS = 0.013


@cache
def placed_in(kind):
    """Lights of a generated room; "sunny" has a sun in the room of panels."""
    if kind != "sunny":
        return el.place(*seen(kind))
    inside = placed_in("panel")
    parts = inside.remainder, inside.patches, inside.depth
    return el.placing.PlacedLights((*inside.lights, SUN), *parts)


def save_room(folder, suffix, kind, point, **options):
    """File of the lights of a room, and the true irradiance at the point at `NORMALS`."""
    placed_in(kind).save(folder / f"room{suffix}", at=point, **options)
    truth = room("panel" if kind == "sunny" else kind).probe(point, NORMALS)
    if kind == "sunny":
        truth += of_sun(SUN.direction, SUN.irradiance, NORMALS, SUN.angular_radius)
    return folder / f"room{suffix}", truth


# Formulas of radiometry in the frame of a file


def of_plane(matrix, radiance, point, normals, *, is_disc=False, around=None):
    """Irradiance of the parallelogram O + a U + b V, which shines along V x U.

    `radiance` is a texture with row 0 at b = 0. `around` is the map that an opaque plane hides.
    """
    b, a = ((np.indices((128, 128)) + 0.5) / 128).reshape(2, -1)
    inside = (2 * a - 1) ** 2 + (2 * b - 1) ** 2 <= 1 if is_disc else np.ones(len(a), bool)
    a, b = a[inside], b[inside]
    across = np.cross(matrix[:, 1], matrix[:, 0]) / 128**2
    to = np.stack([a, b, np.ones_like(a)], axis=1) @ matrix.T - point
    square = (to**2).sum(axis=1)
    texture = np.broadcast_to(radiance, (*np.shape(radiance)[:-1], 3)).reshape(
        (1, 1, 3) if np.ndim(radiance) == 1 else np.shape(radiance)
    )
    rows, columns, _ = texture.shape
    light = texture[(b * rows).astype(int), (a * columns).astype(int)]
    if around is not None:
        light = light - around(to / np.sqrt(square)[:, None])
    angle = np.maximum(-(to @ across), 0) / square**2
    return np.maximum(normals @ to.T, 0) @ (angle[:, None] * light)


def of_sphere(centre, radius, radiance, point, normals):
    """Irradiance of a sphere of one radiance, as of the disc that it is from a point."""
    to = np.subtract(centre, point)
    distance = np.linalg.norm(to)
    shine = np.pi * np.asarray(radiance) * (radius / distance) ** 2
    light = [to / distance], [shine], [np.arcsin(radius / distance)]
    return el.kernels.rig_irradiance(normals, np.zeros(3), *light)


def of_point(centre, intensity, point, normals):
    """Irradiance of a point light."""
    to = np.subtract(centre, point)
    cosine = np.maximum(normals @ to, 0) / np.linalg.norm(to)
    return cosine[:, None] * np.asarray(intensity) / (to @ to)


def of_sun(towards, irradiance, normals, radius=0.0):
    """Irradiance of a directional light."""
    light = np.reshape(towards, (1, 3)), np.reshape(irradiance, (1, 3)), [radius]
    return el.kernels.rig_irradiance(normals, np.zeros(3), *light)


def in_map(env):
    """Pixels of a map in directions of our frame."""

    def look_up(towards):
        u, v = el.kernels.direction_to_uv(towards).T
        rows = np.minimum((v * env.height).astype(int), env.height - 1)
        return np.asarray(env.radiance)[rows, (u * env.width).astype(int) % env.width]

    return look_up


# Programs


@pytest.mark.mitsuba
@pytest.mark.parametrize("where", POINTS)
@pytest.mark.parametrize("kind", ["sunny", "downlights", "pendants", "hole", "furnished"])
def test_mitsuba_renders_the_irradiance_of_a_point(kind, where, tmp_path):
    pytest.importorskip("mitsuba")
    from envlights.scene.mitsuba.renderer import mitsuba
    from tests.export.test_cards_mitsuba import irradiance_in, load

    point = POINTS[where]
    path, wanted = save_room(tmp_path, ".xml", kind, point)
    with mitsuba() as mi:
        scene = load(path, mi)
        # The sun is in the map.
        assert len(scene.shapes()) == len([each for each in placed_in(kind) if each is not SUN])
        received = irradiance_in(scene, mi, point=point)
    # With 65536 directions the noise is 0.1 %.
    assert relative(received, wanted) < LIMIT


def of_usd(path, point, normals, metres=1.0):
    """Irradiance of the lights and the dome of a stage, by the definitions of UsdLux."""
    from pxr import Usd, UsdGeom, UsdLux

    stage, total, kinds = Usd.Stage.Open(str(path)), np.zeros((len(normals), 3)), []
    for prim in stage.Traverse():
        kind, light = prim.GetTypeName(), UsdLux.LightAPI(prim)
        place = UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default())
        place, kinds = np.array(place), [*kinds, kind]
        if kind == "Xform":
            continue
        x, y, z, centre = place[0, :3], place[1, :3], place[2, :3], place[3, :3] * metres
        colour = light.GetColorAttr().Get()
        strength = light.GetIntensityAttr().Get() * np.array(colour or (1, 1, 1))
        if kind == "RectLight":
            rectangle = UsdLux.RectLight(prim)
            picture = el.io.read_image(rectangle.GetTextureFileAttr().Get().resolvedPath).pixels
            u = -x * rectangle.GetWidthAttr().Get() * metres
            v = -y * rectangle.GetHeightAttr().Get() * metres
            matrix = np.stack([u, v, centre - (u + v) / 2], axis=1)
            total += of_plane(matrix, picture * strength, point, normals)
        elif kind == "DiskLight":
            u, v = (-2 * axis * UsdLux.DiskLight(prim).GetRadiusAttr().Get() for axis in (x, y))
            matrix = np.stack([u, v, centre / metres - (u + v) / 2], axis=1) * metres
            total += of_plane(matrix, strength, point, normals, is_disc=True)
        elif kind == "SphereLight":
            assert not light.GetNormalizeAttr().Get()
            radius = UsdLux.SphereLight(prim).GetRadiusAttr().Get() * metres
            total += of_sphere(centre, radius, strength, point, normals)
        elif kind == "DistantLight":
            assert light.GetNormalizeAttr().Get()
            angle = UsdLux.DistantLight(prim).GetAngleAttr().Get()
            total += of_sun(z, strength, normals, np.radians(angle / 2))
        else:
            assert kind == "DomeLight"
            file = UsdLux.DomeLight(prim).GetTextureFileAttr().Get().resolvedPath
            # The dome's own +y is turned to the up axis.
            total += el.EnvMap.open(file).probe(normals @ place[:3, :3].T)
    return total, kinds


@pytest.mark.parametrize("stage", [{}, {"up": "z", "metres_per_unit": 0.01}], ids=["y", "z cm"])
@pytest.mark.parametrize("point", POINTS.values(), ids=POINTS)
@pytest.mark.parametrize("kind", ["sunny", "downlights"])
def test_openusd_reads_the_irradiance_of_a_point(kind, point, stage, tmp_path):
    pytest.importorskip("pxr", reason="needs usd-core")
    path, wanted = save_room(tmp_path, ".usda", kind, point, **stage)
    axes = FRAMES["usd-z" if stage else "usd"]
    there = axes.to_target(point), axes.to_target(NORMALS), stage.get("metres_per_unit", 1.0)
    received, kinds = of_usd(path, *there)
    assert relative(received, wanted) < LIMIT
    from tests.export.test_usd import problems

    assert problems(path) == []
    lights = {"sunny": (2, 0, 2, 1), "downlights": (0, 6, 1, 0)}[kind]
    names = ("RectLight", "DiskLight", "SphereLight", "DistantLight")
    assert tuple(map(kinds.count, names)) == lights


@needs_bpy
@pytest.mark.parametrize("kind", ["sunny", "downlights"])
def test_cycles_renders_the_irradiance_of_a_point(kind, tmp_path):
    for name, point in POINTS.items():
        path, wanted = save_room(tmp_path, ".py", kind, point)
        np.save(tmp_path / "rows.npy", AXES["blender"].to_target([point, *NORMALS]))
        run_blender("near", tmp_path / "rows.npy", path)
        assert relative(np.load(path.with_suffix(".npy")), wanted) < LIMIT, name


@pytest.mark.parametrize("point", POINTS.values(), ids=POINTS)
@pytest.mark.parametrize("kind", ["sunny", "downlights", "pendants"])
def test_gltf_has_the_irradiance_of_a_point(kind, point, tmp_path):
    path, wanted = save_room(tmp_path, ".gltf", kind, point)
    if node.has("gltf-validator"):
        assert node.report("validate_gltf.mjs", path)["issues"]["numErrors"] == 0
    asset = json.loads(path.read_text())
    lights = asset["extensions"]["KHR_lights_punctual"]["lights"]
    env = el.EnvMap.open(tmp_path / asset["scenes"][0]["extras"]["environment"])
    received = env.probe(NORMALS)
    for row in asset["scenes"][0]["nodes"]:
        thing = asset["nodes"][row]
        if "mesh" in thing:
            points, _, triangles, picture = gltf_mesh(asset, thing["mesh"])
            is_disc = len(triangles) > 2
            if is_disc:  # the ellipse that touches the middles of the sides
                u, v = points[0] - points[32], points[48] - points[16]
                matrix = np.stack([u, v, points.mean(axis=0) - (u + v) / 2], axis=1)
            else:
                matrix = np.stack([points[3] - points[0], points[1] - points[0], points[0]], axis=1)
            options = {"is_disc": is_disc, "around": in_map(env)}
            received += of_plane(matrix, picture, point, NORMALS, **options)
            continue
        light = lights[thing["extensions"]["KHR_lights_punctual"]["light"]]
        strength = light["intensity"] * np.array(light["color"])
        if light["type"] == "point":
            received += of_point(thing["translation"], strength, point, NORMALS)
        else:
            *axis, w = thing["rotation"]
            shines = -np.array([0, 0, 1]) + 2 * np.cross(axis, np.cross(axis, [0, 0, -1]))
            shines += 2 * w * np.cross(axis, [0, 0, -1])
            received += of_sun(-shines, strength, NORMALS)
    assert relative(received, wanted) < LIMIT_OF_POINTS
    kinds = [light["type"] for light in lights]
    assert kinds == ["directional"] * (kind == "sunny") + ["point"] * SPHERES[kind]


@pytest.mark.filterwarnings("ignore:.* in one colour")
@pytest.mark.parametrize("point", POINTS.values(), ids=POINTS)
@pytest.mark.parametrize("kind", ["sunny", "downlights", "pendants"])
@node.needs("three")
def test_three_js_reads_the_irradiance_of_a_point(kind, point, tmp_path):
    path, wanted = save_room(tmp_path, ".three.json", kind, point)
    found = node.report("three_lights.mjs", path)
    there, normals = AXES["three"].to_target(point), AXES["three"].to_target(NORMALS)
    texels = np.reshape(found["map"]["data"], (found["map"]["height"], -1, 4))[..., :3]
    received = el.EnvMap(texels.astype(np.float32)).probe(NORMALS)
    for towards, colour in found["directional"]:
        received += of_sun(towards, colour, normals)
    for centre, colour, distance, decay in found["points"]:
        assert (distance, decay) == (0, 2)  # without a cut-off
        received += of_point(centre, colour, there, normals)
    for centre, colour, half_width, half_height in found["areas"]:
        u, v = 2 * np.array(half_width), 2 * np.array(half_height)
        # The light shines along its local -z = -(x cross y).
        matrix = np.stack([-u, -v, np.array(centre) + (u + v) / 2], axis=1)
        received += of_plane(matrix, np.array(colour), there, normals)
    assert relative(received, wanted) < LIMIT_OF_POINTS


@pytest.mark.parametrize("point", POINTS.values(), ids=POINTS)
@pytest.mark.parametrize("kind", ["sunny", "downlights"])
def test_pbrt_has_the_irradiance_of_a_point(kind, point, tmp_path):
    path, wanted = save_room(tmp_path, ".pbrt", kind, point)
    axes = AXES["pbrt"]
    there, normals = axes.to_target(point), axes.to_target(NORMALS)
    text = path.read_text()
    pieces = re.split(r"AttributeBegin|AttributeEnd", text)
    path.write_text("".join(pieces[::2]))
    received = pbrt.irradiance(path, normals)
    (sky,) = (each["filename"] for name, each in pbrt.light_sources(path) if name == "infinite")
    square = el.io.read_image(tmp_path / sky).pixels

    def around(towards):
        return pbrt.radiance(square, towards)

    def numbers(name, piece):
        return np.array(re.search(rf"{name} \[([^\]]*)\]", piece).group(1).split(), float)

    for piece in pieces[1::2]:
        if '"sphere"' in piece:
            centre = np.array(re.search(r"Translate (\S+ \S+ \S+) ", piece).group(1).split(), float)
            radius = float(re.search(r'"float radius" (\S+)', piece).group(1))
            behind = around((centre - there)[None] / np.linalg.norm(centre - there))[0]
            light = numbers('"rgb L"', piece) - behind
            received += of_sphere(centre, radius, light, there, normals)
        elif '"disk"' in piece:
            x, y, z, centre = numbers("ConcatTransform", piece).reshape(4, 4)[:, :3]
            radius = float(re.search(r'"float radius" (\S+)', piece).group(1))
            assert np.cross(x, y) @ z > 0  # it shines along +z
            matrix = np.stack([2 * radius * y, 2 * radius * x, centre - radius * (x + y)], axis=1)
            light = numbers('"rgb L"', piece)
            received += of_plane(matrix, light, there, normals, is_disc=True, around=around)
        elif '"point2 uv"' not in piece:  # a fan of triangles is an ellipse
            points = numbers('"point3 P"', piece).reshape(-1, 3)
            centre = points.mean(axis=0)
            x, y = points[0] - centre, points[len(points) // 4] - centre
            assert np.cross(x, y) @ (there - centre) > 0
            matrix = np.stack([2 * y, 2 * x, centre - x - y], axis=1)
            light = numbers('"rgb L"', piece)
            received += of_plane(matrix, light, there, normals, is_disc=True, around=around)
        else:
            points = numbers('"point3 P"', piece).reshape(4, 3)
            uv = numbers('"point2 uv"', piece).reshape(4, 2)
            o, u, v = (points[(uv == corner).all(axis=1)][0] for corner in ([0, 1], [1, 1], [0, 0]))
            across = np.cross(points[1] - points[0], points[2] - points[0])
            matrix = np.stack([u - o, v - o, o], axis=1)
            name = re.search(r'"string filename" "([^"]*)"', piece).group(1)
            picture = el.io.read_image(tmp_path / name).pixels
            if np.cross(matrix[:, 1], matrix[:, 0]) @ across < 0:  # seen from the other side
                matrix = np.stack([matrix[:, 1], matrix[:, 0], o], axis=1)
                picture = picture.swapaxes(0, 1)
            received += of_plane(matrix, picture, there, normals, around=around)
    assert relative(received, wanted) < LIMIT
    assert text.count('"sphere"') == SPHERES[kind]


# Units, refusals, files


def test_a_calibrated_room_is_in_candela():
    radiance, depth = seen("pendants")
    env = el.EnvMap(radiance).calibrated(lux=300)
    placed = el.place(env, depth)
    asset = el.export.gltf(placed.cards)
    light = asset["extensions"]["KHR_lights_punctual"]["lights"][0]
    candela = light["intensity"] * np.array(light["color"])
    np.testing.assert_allclose(candela, placed[0].intensity, rtol=1e-9)
    script = el.export.blender(placed.cards)
    rows = script.split("SPHERES = [\n")[1].splitlines()[0]
    _, _, radius, watts = eval(rows.strip().rstrip(","))
    assert radius == pytest.approx(placed[0].radius, rel=1e-9)
    np.testing.assert_allclose(683 * np.array(watts), placed[0].intensity, rtol=1e-9)


@pytest.mark.parametrize("name", ["room.unity.json", "room.json", "room.csv", "room.rad"])
def test_a_program_without_positions_is_refused_with_the_way_out(name, tmp_path):
    with pytest.raises(el.EnvLightsError, match=r"shows no lights with positions.*placed\.at"):
        placed_in("pendants").save(tmp_path / "rest.exr", tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_wrong_arguments_are_refused(tmp_path):
    placed = placed_in("pendants")
    with pytest.raises(el.EnvLightsError, match="no path"):
        placed.save()
    with pytest.raises(el.EnvLightsError, match="at must be three finite numbers"):
        placed.save(tmp_path / "room.usda", at=[1, 2])
    with pytest.raises(el.EnvLightsError, match="distance= changes nothing"):
        placed.save(tmp_path / "room.usda", distance=3)
    assert not list(tmp_path.iterdir())


def test_a_file_states_the_origin_and_the_point_of_its_map(tmp_path):
    names = [tmp_path / name for name in ("rest.exr", "room.usda", "room.xml")]
    placed = placed_in("pendants")
    written = placed.save(*names, at=OFFSETS[0])
    assert set(written) == set(tmp_path.iterdir())
    words = "positions are in metres from the camera, and the map is that of (0.5 0 0)"
    assert all(words in path.read_text() for path in names[1:])
    # The remainder moved: that of the camera is another map.
    rest = el.EnvMap.open(names[0]).probe(NORMALS)
    home = placed.remainder.probe(NORMALS)
    assert 0.01 < relative(rest, home) < 0.2


def test_the_map_of_the_camera_closes_there(tmp_path):
    """Without `at`, the remainder is that of the camera itself."""
    placed = placed_in("pendants")
    placed.save(tmp_path / "rest.exr")
    np.testing.assert_array_equal(
        el.EnvMap.open(tmp_path / "rest.exr").radiance, placed.remainder.radiance
    )
