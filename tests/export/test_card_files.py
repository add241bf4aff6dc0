"""Files of a split of cards: scenes, textures and the remainder."""

import numpy as np
import pytest

import envlights as el
from tests.export import cards

REST = el.EnvMap(np.full((16, 32, 3), 0.1, np.float32))
ALL = el.Cards(
    ["rectangle", "disc", "other"],
    [cards.WINDOW.matrix[0], cards.LAMP.matrix[0], cards.facing(0, 0, 5, 5)],
    [[3, 2, 1], [2, 1, 1], [1, 1, 1]],
    [cards.WINDOW.texture(0), cards.LAMP.texture(0), np.ones((2, 2, 3))],
)
PARTS = el.cards.CardSplit(ALL, REST)


@pytest.mark.filterwarnings("ignore:.* shows (lights|.* cards)")
def test_all_files_are_named_and_written(tmp_path):
    names = ["rest.exr", "a.usda", "b.py", "c.xml", "d.pbrt", "e.gltf", "f.three.json", "g.csv"]
    written = PARTS.save(*(tmp_path / name for name in names))
    assert {path.name for path in written} == {path.name for path in tmp_path.iterdir()}
    textures = {path.name for path in written} - set(names)
    assert textures == {
        "a.card_0.usd.exr",
        "b.card_0.blender.exr",
        "b.card_1.blender.exr",
        "c.ambient.mitsuba.exr",
        "c.card_0.mitsuba.exr",
        "d.ambient.pbrt.exr",
        "d.card_0.pbrt.exr",
    }
    assert "rest.exr" in (tmp_path / "a.usda").read_text()


@pytest.mark.filterwarnings("ignore:.* shows (lights|.* cards)")
def test_files_have_the_same_bytes_every_time(tmp_path):
    names = ["a.usda", "b.py", "c.xml", "d.pbrt", "e.gltf", "f.three.json"]
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        PARTS.save(*(tmp_path / folder / name for name in names))
    for path in (tmp_path / "one").iterdir():
        assert path.read_bytes() == (tmp_path / "two" / path.name).read_bytes(), path.name


def test_a_texture_in_the_way_is_refused_before_the_first_file(tmp_path):
    (tmp_path / "a.card_0.usd.exr").mkdir()
    with pytest.raises(el.EnvLightsError, match="it is a folder"):
        PARTS.save(tmp_path / "rest.exr", tmp_path / "a.usda")
    assert [path.name for path in tmp_path.iterdir()] == ["a.card_0.usd.exr"]


def test_a_light_without_an_outline_stays_a_disc_at_infinity():
    text = el.export.usd(ALL)
    assert [text.count(f"def {kind}") for kind in ("RectLight", "DiskLight", "DistantLight")] == [
        1,
        1,
        1,
    ]


def test_a_target_without_cards_shows_discs():
    assert el.export.csv(ALL).count("\n") == el.export.csv(ALL.lights).count("\n")
    assert el.export.radiance(ALL) == el.export.radiance(ALL.lights)


def test_json_holds_the_lights_of_cards_alone(tmp_path):
    noted = el.Cards(ALL.shape, ALL.matrix, ALL.irradiance, units="cd/m2", notes="by hand")
    el.cards.CardSplit(noted, REST).save(tmp_path / "l.json")
    assert el.Lights.load(tmp_path / "l.json") == noted.lights
    assert el.compare(tmp_path / "l.json", noted.lights).probe_error == 0
    noted.lights.save(tmp_path / "same.json")
    assert (tmp_path / "l.json").read_bytes() == (tmp_path / "same.json").read_bytes()


@pytest.mark.parametrize("suffix", [".gltf", ".three.json"])
def test_no_loss_is_warned_of_where_cards_keep_their_size(suffix, tmp_path, recwarn):
    # The lights of three.js have one colour, as this card does.
    plain = el.Cards(["rectangle"], [cards.WINDOW.matrix[0]], [[3, 2, 1]])
    el.export.save(ALL[:2] if suffix == ".gltf" else plain, tmp_path / f"a{suffix}")
    assert not recwarn.list


def test_distance_or_radius_places_all_cards(tmp_path):
    def centre(**place):
        PARTS.save(tmp_path / "a.xml", **place)
        root = (tmp_path / "a.xml").read_text()
        matrix = np.array(root.split('matrix value="')[1].split('"')[0].split(), float)
        return np.linalg.norm(matrix.reshape(4, 4)[:3, 3])

    assert centre() == pytest.approx(1000)
    assert centre(distance=3) == pytest.approx(3)
    assert centre(radius=0.5) == pytest.approx(500)
    with pytest.raises(el.EnvLightsError, match="give only one of them"):
        PARTS.save(tmp_path / "a.xml", distance=3, radius=1)
    with pytest.raises(el.EnvLightsError, match="no path"):
        PARTS.save()


def test_units_of_blender_hold_for_cards(tmp_path):
    lux = el.Cards(["rectangle"], [cards.WINDOW.matrix[0]], [[683, 683, 683]], units="cd/m2")
    el.export.save(lux, tmp_path / "a.py")
    texture = el.io.read_image(tmp_path / "a.card_0.blender.exr").pixels
    np.testing.assert_allclose(texture[0, 0], lux.radiance[0] / 683, rtol=1e-6)
