"""A family of maps: windows behind bars or leaves, and rows of lamps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import count
from envlights.kernels import sampling, sphere
from envlights.synthetic import backdrops
from envlights.synthetic.scene import MOST_ROWS, SyntheticMap, scene
from envlights.synthetic.shapes import Disc, Rectangle, Shape, unit

#: Narrowest and widest bar in degrees, and widest bar relative to a pane.
_NARROWEST_BAR_DEG, _WIDEST_BAR_DEG, _WIDEST_SHARE = 0.5, 2.2, 0.3
#: Rows of the smallest map that shows the narrowest bar.
_LEAST_HEIGHT = 256

#: Narrowest gap between two lamps of a row, in degrees; `detect` bridges narrower gaps (`gap_deg`).
_NARROWEST_GAP_DEG = 1.5


@dataclass(frozen=True)
class _Foliage:
    """A round piece of sky behind leaves of 0.75 to 2 degrees."""

    disc: Disc
    waves: NDArray[np.float64]
    cover: float

    @property
    def radiance(self) -> ArrayLike:
        return self.disc.radiance

    def coverage(self, height: int) -> NDArray[np.float64]:
        def waves(directions: NDArray[np.float64]) -> NDArray[np.float64]:
            sums: NDArray[np.float64] = np.cos(
                directions @ self.waves[:, :3].T + self.waves[:, 3]
            ).sum(axis=-1)
            return sums

        level = sphere.over_map(height, waves)
        inside = self.disc.coverage(height)
        open_sky = level > np.quantile(level[inside > 0], self.cover)
        covered: NDArray[np.float64] = inside * open_sky
        return covered


_Draw = Callable[[np.random.Generator, NDArray[np.float64]], tuple[list[Shape], str]]


def openings(seed: int, height: int = 512) -> SyntheticMap:
    """A map with one window behind bars or leaves, or with one row of lamps.

    Windows and skylights have 2 to 40 panes, and bars of at most 0.3 of a pane. Lamps of a row are
    discs, square panels or tubes, with gaps of at least 0.6 of their width and 1.5 degrees. All are
    8 to 60 times as bright as the brightest surroundings.

    Parameters
    ----------
    seed : int
        Number of the map; see `TUNING` and `EVALUATION`.
    height : int
        Rows, 256 or more; the map is twice as wide.

    Returns
    -------
    SyntheticMap

    Examples
    --------
    >>> world = openings(0, height=256)
    >>> world.note, len(world.lights)
    ('a window of 6 x 4 panes', 1)
    """
    height = count("height", height, least=_LEAST_HEIGHT, most=MOST_ROWS)
    rng = np.random.default_rng([count("seed", seed), 3])
    draw = _KINDS[seed % len(_KINDS)]
    ground = (backdrops.constant, backdrops.gradient)[seed // len(_KINDS) % 2](rng, height)
    radiance = np.exp(rng.uniform(np.log(8), np.log(60))) * backdrops.tint(rng)
    shapes, note = draw(rng, radiance)
    return scene(height, background=ground, shapes=shapes, note=note)


def _towards(rng: np.random.Generator, lowest: float, highest: float) -> NDArray[np.float64]:
    """A direction between two elevations, in degrees."""
    elevation = rng.uniform(lowest, highest)
    (direction,) = sphere.uv_to_direction([[rng.random(), 0.5 - elevation / 180]])
    return np.asarray(direction)


def _panes(
    rng: np.random.Generator, direction: NDArray[np.float64], radiance: NDArray[np.float64]
) -> tuple[list[Shape], str]:
    # Draw the number of panes, then the size of each.
    across, along = int(rng.integers(2, 9)), int(rng.integers(1, 6))
    pane = rng.uniform(2.5, min(10.0, 90 / max(across, along)))
    bar = np.clip(pane * rng.uniform(0.1, _WIDEST_SHARE), _NARROWEST_BAR_DEG, _WIDEST_BAR_DEG)
    width, height = across * pane, along * pane * rng.uniform(0.8, 1.25)
    window = Rectangle(direction, width, height, radiance, panes=(across, along), bar_deg=bar)
    return [window], f"{across} x {along} panes"


def _window(rng: np.random.Generator, radiance: NDArray[np.float64]) -> tuple[list[Shape], str]:
    shapes, note = _panes(rng, _towards(rng, -20, 40), radiance)
    return shapes, f"a window of {note}"


def _skylight(rng: np.random.Generator, radiance: NDArray[np.float64]) -> tuple[list[Shape], str]:
    shapes, note = _panes(rng, _towards(rng, 60, 90), radiance)
    return shapes, f"a skylight of {note}"


def _leaves(rng: np.random.Generator, radiance: NDArray[np.float64]) -> tuple[list[Shape], str]:
    disc = Disc(_towards(rng, 10, 80), rng.uniform(8, 25), radiance)
    axes = sampling.uniform_sphere(rng.random((24, 2)))
    waves = np.c_[rng.uniform(90, 240, (24, 1)) * axes, rng.uniform(0, 2 * np.pi, 24)]
    cover = rng.uniform(0.25, 0.5)
    return [_Foliage(disc, waves, cover)], f"sky behind leaves that cover {100 * cover:.0f} %"


def _row(rng: np.random.Generator, radiance: NDArray[np.float64]) -> tuple[list[Shape], str]:
    # Draw the lamps, then the distance between them.
    lamps, kind = int(rng.integers(3, 9)), rng.integers(3)
    breadth = rng.uniform(0.8, 5.0) if kind < 2 else rng.uniform(0.8, 1.5)
    pitch = breadth + max(breadth * rng.uniform(0.6, 2.0), _NARROWEST_GAP_DEG)
    centre = _towards(rng, -20, 60)
    right = unit(np.cross([0.0, 1.0, 0.0], centre))
    shapes: list[Shape] = []
    for i in range(lamps):
        angle = np.deg2rad(pitch * (i - (lamps - 1) / 2))
        direction = np.cos(angle) * centre + np.sin(angle) * right
        if kind == 0:
            shapes.append(Disc(direction, breadth / 2, radiance))
        else:
            high = breadth if kind == 1 else 12 * breadth
            shapes.append(Rectangle(direction, breadth, high, radiance))
    return shapes, f"a row of {lamps} {('discs', 'panels', 'tubes')[kind]}"


#: Kinds of maps, in the order of the seeds.
_KINDS: tuple[_Draw, ...] = (_window, _row, _skylight, _leaves)
