"""Lights of random kind, size and place, for the families of `suite`."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from envlights.kernels import sampling, sphere
from envlights.kernels.image import LUMINANCE
from envlights.synthetic.backdrops import tint
from envlights.synthetic.shapes import Disc, Lamp, PixelSun, Rectangle, unit

#: Function that draws a random light or group of lights with the given radiance.
Kind = Callable[[np.random.Generator, NDArray[np.float64]], list[Lamp]]
_Place = Callable[[np.random.Generator], NDArray[np.float64]]
_Outline = Callable[[np.random.Generator, NDArray[np.float64], NDArray[np.float64]], Lamp]

#: Number of random directions to try before a light is omitted.
_TRIES = 50
#: Luminance of a sun, relative to the brightest surroundings.
_SUN = 1e5


def draw(
    rng: np.random.Generator,
    kinds: Mapping[str, Kind],
    first: str,
    contrast: tuple[float, float],
    gap_deg: float,
) -> tuple[list[Lamp], list[str]]:
    """One to five separate lights or groups, the first of a given kind.

    Parameters
    ----------
    rng : numpy.random.Generator
    kinds : mapping of str to callable
        The kinds that may be drawn.
    first : str
        The kind of the first.
    contrast : (float, float)
        Least and greatest luminance, where the surroundings have the luminance 1.
    gap_deg : float
        Least angle between the rims of two groups.

    Returns
    -------
    lamps : list of Disc, Rectangle or PixelSun
    names : list of str
        The kinds that were drawn.
    """
    lamps: list[Lamp] = []
    names = []
    # Draw kinds; draw each until it keeps its distance from the others.
    for name in [first, *rng.choice(list(kinds), size=rng.integers(0, 5))]:
        for _ in range(_TRIES):
            group = kinds[name](rng, _between(rng, *contrast) * tint(rng))
            if all(rim_gap_deg(new, old) > gap_deg for new in group for old in lamps):
                lamps += group
                names.append(str(name))
                break
    return lamps, names


def rim_gap_deg(lamp: Lamp, other: Lamp) -> float:
    """Smallest angle between the rims of two lights, in degrees."""
    cosine = np.clip(unit(lamp.direction) @ unit(other.direction), -1, 1)
    return float(np.rad2deg(np.arccos(cosine))) - lamp.reach_deg - other.reach_deg


def _between(rng: np.random.Generator, low: float, high: float) -> float:
    """Random number between `low` and `high` with a uniform logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _anywhere(rng: np.random.Generator) -> NDArray[np.float64]:
    (direction,) = sampling.uniform_sphere(rng.random((1, 2)))
    return np.asarray(direction)


def _on_seam(rng: np.random.Generator) -> NDArray[np.float64]:
    u = rng.uniform(-0.5, 0.5) / 360
    (direction,) = sphere.uv_to_direction([[u % 1, rng.uniform(0.15, 0.85)]])
    return np.asarray(direction)


def _on_pole(rng: np.random.Generator) -> NDArray[np.float64]:
    v = rng.uniform(0, 0.5) / 180
    (direction,) = sphere.uv_to_direction([[rng.random(), rng.choice([v, 1 - v])]])
    return np.asarray(direction)


def _disc(
    rng: np.random.Generator, direction: NDArray[np.float64], radiance: NDArray[np.float64]
) -> Disc:
    return Disc(direction, _between(rng, 0.25, 15), radiance)


def _large_disc(
    rng: np.random.Generator, direction: NDArray[np.float64], radiance: NDArray[np.float64]
) -> Disc:
    """A disc large enough to cross the seam or the pole near its centre."""
    return Disc(direction, _between(rng, 1, 12), radiance)


def _window(
    rng: np.random.Generator, direction: NDArray[np.float64], radiance: NDArray[np.float64]
) -> Rectangle:
    width = _between(rng, 3, 25)
    return Rectangle(direction, width, width * _between(rng, 0.6, 1.8), radiance)


def _glass_front(
    rng: np.random.Generator, direction: NDArray[np.float64], radiance: NDArray[np.float64]
) -> Rectangle:
    """A window as large as a twentieth to a ninth of the sphere."""
    return Rectangle(direction, rng.uniform(50, 90), rng.uniform(40, 60), radiance)


def _with_bars(
    rng: np.random.Generator, direction: NDArray[np.float64], radiance: NDArray[np.float64]
) -> Rectangle:
    width, height = rng.uniform(8, 25, size=2)
    panes = (int(rng.integers(2, 5)), int(rng.integers(1, 5)))
    # Make bars at least 0.3 degrees wide: half a pixel of 0.35 would look as bright as the panes.
    bar_deg = rng.uniform(0.3, 0.6)
    return Rectangle(direction, width, height, radiance, panes=panes, bar_deg=bar_deg)


def _tube(
    rng: np.random.Generator, direction: NDArray[np.float64], radiance: NDArray[np.float64]
) -> Rectangle:
    """A fluorescent tube."""
    length, thickness = rng.uniform(15, 60), rng.uniform(0.6, 2)
    return Rectangle(direction, length, thickness, radiance, tilt_deg=rng.uniform(0, 180))


def _sun(
    rng: np.random.Generator, direction: NDArray[np.float64], radiance: NDArray[np.float64]
) -> PixelSun:
    return PixelSun(direction, _SUN * radiance / (radiance @ LUMINANCE))


def _pair(rng: np.random.Generator, radiance: NDArray[np.float64]) -> list[Lamp]:
    """Two discs with a gap of 2 to 4 degrees between the rims."""
    radii = rng.uniform(0.5, 3, size=2)
    centre = _anywhere(rng)
    aside = unit(np.cross(centre, _anywhere(rng)))
    apart = np.deg2rad(radii.sum() + rng.uniform(2, 4))
    partner = np.cos(apart) * centre + np.sin(apart) * aside
    return [
        Disc(centre, float(radii[0]), radiance),
        Disc(partner, float(radii[1]), rng.uniform(1, 2) * radiance),
    ]


def _at(place: _Place, *outlines: _Outline) -> Kind:
    """Function that draws a light in direction `place`, with one of the outlines."""

    def kind(rng: np.random.Generator, radiance: NDArray[np.float64]) -> list[Lamp]:
        outline = outlines[rng.integers(len(outlines))]
        return [outline(rng, place(rng), radiance)]

    return kind


#: Kinds of the plain family.
PLAIN: Mapping[str, Kind] = {
    "disc": _at(_anywhere, _disc),
    "window": _at(_anywhere, _window),
    "tube": _at(_anywhere, _tube),
    "pair": _pair,
    "sun": _at(_anywhere, _sun),
    "glass front": _at(_anywhere, _glass_front),
    "seam": _at(_on_seam, _large_disc, _window),
    "pole": _at(_on_pole, _large_disc, _window),
}
#: Kinds around which a lens draws a round halo.
ROUND: Mapping[str, Kind] = {
    "disc": _at(_anywhere, _disc),
    "barred window": _at(_anywhere, _with_bars),
    "window": _at(_anywhere, _window),
    "sun": _at(_anywhere, _sun),
}
#: Kinds of the hard family.
HARD: Mapping[str, Kind] = {
    **ROUND,
    "tube": _at(_anywhere, _tube),
    "pair": _pair,
    "barred window at the seam": _at(_on_seam, _with_bars),
}
