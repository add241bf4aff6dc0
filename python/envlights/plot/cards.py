"""Pictures of cards: outlines on the map, their textures, and a mirror ball."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from envlights.cards import geometry
from envlights.cards.arrays import ROUND
from envlights.cards.card import Card
from envlights.cards.card_split import CardSplit
from envlights.cards.cards import Cards
from envlights.environment.envmap import EnvMap
from envlights.environment.reading import AnyMap, as_envmap
from envlights.export.look_up import looked_up
from envlights.kernels import thumbnails
from envlights.kernels.image import LUMINANCE
from envlights.plot.ball import ball
from envlights.plot.figure import check_is, hide_frame
from envlights.plot.ground import degrees, draw_map, expose, working
from envlights.plot.markers import draw_legend, draw_numbers
from envlights.plot.page import Placement, Unpack, grid, open_page, placed_picture
from envlights.plot.wording import entitle

#: Outline colours that are distinguishable for colour-blind readers (Okabe and Ito 2008).
_COLOURS = {
    "rectangle": "#ff2bd6",
    "tube": "#56b4e9",
    "disc": "#f0e442",
    "point": "white",
    "other": "#e69f00",
    "sphere": "#f0e442",
}
#: Number of points per edge of an outline.
_STEPS = 32
#: Largest number of textures on a sheet, and number of columns.
_MOST_TEXTURES, _COLUMNS = 40, 8


@placed_picture
def cards(env: AnyMap, cards: Cards, **where: Unpack[Placement]) -> Figure:
    """Draw the outlines of cards on the map with their numbers, coloured by shape.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map.
    cards : Cards
        The cards of `split` with ``shapes=True``.
    **where
        `ax`, `figsize`, `dpi` and `transparent`; see `envlights.plot`.

    Examples
    --------
    >>> import envlights as el
    >>> env = el.EnvMap(el.synthetic.hall(64).radiance)
    >>> figure = el.plot.cards(env, el.split(env, shapes=True).cards)
    >>> len(figure.axes)
    1
    """
    check_is("cards", cards, Cards)
    page = open_page(where, grid(1, 1), (12, 7))
    exposure = draw_cards(page.panels[0], env, cards)
    page.entitle(f"{cards.in_short()}\n{exposure}")
    return page.figure


def draw_cards(axes: Axes, env: AnyMap, cards: Cards) -> str:
    """Draw a map and outlines of cards; return a sentence that states the exposure."""
    exposure = draw_map(axes, as_envmap(env))
    for card in cards:
        axes.plot(*_outline(card).T, color=_COLOURS[card.shape], lw=1.4, path_effects=_edge(2.4))
    at = degrees(cards.direction)
    draw_numbers(axes, at, np.zeros(len(cards)))
    drawn = [shape for shape in _COLOURS if shape in cards.shape]
    entries = [
        Line2D([], [], color=_COLOURS[shape], lw=2, label=shape, path_effects=_edge(3.4))
        for shape in drawn
    ]
    if entries:
        draw_legend(axes, entries)
    return exposure


def _edge(width: float) -> list[withStroke]:
    """Dark border for a line, so that white lines are visible on white."""
    return [withStroke(linewidth=width, foreground="#404040")]


@placed_picture
def card_textures(cards: Cards, **where: Unpack[Placement]) -> Figure:
    """Draw the textures of cards at a common exposure, brightest card first.

    Parameters
    ----------
    cards : Cards
        Cards to draw: at most the 40 brightest.
    **where
        `ax`: axes, one for each texture; `figsize`, `dpi`, `transparent`: see `envlights.plot`.

    Examples
    --------
    >>> import envlights as el
    >>> env = el.EnvMap(el.synthetic.hall(64).radiance)
    >>> figure = el.plot.card_textures(el.split(env, shapes=True).cards)
    >>> figure.get_suptitle()[:8]
    'exposure'
    """
    check_is("cards", cards, Cards)
    drawn = list(cards[:_MOST_TEXTURES])
    count = max(len(drawn), 1)
    columns = min(count, _COLUMNS)
    mosaic = np.full((-(-count // columns), columns), -1)
    mosaic.flat[:count] = range(count)
    size = (1.6 * columns + 0.5, 1.9 * len(mosaic) + 0.7)
    page = open_page(where, mosaic, size)
    white = _white([card.texture for card in drawn])
    for number, (each, card) in enumerate(zip(page.panels, drawn, strict=False), 1):
        _draw_texture(each, card, white)
        entitle(each, f"{number} {card.shape}", "small")
    for each in page.panels:
        hide_frame(each)
    hidden = len(cards) - len(drawn)
    more = f"; {hidden} more cards are not drawn" if hidden else ""
    page.entitle(f"exposure: white is luminance {white:.3g}{more}")
    return page.figure


@placed_picture
def card_balls(env: AnyMap, parts: CardSplit, **where: Unpack[Placement]) -> Figure:
    """Draw mirror balls under the map, under remainder and discs, and under remainder and cards.

    The ball is seen from below the brightest card, which it reflects near its centre. All balls
    have the exposure of the map.

    Parameters
    ----------
    env : EnvMap, path-like or array_like, shape (height, 2 * height, 3)
        The map.
    parts : CardSplit
        The result of `split` with ``shapes=True`` on it.
    **where
        `ax`: three axes; `figsize`, `dpi`, `transparent`: see `envlights.plot`.

    Examples
    --------
    >>> import envlights as el
    >>> env = el.EnvMap(el.synthetic.hall(64).radiance)
    >>> figure = el.plot.card_balls(env, el.split(env, shapes=True))
    >>> [axes.get_title() for axes in figure.axes]
    ['the map', 'the rest and discs', 'the rest and cards']
    """
    check_is("parts", parts, CardSplit)
    env = as_envmap(env)
    width = parts.remainder.width
    drawn = {
        "the map": (env,),
        "the rest and discs": (parts.remainder, parts.cards.lights.to_map(width // 2)),
        "the rest and cards": (parts.remainder, parts.cards.to_map(width)),
    }
    white = expose(working(env)).white
    eye = _eye(parts.cards)
    page = open_page(where, grid(1, 3), (9, 3.6))
    for axes, (title, each) in zip(page.panels, drawn.items(), strict=True):
        axes.imshow(_mirror(each, eye, white))
        entitle(axes, title, "small")
        hide_frame(axes)
    return page.figure


def _eye(cards: Cards) -> NDArray[np.float64]:
    """Horizontal direction of the brightest card; the map centre if there is none."""
    level = cards.direction[0] * [1, 0, 1] if len(cards) else np.zeros(3)
    length = np.linalg.norm(level)
    eye: NDArray[np.float64] = level / length if length > 1e-3 else np.array([0.0, 0.0, 1.0])
    return eye


def _mirror(maps: Iterable[EnvMap], eye: NDArray[np.float64], white: float) -> NDArray[np.float64]:
    """Picture of a mirror ball under the sum of several maps."""
    view = ball(eye)
    towards = 2 * (view.normals @ eye)[:, None] * view.normals - eye
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    seen = np.sum([looked_up(each, towards) for each in maps], axis=0)
    return view.image(thumbnails.expose(seen, white) / 255)


def _draw_texture(axes: Axes, card: Card, white: float) -> None:
    """Draw a texture with the aspect ratio of its card."""
    width, height = np.linalg.norm(card.matrix[:, :2], axis=0)
    codes = thumbnails.expose(card.texture, white)
    extent = (0.0, float(width), 0.0, float(height))
    axes.imshow(codes, extent=extent, interpolation="nearest")


def _white(textures: Sequence[NDArray[np.float32]]) -> float:
    """Luminance displayed as white: the 99 % quantile of all texels."""
    texels = [np.zeros(0), *((texture @ LUMINANCE).ravel() for texture in textures)]
    values = np.concatenate(texels)
    values = values[values > 0]
    return float(np.quantile(values, 0.99)) if len(values) else 1.0


def _outline(card: Card) -> NDArray[np.float64]:
    """Azimuth and elevation around a card, with gaps at the seam."""
    if card.shape in ROUND:
        directions = geometry.outline(card.matrix, is_ellipse=True)
    else:
        ends = geometry.points(card.matrix[None], geometry.CORNERS)[0]
        steps = np.linspace(0, 1, _STEPS, endpoint=False)[:, None]
        sides = [a + steps * (b - a) for a, b in zip(ends, np.roll(ends, -1, axis=0), strict=True)]
        directions = geometry.unit(np.concatenate(sides))
    around = degrees(np.vstack([directions, directions[:1]]))
    around[1:][np.abs(np.diff(around[:, 0])) > 180] = np.nan
    return around
