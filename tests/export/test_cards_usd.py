"""Cards in OpenUSD, read back by its own library."""

import numpy as np
import pytest

import envlights as el
from envlights.cards import geometry
from tests.export import cards

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


@pytest.mark.parametrize("name", cards.ALL)
def test_usdchecker_has_nothing_to_say(name, tmp_path):
    el.export.save(cards.ALL[name], tmp_path / "scene.usda")
    assert problems(tmp_path / "scene.usda") == []
