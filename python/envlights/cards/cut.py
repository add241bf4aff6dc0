"""Cards of lights that were removed from a map."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights.cards.arrays import SHAPES
from envlights.cards.cards import Cards
from envlights.cards.geometry import sources, square_towards, unit
from envlights.environment.envmap import EnvMap
from envlights.rigs.lights import Lights


def cut(
    env: EnvMap,
    remainder: NDArray[np.float32],
    pixels: tuple[NDArray[np.int64], NDArray[np.int64]],
    block: int,
    lights: tuple[NDArray[np.float64], NDArray[np.float64]],
) -> tuple[Cards, NDArray[np.float32]]:
    """Cards of removed lights, and the map without the cards.

    Parameters
    ----------
    env : EnvMap
        The whole map.
    remainder : ndarray, shape (height, width, 3)
        The map without the lights; what lies beside the cards returns to it.
    pixels : pair of ndarray, shapes (k, 2) and (k,)
        Row and column of each block of a light, and the index of its light.
    block : int
        Pixels of the map along each side of a block.
    lights : pair of ndarray, shapes (n, 3) and (n,)
        Directions and angular radii of the removed lights.
    """
    parts = _native.cut_cards(
        env.radiance, remainder, env.is_border_sampled, block, *pixels, *lights
    )
    radius = [np.nan if each is None else each for each in parts.radius]
    shape = tuple(SHAPES[shape] for shape in parts.shape)
    matrix, irradiance = np.reshape(parts.matrix, (-1, 3, 3)), np.reshape(parts.irradiance, (-1, 3))
    cards = Cards(
        shape,
        matrix,
        irradiance,
        tuple(map(_with_irradiance, parts.texture, matrix, shape, irradiance)),
        parts.overlap,
        np.array(radius),
        units=env.units,
        notes=_notes(parts, len(lights[0])),
    )
    return cards[np.flatnonzero(cards.irradiance.any(axis=1))], parts.remainder


def with_discs(cards: Cards, lights: Lights) -> Cards:
    """Cards, with an additional disc for each light."""
    facing = [square_towards(each.direction, each.angular_radius) for each in lights]
    discs = Cards(("disc",) * len(lights), np.reshape(facing, (-1, 3, 3)), lights.irradiance)
    return replace(
        cards,
        shape=cards.shape + discs.shape,
        matrix=np.concatenate([cards.matrix, discs.matrix]),
        irradiance=np.concatenate([cards.irradiance, discs.irradiance]),
        textures=cards.textures + discs.textures,
        overlap=np.concatenate([cards.overlap, discs.overlap]),
        angular_radius=np.concatenate([cards.angular_radius, discs.angular_radius]),
        notes=(*cards.notes, *lights.notes),
    )


def _with_irradiance(
    texture: NDArray[np.float32],
    matrix: NDArray[np.float64],
    shape: str,
    irradiance: NDArray[np.float64],
) -> NDArray[np.float32]:
    """Texture scaled to the irradiance of its card, because pixel edges lose up to 3 % of it."""
    # With 256 parts, the edge of a disc is accurate to 0.05 %.
    directions, flux = sources(matrix, texture, 256, is_disc=shape == "disc")
    seen = (directions @ unit(matrix @ [0.5, 0.5, 1])) @ flux
    gain = np.where(seen > 0, irradiance / np.where(seen > 0, seen, 1), 1)
    return texture * gain.astype(np.float32)


def _notes(parts: _native.MapCards, lights: int) -> tuple[str, ...]:
    """Notes on lights merged to one card, and on windows detected by their edges."""
    several = [len(each) for each in parts.lights if len(each) > 1]
    windows = sum(parts.is_window)
    notes = []
    if several:
        notes.append(
            f"{sum(several)} of {lights} lights are panes, and became {_cards(len(several))}"
        )
    if windows:
        notes.append(
            f"{_cards(windows)} became a window by edges of the map, not by a level of luminance;"
            " its overlap is the contrast of its sides"
        )
    return tuple(notes)


def _cards(number: int) -> str:
    return "1 card" if number == 1 else f"{number} cards"
