"""Cards in OpenUSD, read back by its own library."""

import numpy as np
import pytest

import envlights as el
from envlights.cards import geometry
from tests.export import cards
from tests.export.rigs import relative

pytest.importorskip("pxr", reason="needs usd-core")

from pxr import Usd, UsdGeom, UsdLux, UsdShade

from tests.export.test_usd import problems


def stage_of(card, folder, environment=None):
    el.export.save(card, folder / "scene.usda", environment)
    stage = Usd.Stage.Open(str(folder / "scene.usda"))
    return stage, {prim.GetTypeName(): prim for prim in stage.Traverse()}


def to_world(prim):
    return UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default())


def colours(picture, places):
    height, width, _ = picture.shape
    return [picture[int(row * height), int(column * width)] for column, row in places]


def test_a_window_is_a_rectangle_light_with_its_texture_the_right_way_round(tmp_path):
    _, prims = stage_of(cards.WINDOW, tmp_path)
    light, place = UsdLux.RectLight(prims["RectLight"]), to_world(prims["RectLight"])
    width, height = light.GetWidthAttr().Get(), light.GetHeightAttr().Get()
    # The schema: the texture begins at (+x, +y) and ends at (-x, -y).
    points = [
        place.Transform(((0.5 - column) * width, (0.5 - row) * height, 0))
        for column, row in cards.QUARTERS
    ]
    seen = geometry.unit(np.array(points))
    np.testing.assert_allclose(seen, cards.directions(cards.WINDOW), atol=1e-6)
    shines = np.array(place.TransformDir((0, 0, -1)))
    assert shines @ cards.WINDOW.direction[0] == pytest.approx(-1, abs=1e-6)
    file = light.GetTextureFileAttr().Get().resolvedPath
    assert file == str(tmp_path / "scene.card_0.usd.exr")
    picture = el.io.read_image(file).pixels * light.GetIntensityAttr().Get()
    np.testing.assert_array_equal(colours(picture, cards.QUARTERS), cards.CORNERS.reshape(-1, 3))
    assert np.linalg.norm(place.ExtractTranslation()) == pytest.approx(1000)


