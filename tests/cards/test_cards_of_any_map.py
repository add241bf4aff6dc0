"""Cards of cubes, of parts of the sphere and of clipped maps; their bits on any threads."""

import numpy as np
import pytest

import envlights as el
from envlights.export.look_up import looked_up
from tests.export.cards import irradiance
from tests.helpers import angle_deg, printed_by_threads
from tests.public_maps import public_maps


def hall(width=256):
    """A hall with three bright windows."""
    return el.EnvMap(el.synthetic.hall(width // 2).radiance)


def test_cards_of_a_cube_are_those_of_its_panorama():
    env = hall(1024)
    cube = el.EnvMap(env.to("cube", width=512).array, layout=el.io.Layout.cube(faces="opengl"))
    found, _ = el.split(cube, shapes=True)
    expected, _ = el.split(env, shapes=True)
    assert found.shape == expected.shape
    assert angle_deg(found.direction, expected.direction).max() < 0.2


def test_nothing_is_taken_from_what_a_map_does_not_show():
    env = hall()
    alpha = np.ones((*env.radiance.shape[:2], 1), np.float32)
    alpha[:, :64] = 0
    part = el.EnvMap(np.concatenate([env.radiance, alpha], axis=2))
    cards, rest = el.split(part, shapes=True)
    together = rest.radiance + cards.to_map(env.width).radiance
    normals, _ = el.kernels.icosphere(320)
    shown = np.where(alpha > 0, env.radiance, 0)
    expected = el.EnvMap(shown).probe(normals)
    error = el.EnvMap(np.where(alpha > 0, together, 0)).probe(normals) - expected
    assert len(cards) > 0
    assert np.linalg.norm(error) < 1e-2 * np.linalg.norm(expected)


def test_a_clipped_map_has_cards():
    codes = np.round(255 * np.clip(hall().radiance / 2, 0, 1) ** (1 / 2.2)).astype(np.uint8)
    env = el.EnvMap(codes)
    cards, rest = el.split(env, shapes=True)
    together = el.EnvMap(rest.radiance + cards.to_map(env.width).radiance)
    normals, _ = el.kernels.icosphere(320)
    expected = env.probe(normals)
    assert len(cards) > 0
    assert np.linalg.norm(together.probe(normals) - expected) < 1e-2 * np.linalg.norm(expected)


def test_textures_and_remainder_light_as_the_map_does():
    """Textures of cards as they are, drawn into a fine map, without the irradiance of the card."""
    angle = np.arccos(el.kernels.pixel_directions(128, 256) @ [0.48, 0.6, 0.64])
    lamp = np.where(angle < 0.1, 8 - 7 * (angle / 0.1) ** 2, 0.01)
    env = el.EnvMap(np.repeat(lamp[..., None], 3, axis=2).astype(np.float32))
    cards, rest = el.split(env, shapes=True)
    normals, _ = el.kernels.icosphere(320)
    expected = env.probe(normals)
    assert len(cards) == 1
    for shown in (irradiance(cards, normals, rest), cards.probe(normals) + rest.probe(normals)):
        assert np.linalg.norm(shown - expected) < 2e-3 * np.linalg.norm(expected)


@pytest.mark.parametrize("rows", [2, 4, 8])
def test_maps_too_small_for_cards_keep_their_lights(rows):
    radiance = np.full((rows, 2 * rows, 3), 0.05, np.float32)
    radiance[0, 0] = 100
    cards, rest = el.split(radiance, shapes=True)
    assert len(cards) == 0
    np.testing.assert_array_equal(rest.radiance, radiance)
    assert any("less than 32 columns has no cards" in note for note in rest.notes)


@public_maps("interior")
def test_a_light_that_is_another_card_leaves_no_black_card(path):
    cards = el.split(el.EnvMap.open(path), shapes=True).cards
    assert len(cards) == 12
    assert cards.irradiance.any(axis=1).all()


def test_cards_have_the_same_bits_for_any_number_of_threads():
    code = (
        "import hashlib, envlights as el\n"
        "cards, rest = el.split(el.EnvMap(el.synthetic.hall(128).radiance), shapes=True)\n"
        "parts = [cards.matrix, cards.irradiance, rest.radiance, *cards.textures]\n"
        "print(hashlib.sha256(b''.join(part.tobytes() for part in parts)).hexdigest())"
    )
    assert len(printed_by_threads(code)) == 1


def test_a_look_up_in_a_map_with_samples_on_its_borders_finds_the_cells():
    radiance = np.random.default_rng(2).random((16, 32, 3), np.float32)
    env = el.EnvMap(radiance, layout=el.io.Layout(registration="border-sampled"))
    towards = el.kernels.pixel_directions(16, 32).reshape(-1, 3)
    np.testing.assert_array_equal(looked_up(env, towards), env.cells().reshape(-1, 3))
