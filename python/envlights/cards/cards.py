"""Light cards of a map."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native
from envlights._common.arrays import seal
from envlights._common.check import amount, count, flag, positive, reals, rotation, texts
from envlights._common.notes import Note
from envlights._common.result import Result
from envlights._common.tables import MOST_ROWS, Table
from envlights._common.units import OWN_SCALE, checked_units
from envlights._common.words import quantity
from envlights._native import EnvLightsError
from envlights.cards import geometry
from envlights.cards.arrays import (
    OUTLINED,
    ROUND,
    SHAPES,
    all_textures,
    angular_radii,
    matrices,
    overlaps,
    rows,
    shapes,
    uniform_radiance,
)
from envlights.cards.card import Card
from envlights.environment.envmap import EnvMap
from envlights.kernels import thumbnails
from envlights.kernels.angles import azimuths, elevations
from envlights.kernels.probe import rig_irradiance
from envlights.rigs.light_arrays import LARGEST_LIGHT, amounts, row_of, rows_of
from envlights.rigs.lights import Lights, Rows, brightest_first, rgb_cell, rgb_heading

#: Distance of cards without a given position, in scene radii: images differ from those with cards
#: at infinity by at most 0.3 %.
FAR = 1000.0
#: Largest distance, far below overflow of its cube.
_FARTHEST = 1e30


@dataclass(frozen=True, eq=False, repr=False)
class Cards(Result):
    r"""Light cards, brightest first: planar lights as seen from the origin.

    A card is the parallelogram of the points :math:`P(a, b) = O + a U + b V` with a and b from 0 to
    1. U goes to the right and V down where the card is seen from the origin with the top of the map
    up, so that :math:`\det [U V O] > 0`, and the card shines along :math:`V \times U`.

    Parameters
    ----------
    shape : sequence of str, length n
        "rectangle", "tube" (longer than 6 times its width), "disc", "point", "other" or "sphere". A
        disc is the ellipse inscribed in the parallelogram. Points and others are lights without a
        known outline; their card is a facing square around the light, as is that of a sphere, whose
        silhouette from the origin is the inscribed disc.
    matrix : array_like, shape (n, 3, 3)
        Columns U, V, O, in the frame of `EnvMap`. Cards of a map have their centre at distance 1.
    irradiance : array_like, shape (n, 3)
        Linear RGB that a surface receives from the whole card, if it faces the card's centre.
    textures : sequence of array_like, shape (rows, columns, 3), optional
        Linear radiance as the map has it, not mirrored: row 0 is at b = 0, column 0 at a = 0.
        Texels outside the ellipse of a disc are 0. Default: one texel of uniform radiance.
    overlap : array_like, shape (n,), optional
        Intersection over union of the light and its shape, from 0 to 1. Of a window with a view
        (see `notes`), the contrast of its sides: 1 where the inside is twice as bright. Default: 1.
    angular_radius : array_like, shape (n,), optional
        Radius of each light as a disc, in radians. Default: that of the solid angle of the card.
    units : {"the map's own scale", "cd/m2"}
        Unit of the radiance; see `Lights`.
    notes : str or iterable of str
        Remarks on estimates.
    is_placed : bool
        True if the distances of the cards are meant, as after `at`. Other cards are exported far
        away.

    Examples
    --------
    A window of 2 x 1 metres, 1 metre away:

    >>> import envlights as el
    >>> matrix = np.transpose([[-2, 0, 0], [0, -1, 0], [1, 0.5, 1]])
    >>> cards = el.Cards(["rectangle"], [matrix], [[3, 2, 1]])
    >>> cards[0]
    <Card: rectangle, 90.0° x 53.1°, azimuth 180.0°, elevation +0.0°>
    >>> cards.radiance.round(3)
    array([[2.647, 1.765, 0.882]])
    """

    shape: tuple[str, ...]
    matrix: NDArray[np.float64]
    irradiance: NDArray[np.float64]
    # The constructor replaces None.
    textures: tuple[NDArray[np.float32], ...] = None  # type: ignore[assignment]
    overlap: NDArray[np.float64] = None  # type: ignore[assignment]
    angular_radius: NDArray[np.float64] = None  # type: ignore[assignment]
    units: str = field(default=OWN_SCALE, kw_only=True)
    notes: tuple[str, ...] = field(default=(), kw_only=True)
    is_placed: bool = field(default=False, kw_only=True)

    def __post_init__(self) -> None:
        checked_units(self.units)
        object.__setattr__(self, "is_placed", flag("is_placed", self.is_placed))
        matrix = matrices(self.matrix)
        shape = shapes(self.shape, len(matrix))
        irradiance = rows("irradiance", self.irradiance, len(matrix), 3)
        amounts("irradiance", irradiance, LARGEST_LIGHT)
        order = brightest_first(irradiance)
        shape = tuple(shape[row] for row in order)
        irradiance, matrix = irradiance[order], matrix[order]
        values: dict[str, Any] = {
            "shape": shape,
            "matrix": seal(matrix),
            "irradiance": seal(irradiance),
            "textures": all_textures(
                self.textures, order, uniform_radiance(matrix, shape, irradiance)
            ),
            "overlap": seal(overlaps(self.overlap, len(matrix))[order]),
            "angular_radius": seal(angular_radii(self.angular_radius, order, matrix, shape)),
            "notes": tuple(map(Note, texts("notes", self.notes))),
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return len(self.matrix)

    @overload
    def __getitem__(self, which: int) -> Card: ...

    @overload
    def __getitem__(self, which: Rows) -> Cards: ...

    def __getitem__(self, which: int | Rows) -> Card | Cards:
        """A single card, or the cards selected by a slice, a list of indices or a mask."""
        rows = rows_of(which, len(self))
        if rows is None:
            return self._card(row_of(which, len(self)))
        return replace(
            self,
            shape=tuple(self.shape[row] for row in rows),
            matrix=self.matrix[rows],
            irradiance=self.irradiance[rows],
            textures=tuple(self.textures[row] for row in rows),
            overlap=self.overlap[rows],
            angular_radius=self.angular_radius[rows],
        )

    def __iter__(self) -> Iterator[Card]:
        return (self._card(row) for row in range(len(self)))

    def _card(self, row: int) -> Card:
        return Card(
            self.shape[row],
            self.matrix[row],
            self.irradiance[row],
            self.radiance[row],
            self.textures[row],
            float(self.overlap[row]),
            float(self.angular_radius[row]),
        )

    @property
    def corners(self) -> NDArray[np.float64]:
        """Unit directions of the corners O, O + U, O + U + V, O + V, (n, 4, 3).

        From the origin: top left, top right, bottom right, bottom left of the texture.
        """
        return geometry.corners(self.matrix)

    @property
    def direction(self) -> NDArray[np.float64]:
        """Unit directions of the centres, (n, 3)."""
        return geometry.unit(geometry.centres(self.matrix))

    @property
    def normal(self) -> NDArray[np.float64]:
        """Unit normals of the emitting sides, (n, 3)."""
        return geometry.normals(self.matrix)

    @property
    def size(self) -> NDArray[np.float64]:
        """Angles between midpoints of opposite edges along U and V, in radians, (n, 2)."""
        return geometry.sizes(self.matrix)

    @property
    def aspect(self) -> NDArray[np.float64]:
        """Ratio of the longer to the shorter side of each card, (n,)."""
        sizes = self.size
        ratios: NDArray[np.float64] = sizes.max(axis=1) / sizes.min(axis=1)
        return ratios

    @property
    def tilt(self) -> NDArray[np.float64]:
        """Angles between the normals and the directions to the origin, in radians, (n,)."""
        cosines = -np.einsum("ni,ni->n", self.normal, self.direction)
        angles: NDArray[np.float64] = np.arccos(np.clip(cosines, -1, 1))
        return angles

    @property
    def radiance(self) -> NDArray[np.float64]:
        """Uniform radiance that results in the irradiance of each card, (n, 3)."""
        return uniform_radiance(self.matrix, self.shape, self.irradiance)

    @property
    def lights(self) -> Lights:
        """Cards as directional lights, in the same order.

        A light has the direction of the card's centre, the card's irradiance, and its
        `angular_radius`.
        """
        arrays = self.direction, self.irradiance, self.angular_radius
        return Lights(*arrays, units=self.units, notes=self.notes)

    def texture(self, row: int) -> NDArray[np.float32]:
        """Linear radiance of a card, (rows, columns, 3), read-only; row 0 is at b = 0."""
        return self.textures[row_of(row, len(self))]

    def at(self, distance: float) -> Cards:
        """Cards moved to this distance of their centres from the origin, with unchanged radiance.

        Seen from the origin, nothing changes. Elsewhere a card at a finite distance has parallax:
        the error of an image falls as 1 / distance.
        """
        distance = positive("distance", distance, most=_FARTHEST)
        length = np.linalg.norm(geometry.centres(self.matrix), axis=1)
        matrix = self.matrix * (distance / length)[:, None, None]
        return replace(self, matrix=matrix, is_placed=True)

    def far(self, radius: float = 1.0) -> Cards:
        """Cards at 1000 scene radii, so far away that the distance has no effect.

        An image of a ball on a floor changes by about 2 / distance, in radii of the ball.
        """
        return self.at(FAR * positive("radius", radius, most=_FARTHEST / FAR))

    @property
    def has_outline(self) -> NDArray[np.bool_]:
        """Rectangles, tubes, discs and spheres: lights that are written with a position, (n,)."""
        return np.array([shape in OUTLINED for shape in self.shape], bool)

    @property
    def outlined_shapes(self) -> tuple[str, ...]:
        """Shapes of the cards that are written with a position, in their order."""
        return tuple(shape for shape in self.shape if shape in OUTLINED)

    @property
    def distant(self) -> Lights:
        """Lights without a known outline, as discs at infinity."""
        return self[~self.has_outline].lights

    def facing(self, row: int, normal: ArrayLike) -> Cards:
        """Cards with one card turned into a plane with this normal.

        Its centre stays, and its corners stay on their rays as closely as a parallelogram can:
        exactly for a card that is small, less so for one that is wide and turned far.

        Parameters
        ----------
        row : int
            Card to turn.
        normal : array_like, shape (3,)
            Normal of the plane; its sign does not matter.
        """
        row = row_of(row, len(self))
        vector = reals("normal", normal, 1)
        if vector.shape != (3,) or not np.isfinite(vector).all() or not vector.any():
            raise EnvLightsError(f"normal must be a vector other than 0; got {vector.tolist()}")
        matrix = self.matrix.copy()
        matrix[row] = geometry.tilt(matrix[row], geometry.unit(vector))
        return replace(self, matrix=matrix)

    def rotated(self, matrix: ArrayLike) -> Cards:
        """Rotate the cards: light from direction d then comes from ``matrix @ d``."""
        return replace(self, matrix=rotation(matrix) @ self.matrix)

    def scaled(self, factor: float) -> Cards:
        """Cards with all radiance multiplied by a non-negative factor."""
        return self._multiplied(np.full(len(self), amount("factor", factor)))

    def dimmed(self, row: int, factor: float) -> Cards:
        """Cards with one card multiplied by a non-negative factor, sorted again."""
        factors = np.ones(len(self))
        factors[row_of(row, len(self))] = amount("factor", factor)
        return self._multiplied(factors)

    def _multiplied(self, factors: NDArray[np.float64]) -> Cards:
        textures = (
            texture * np.float32(factor)
            for texture, factor in zip(self.textures, factors, strict=True)
        )
        irradiance = self.irradiance * factors[:, None]
        return replace(self, irradiance=irradiance, textures=tuple(textures))

    def probe(self, normals: ArrayLike, uniform: Sequence[str] = ()) -> NDArray[np.float64]:
        """Irradiance of the cards at unit normals, (n, 3).

        Parameters
        ----------
        normals : array_like, shape (n, 3)
        uniform : sequence of str
            Shapes of the cards whose textures are replaced by one radiance, as some programs do.

        Returns
        -------
        ndarray, shape (n, 3)
            Linear RGB; cards are sums over 64 x 64 parts or more.

        Examples
        --------
        >>> import envlights as el
        >>> env = el.EnvMap(el.synthetic.hall(64).radiance)
        >>> cards, remainder = el.split(env, shapes=True)
        >>> up = [[0.0, 1.0, 0.0]]
        >>> both = cards.probe(up) + remainder.probe(up)
        >>> np.allclose(both, env.probe(up), rtol=0.01)
        True
        """
        lights = self.distant
        arrays = lights.direction, lights.irradiance, lights.angular_radius
        out = rig_irradiance(normals, np.zeros(3), *arrays)
        for card in self[self.has_outline]:
            one = np.ones((1, 1, 3), np.float32)
            texture = one if card.shape in uniform else card.texture
            is_disc = card.shape in ROUND
            directions, flux = geometry.sources(card.matrix, texture, 64, is_disc=is_disc)
            seen = card.direction @ directions.T @ flux
            flux *= card.irradiance / np.where(seen > 0, seen, 1)
            out += rig_irradiance(normals, np.zeros(3), directions, flux)
        return out

    def to_map(self, width: int) -> EnvMap:
        """Map of the cards with their textures in a black sky.

        Pixels on an edge are as bright as their covered part, and all pixels of a card together
        have its irradiance. With the rest of `split`, this is the map again, up to the
        interpolation of the textures.

        Parameters
        ----------
        width : int
            Columns, an even number; the map is half as high.
        """
        width = count("width", width, least=4)
        if width % 2:
            raise EnvLightsError(f"width must be even; got {width}")
        sizes = [list(texture.shape[:2]) for texture in self.textures]
        texels = [texture.reshape(-1, 3) for texture in self.textures]
        drawn = _native.draw_cards(
            width // 2,
            width,
            False,
            self.matrix,
            [shape in ROUND for shape in self.shape],
            self.irradiance,
            sizes,
            np.concatenate([np.zeros((0, 3), np.float32), *texels]),
        )
        return EnvMap(drawn, units=self.units)

    def in_short(self) -> str:
        """Number of cards of each shape."""
        counts = ((self.shape.count(shape), shape) for shape in SHAPES)
        kinds = ", ".join(_quantity(count, shape) for count, shape in counts if count)
        return _quantity(len(self), "card") + (f": {kinds}" if kinds else "")

    def _table(self) -> Table:
        return self.table()

    def _lines(self) -> list[str]:
        return [f"note: {note}" for note in self.notes]

    def table(self) -> Table:
        """Table of the first dozen cards."""
        columns = ["card", "shape", "azimuth", "elevation", "size", "overlap"]
        rows = [self._cells(row) for row in range(min(len(self), MOST_ROWS))]
        hidden = quantity(len(self) - len(rows), "more card") if len(self) > len(rows) else ""
        rest = hidden if rows else "no card"
        colours = thumbnails.hex_of(self.irradiance[:MOST_ROWS])
        return Table([*columns, rgb_heading(self.units)], rows, rest, colours)

    def _cells(self, row: int) -> list[str]:
        azimuth, elevation = (
            np.rad2deg(of(self.direction[row : row + 1]))[0] for of in (azimuths, elevations)
        )
        width, height = np.rad2deg(self.size[row])
        return [
            f"{row + 1}",
            self.shape[row],
            f"{azimuth:.1f}°",
            f"{elevation:+.1f}°",
            f"{width:.1f}° x {height:.1f}°",
            f"{self.overlap[row]:.2f}",
            rgb_cell(self.irradiance[row]),
        ]

    def to_dict(self) -> dict[str, Any]:
        """Lists of numbers and strings, for example for JSON; without the textures."""
        return {
            "shape": list(self.shape),
            "matrix": self.matrix.tolist(),
            "irradiance": self.irradiance.tolist(),
            "radiance": self.radiance.tolist(),
            "overlap": self.overlap.tolist(),
            "angular_radius": self.angular_radius.tolist(),
            "scale": self.units,
            **({"notes": list(self.notes)} if self.notes else {}),
        }


Sequence.register(Cards)


def _quantity(count: int, noun: str) -> str:
    """Number of things with a noun; "other" has no plural."""
    return f"{count} {noun}" + ("" if count == 1 or noun == "other" else "s")