def test_an_oblique_window_is_a_mesh_light(tmp_path):
    stage, prims = stage_of(cards.OBLIQUE, tmp_path)
    mesh = UsdGeom.Mesh(prims["Mesh"])
    points = np.array(mesh.GetPointsAttr().Get())
    st = np.array(UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").Get())
    # Bilinear in a parallelogram: solve for the affine map from st to points.
    affine, *_ = np.linalg.lstsq(np.insert(st, 2, 1, axis=1), points, rcond=None)
    seen = geometry.unit(
        np.array([[column, 1 - row, 1] for column, row in cards.QUARTERS]) @ affine
    )
    np.testing.assert_allclose(seen, cards.directions(cards.OBLIQUE), atol=1e-6)
    normal = np.cross(points[1] - points[0], points[2] - points[0])
    assert normal @ points.mean(axis=0) < 0  # right-handed: its front is towards the origin
    assert prims["Mesh"].HasAPI(UsdLux.MeshLightAPI)
    material, _ = UsdShade.MaterialBindingAPI(mesh).ComputeBoundMaterial()
    source = material.ComputeSurfaceSource()
    shader = source[0] if isinstance(source, tuple) else source
    texture = UsdShade.Shader(shader.GetInput("emissiveColor").GetConnectedSource()[0])
    picture = el.io.read_image(texture.GetInput("file").Get().resolvedPath).pixels
    np.testing.assert_array_equal(colours(picture, cards.QUARTERS), cards.CORNERS.reshape(-1, 3))
    assert stage.GetPrimAtPath("/rig/card_0_surface/st")


def test_a_disc_is_a_disk_light(tmp_path):
    _, prims = stage_of(cards.LAMP.at(7.0), tmp_path)
    light, place = UsdLux.DiskLight(prims["DiskLight"]), to_world(prims["DiskLight"])
    rim = place.Transform((light.GetRadiusAttr().Get(), 0, 0)) - place.ExtractTranslation()
    assert np.linalg.norm(place.ExtractTranslation()) == pytest.approx(7)
    assert rim.GetLength() == pytest.approx(7 * np.tan(np.radians(10)))
    radiance = light.GetIntensityAttr().Get() * np.array(light.GetColorAttr().Get())
    np.testing.assert_allclose(radiance, [3, 2, 1], rtol=2e-3)
    assert np.array(place.TransformDir((0, 0, -1))) @ cards.LAMP.direction[0] < 0


def test_a_mesh_light_shows_the_map_that_it_hides(tmp_path):
    sky = el.EnvMap(np.full((32, 64, 3), [0.2, 0.3, 0.4], np.float32))
    stage_of(cards.OBLIQUE, tmp_path, sky)
    picture = el.io.read_image(tmp_path / "scene.card_0.usd.exr").pixels
    wanted = cards.CORNERS.reshape(-1, 3) + sky.radiance[0, 0]
    np.testing.assert_allclose(colours(picture, cards.QUARTERS), wanted, rtol=1e-6)


def rectangle_of(prim):
    """A rectangle light as a card; by the schema its texture begins at (+x, +y)."""
    light, place = UsdLux.RectLight(prim), np.array(to_world(prim))[:, :3]
    across, down = -light.GetWidthAttr().Get() * place[0], -light.GetHeightAttr().Get() * place[1]
    matrix = np.stack([across, down, place[3] - across / 2 - down / 2], axis=1)
    scale = light.GetIntensityAttr().Get() * np.array(light.GetColorAttr().Get())
    picture = el.io.read_image(light.GetTextureFileAttr().Get().resolvedPath).pixels
    return el.Cards(["rectangle"], [matrix], [[1, 1, 1]], [scale * picture])


def irradiance_of_scene(folder, normals):
    """Irradiance of the lights and the dome of a stage, by points on each light."""
    stage = Usd.Stage.Open(str(folder / "scene.usda"))
    out = np.zeros((len(normals), 3))
    for prim in stage.Traverse():
        kind = prim.GetTypeName()
        if kind == "DomeLight":
            file = UsdLux.DomeLight(prim).GetTextureFileAttr().Get().resolvedPath
            out += el.EnvMap.open(file).probe(normals)
        elif kind == "DiskLight":
            light, place = UsdLux.DiskLight(prim), np.array(to_world(prim))
            x, y = ((np.indices((200, 200)) + 0.5) / 100 - 1).reshape(2, -1)
            x, y = np.array([x, y])[:, x**2 + y**2 <= 1] * light.GetRadiusAttr().Get()
            points = np.stack([x, y, 0 * x, 1 + 0 * x], axis=1) @ place[:, :3]
            area = np.linalg.norm(np.cross(place[0, :3], place[1, :3])) * np.pi / 4 / len(x)
            distance = np.linalg.norm(points, axis=1, keepdims=True)
            facing = points @ place[2, :3] / np.linalg.norm(place[2, :3])
            angle = area * abs(facing)[:, None] / distance**3
            radiance = light.GetIntensityAttr().Get() * np.array(light.GetColorAttr().Get())
            out += np.maximum(normals @ (points / distance).T, 0) @ (angle * radiance)
        elif kind == "RectLight":
            out += cards.irradiance(rectangle_of(prim), normals)
        else:
            assert kind == "Xform"
    return out


def lamp_with_a_bright_middle():
    """A disc of 23 degrees, eight times as bright in its middle as at its rim, before a sky."""
    towards = np.array([0.48, 0.6, 0.64])
    angle = np.arccos(np.clip(el.kernels.pixel_directions(256, 512) @ towards, -1, 1))
    lamp = np.where(angle < 0.4, 8 - 7 * (angle / 0.4) ** 2, 0)
    return el.EnvMap((0.02 + 5 * lamp[..., None] * [1, 0.9, 0.7]).astype(np.float32))


def test_a_warning_states_the_error_of_a_stage_with_cards(tmp_path):
    env, (normals, weights) = lamp_with_a_bright_middle(), el.kernels.icosphere(1280)
    parts = el.split(env, shapes=True)
    assert parts.cards.shape == ("disc",)
    with pytest.warns(UserWarning, match="OpenUSD shows disc cards in one colour") as warned:
        parts.save(tmp_path / "scene.usda")
    shown, truth = irradiance_of_scene(tmp_path, normals), env.probe(normals)
    stated = float(str(warned[0].message).split()[-2]) / 100
    error = np.sqrt(weights @ (shown - truth) ** 2 / (weights @ truth**2)).mean()
    assert stated == pytest.approx(error, rel=0.1)


def test_a_window_lights_as_one_at_infinity(tmp_path):
    stage_of(cards.WINDOW, tmp_path)
    normals = el.kernels.icosphere(320)[0]
    seen = irradiance_of_scene(tmp_path, normals)
    assert relative(seen, cards.irradiance(cards.WINDOW, normals)) < 1e-4


@pytest.mark.parametrize("name", cards.ALL)
def test_usdchecker_has_nothing_to_say(name, tmp_path):
    el.export.save(cards.ALL[name], tmp_path / "scene.usda")
    assert problems(tmp_path / "scene.usda") == []
