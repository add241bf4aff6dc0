"""Cards, and the map without the cards."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, NamedTuple

from envlights._common.former import former_attributes
from envlights._native import EnvLightsError
from envlights.cards.cards import Cards
from envlights.environment.envmap import EnvMap
from envlights.export.links import LinkedParts, save_with_map


class _Fields(NamedTuple):
    """Fields of a `CardSplit`."""

    cards: Cards
    """Lights as cards, brightest first."""

    remainder: EnvMap
    """Map without the cards."""


@former_attributes(rest="remainder")
class CardSplit(_Fields, LinkedParts):
    """Light cards, and the map without the cards."""

    __slots__ = ()

    @property
    def lights(self) -> Cards:
        """Cards, under the name that texts and files use for lights."""
        return self.cards

    def __str__(self) -> str:
        return f"{self.cards}\n\nthe map without these cards: {self.remainder}"

    def save(
        self,
        *paths: str | os.PathLike[str],
        distance: float | None = None,
        radius: float | None = None,
        **options: Any,
    ) -> tuple[Path, ...]:
        """Write the cards and the remaining map, for one or several programs.

        The remainder is written and named as by `Split.save`. OpenUSD, Mitsuba, Blender, pbrt,
        three.js and glTF show rectangles, tubes and discs as planes with their textures, and all
        other lights as discs at infinity. Other programs show all lights as discs.

        Parameters
        ----------
        *paths : path-like
            Scenes (`el.export.TARGETS` lists the suffixes), and files of the remainder (.exr,
            .hdr).
        distance : float, optional
            Distance of the centre of each card from the origin. By default, cards that were placed
            by `Cards.at` stay, and others are at 1000 times `radius`, where the distance has no
            effect.
        radius : float, optional
            Radius of the scene that the cards light. Default: 1.
        **options
            Further arguments of the writers that have them: ``up="z"`` of OpenUSD.

        Returns
        -------
        tuple of Path
            All written files.

        Raises
        ------
        EnvLightsError
            If there is no path, a suffix is unknown, two files have the same path, one cannot be
            written, or both `distance` and `radius` are given.

        Examples
        --------
        >>> import tempfile
        >>> import numpy as np
        >>> import envlights as el
        >>> matrix = np.transpose([[-2, 0, 0], [0, -1, 0], [1, 0.5, 1]])
        >>> cards = el.Cards(["rectangle"], [matrix], [[3, 2, 1]])
        >>> parts = el.cards.CardSplit(cards, el.EnvMap(np.ones((8, 16, 3))))
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     written = parts.save(Path(folder, "rest.exr"), Path(folder, "room.usda"))
        ...     [path.name for path in written]
        ['rest.exr', 'room.usda', 'room.card_0.usd.exr']
        """
        return save_with_map(
            at_place(self.cards, distance, radius), self.remainder, paths, **options
        )


def at_place(cards: Cards, distance: float | None, radius: float | None) -> Cards:
    """Cards at a distance, or far away relative to a scene of this radius."""
    if distance is not None and radius is not None:
        raise EnvLightsError(
            "distance places the cards, and radius puts them far away; give only one of them"
        )
    if radius is not None:
        return cards.far(radius)
    return cards if distance is None else cards.at(distance)
