"""A family of maps with large lights of low contrast to their local background."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from envlights._blocks import in_blocks
from envlights._check import count
from envlights.kernels import sampling, sphere
from envlights.kernels.image import LUMINANCE
from envlights.synthetic import backdrops
from envlights.synthetic.lamps import rim_gap_deg
from envlights.synthetic.scene import MOST_ROWS, Camera, SyntheticMap, normal_numbers, scene
from envlights.synthetic.shapes import Disc, Lamp, Rectangle

#: Rows of the smallest map that shows the outlines.
_LEAST_HEIGHT = 128
#: Least and greatest contrast to the local background.
_CONTRAST = 2.5, 4.0
#: Least flux, as a share of the ground's: the places of a map add less than half of that to it.
_LEAST_SHARE = 0.015
#: Degrees from the rim of a place to where its local background ends; places are twice that apart.
_AROUND_DEG = 5.0
#: The local background varies at most by this factor: else contrast to it says nothing.
_MOST_VARIATION = 2.0
#: Places that are tried for one map.
_TRIES = 100
#: Rows on which the local background is read.
_ROWS = 128
#: Least and greatest radius of a disc, and side of a window, in degrees.
_RADIUS_DEG, _SIDE_DEG = (4.0, 22.0), (6.0, 40.0)


def faint(seed: int, height: int = 512) -> SyntheticMap:
    """A map with discs and windows that are 2.5 to 4 times as bright as their local background.

    Each gives at least 1 % of the map's flux. Discs have a radius of 4 to 22 degrees, windows sides
    of 6 to 40. The ground is even or a sky, without noise or with 3 to 10 %. Every sixth map has no
    light.

    Parameters
    ----------
    seed : int
        Which map; see `TUNING` and `JUDGING`.
    height : int
        Rows, 128 or more; the map is twice as wide.

    Returns
    -------
    SyntheticMap

    Examples
    --------
    >>> faint(1, height=128).note
    '3 lights, sky ground, 0 % noise'
    """
    height = count("height", height, least=_LEAST_HEIGHT, most=MOST_ROWS)
    rng = np.random.default_rng([count("seed", seed), 4])
    # Draw the ground and what stands before it.
    ground = (backdrops.constant, backdrops.gradient)[seed % 2](rng, height)
    noise = rng.uniform(0.03, 0.1) if seed // 2 % 2 else 0.0
    places = _places(rng, ground) if seed % 6 != 5 else []
    # Take the picture.
    words = [f"{len(places) or 'no'} light{'s' * (len(places) != 1)}"]
    words += [f"{('even', 'sky')[seed % 2]} ground", f"{100 * noise:.2g} % noise"]
    camera = _grain(rng, height, noise) if noise else None
    return scene(height, background=ground, shapes=places, camera=camera, note=", ".join(words))


def _grain(rng: np.random.Generator, height: int, noise: float) -> Camera:
    normal = normal_numbers(rng, (height, 2 * height, 3))

    def camera(radiance: NDArray[np.float64]) -> NDArray[np.float64]:
        return in_blocks(
            radiance.shape,
            lambda rows: np.maximum((1 + noise * normal[rows]) * radiance[rows], 0),
        )

    return camera


def _places(rng: np.random.Generator, ground: NDArray[np.float64]) -> list[Lamp]:
    """At most three places that stand apart, each with enough of the map's flux."""
    # Read the ground in few pixels.
    size = min(len(ground), _ROWS), 2 * min(len(ground), _ROWS)
    middles = (
        ((np.arange(few) + 0.5) * many / few).astype(int)
        for few, many in zip(size, ground.shape, strict=False)
    )
    level = ground[np.ix_(*middles)] @ LUMINANCE
    directions, solid_angle = sphere.pixel_directions(*size), sphere.pixel_solid_angles(*size)
    # Draw outlines, and keep those with enough flux before a local background.
    least = _LEAST_SHARE * (level * solid_angle).sum()
    wanted = int(rng.integers(1, 4))
    places: list[Lamp] = []
    for _ in range(_TRIES):
        place, contrast, tint = _outline(rng), rng.uniform(*_CONTRAST), backdrops.tint(rng)
        angle = place.angle_deg(directions)
        around = level[angle < _AROUND_DEG]
        is_local = around.max() < _MOST_VARIATION * around.min()
        is_enough = contrast * around.mean() * solid_angle[angle == 0].sum() > least
        is_apart = all(rim_gap_deg(place, other) > 2 * _AROUND_DEG for other in places)
        if is_local and is_enough and is_apart:
            places.append(replace(place, radiance=contrast * around.mean() * tint))
        if len(places) == wanted:
            break
    return places


def _outline(rng: np.random.Generator) -> Lamp:
    (direction,) = sampling.uniform_sphere(rng.random((1, 2)))
    if rng.random() < 0.5:
        return Disc(direction, rng.uniform(*_RADIUS_DEG), np.ones(3))
    width, height = rng.uniform(*_SIDE_DEG, 2)
    return Rectangle(direction, width, height, np.ones(3), tilt_deg=rng.uniform(0, 90))
