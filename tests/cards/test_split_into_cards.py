"""`split` into cards: shapes, corners, energy, panes, rotation, other layouts."""

import numpy as np
import pytest
from benchmarks.cards import corner_error, maps

import envlights as el
from envlights.cards import geometry
from envlights.kernels.sphere import pixel_directions


def scene_of(*cards: tuple[np.ndarray, float], width: int = 512, around: float = 0.3) -> np.ndarray:
    """Map of uniform cards, each with a radiance."""
    height = width // 2
    directions = pixel_directions(4 * height, 4 * width)
    radiance = np.full((height, width), around)
    for matrix, value in cards:
        p = directions @ np.linalg.inv(matrix).T
        place = p[..., :2] / np.where(p[..., 2:] > 1e-6, p[..., 2:], np.inf)
        inside = ((place >= 0) & (place <= 1)).all(axis=-1) & (p[..., 2] > 1e-6)
        radiance += value * inside.reshape(height, 4, width, 4).mean(axis=(1, 3))
    return np.repeat(radiance[..., None], 3, axis=2).astype(np.float32)


def window(bars: float, columns: int, rows: int) -> tuple[list[np.ndarray], np.ndarray]:
    """Panes of a window of 0.9 x 0.6 radians in the middle of the map, and its own matrix."""
    width, height = 0.9, 0.6
    whole = np.transpose([[-width, 0, 0], [0, -height, 0], [width / 2, height / 2, 1]])
    u, v, o = whole.T
    panes = []
    for column in range(columns):
        for row in range(rows):
            a = (width + bars) / columns / width
            b = (height + bars) / rows / height
            corner = o + column * a * u + row * b * v
            side = (a - bars / width) * u, (b - bars / height) * v
            panes.append(np.stack([*side, corner], axis=1))
    return panes, whole


@pytest.mark.parametrize("degrees", [0.35, 0.7, 1.4, 2.0, 2.8, 4.0])
@pytest.mark.parametrize("bar_share", [0.0, 0.1])
def test_the_panes_of_a_window_become_one_card(degrees, bar_share):
    panes, whole = window(np.deg2rad(degrees), 3, 2)
    env = scene_of(*((pane, 20.0 * (1 - bar_share)) for pane in panes), (whole, 20.0 * bar_share))
    cards, _ = el.split(env, shapes=True)
    assert cards.shape == ("rectangle",)
    assert np.rad2deg(corner_error(cards, whole) * 2 * np.pi / 512) < 0.1


def test_generated_lights_have_their_shape_corners_and_flux():
    truths = [truth for truth in maps(24, 5) if truth.thickness >= 5]
    errors, fluxes = [], []
    for truth in truths:
        cards, _ = el.split(truth.radiance, shapes=True)
        assert cards.shape[0] == truth.shape
        errors.append(corner_error(cards, truth.matrix) if truth.kind != "disc" else 0.0)
        fluxes.append(abs(cards.irradiance[0, 1] / truth.irradiance[1] - 1))
    assert len(truths) >= 10
    assert np.median(errors) < 0.3
    assert max(errors) < 1
    assert np.median(fluxes) < 0.02


def test_the_map_is_the_rest_and_the_cards():
    panes, _ = window(0.3, 2, 1)
    env = el.EnvMap(scene_of(*((pane, 20.0) for pane in panes)))
    cards, rest = el.split(env, shapes=True)
    normals = el.kernels.icosphere(320)[0]
    both = rest.probe(normals) + cards.to_map(512).probe(normals)
    assert np.abs(both / env.probe(normals) - 1).max() < 1e-3
    assert rest.radiance.min() >= 0
    assert (rest.radiance <= env.radiance * (1 + 1e-6)).all()


def texture_irradiance(card: el.cards.Card) -> np.ndarray:
    """Irradiance of the texels towards the centre of a card, each by Lambert's formula."""
    rows, columns = card.texture.shape[:2]
    u, v, o = card.matrix.T
    total = np.zeros(3)
    for row in range(rows):
        for column in range(columns):
            texel = np.stack(
                [u / columns, v / rows, o + column / columns * u + row / rows * v], axis=1
            )
            vector = geometry.vector_irradiance(geometry.outline(texel, False))
            total += card.texture[row, column] * (vector @ card.direction)
    return total


def test_textures_and_the_removed_radiance_have_the_irradiance_of_their_cards():
    panes, _ = window(0.3, 2, 1)
    env = el.EnvMap(scene_of((panes[0], 20.0), (panes[1], 3.0), width=128))
    cards, rest = el.split(env, shapes=True)
    weights = el.kernels.pixel_solid_angles(64, 128)[..., None]
    towards = pixel_directions(64, 128)
    removed = (env.radiance.astype(float) - rest.radiance) * weights
    assert len(cards)
    total = np.einsum("hwc,hwi->ci", removed, towards)
    together = np.einsum("nc,ni->ci", cards.irradiance, cards.direction)
    assert np.allclose(total @ [0, 0, 1], together @ [0, 0, 1], rtol=2e-2)
    for card in cards:
        assert np.allclose(texture_irradiance(card), card.irradiance, rtol=1e-5)


def test_a_rotated_map_has_rotated_cards():
    (pane, _), _ = window(0.3, 2, 1)
    angle = 0.7
    turn = np.array(
        [[np.cos(angle), np.sin(angle), 0], [-np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    turn = turn @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    rotated, _ = el.split(scene_of((turn @ pane, 20.0)), shapes=True)
    assert corner_error(rotated, turn @ pane) < 0.3


def test_overlapping_cards_take_no_more_than_all():
    (first, second), _ = window(-0.1, 2, 1)
    env = el.EnvMap(scene_of((first, 20.0), (second, 90.0)))
    _, rest = el.split(env, shapes=True)
    assert rest.radiance.min() >= 0


def test_a_border_sampled_map_has_the_same_card():
    (pane, _), _ = window(0.3, 2, 1)
    env = el.EnvMap(scene_of((pane, 20.0)))
    border = el.EnvMap(
        scene_of((pane, 20.0), width=512), layout=el.io.Layout(registration="border-sampled")
    )
    ours, theirs = (el.split(each, shapes=True)[0] for each in (env, border))
    # The same pixels lie up to half a pixel elsewhere.
    assert theirs.shape == ours.shape == ("rectangle",)
    assert corner_error(theirs, pane) < 1


def test_a_map_without_lights_has_no_cards():
    parts = el.split(np.full((64, 128, 3), 0.5, np.float32), shapes=True)
    assert len(parts.cards) == 0
    assert np.array_equal(parts.remainder.radiance, np.full((64, 128, 3), 0.5, np.float32))
    assert "no card" in str(parts)


def test_a_flag_that_is_no_flag_is_refused():
    with pytest.raises(el.EnvLightsError, match="shapes must be True or False"):
        el.split(np.ones((64, 128, 3)), shapes=1)
