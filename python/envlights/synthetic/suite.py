"""Two families of random maps with known lights, for the evaluation of detectors.

The same seed always gives the same map. Use the seeds `TUNING` to choose a threshold, and the seeds
`EVALUATION` only for final numbers.

Gaps of some degrees separate the lights. They are at least 8 times as bright as the brightest
surroundings, and at least 2.5 times in pictures clipped to 1.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from envlights._common.blocks import in_blocks
from envlights._common.check import count
from envlights._common.srgb import decode_srgb
from envlights.synthetic import backdrops, lamps
from envlights.synthetic.scene import MOST_ROWS, Camera, SyntheticMap, normal_numbers, scene
from envlights.synthetic.shapes import Lamp, PixelSun

#: Seeds for choosing thresholds.
TUNING = range(0, 60)
#: Seeds for published numbers, never for the choice of a threshold.
EVALUATION = range(1000, 1060)

#: Rows of the smallest map whose samples are close enough to show a disc of 0.25 degrees.
_LEAST_HEIGHT = 128

_Backdrop = Callable[[np.random.Generator, int], NDArray[np.float64]]

_PLAIN_BACKDROPS: Mapping[str, _Backdrop] = {
    "even": backdrops.constant,
    "sky": backdrops.gradient,
    "noise": backdrops.constant,
    "white wall": backdrops.white_wall,
    "checker": backdrops.checker,
}
_HARD_BACKDROPS: Mapping[str, _Backdrop] = {
    "clouds": backdrops.clouds,
    "lit walls": backdrops.lit_walls,
    "sky": backdrops.gradient,
}
_CLUTTER = ("clouds", "lit walls")


def plain(seed: int, height: int = 512) -> SyntheticMap:
    """Map without distractors.

    Discs of 0.25 to 15 degrees in radius, windows, glass fronts, tubes, close pairs and one-pixel
    suns, some across the seam or on a pole. The background is even, a clear sky, noise of 2 %, a
    white wall or tiles. Some maps have another exposure; some are clipped to 1, and some of these
    have 8 bits. Every tenth map has no light.

    Parameters
    ----------
    seed : int
        Number of the map; see `TUNING` and `EVALUATION`.
    height : int
        Rows, 128 or more, so that all lights are visible; the map is twice as wide.

    Returns
    -------
    SyntheticMap

    Examples
    --------
    >>> plain(3, height=128).note
    'pair, pole, window before white wall; linear, x 4.14, 0 % noise'
    """
    height = count("height", height, least=_LEAST_HEIGHT, most=MOST_ROWS)
    rng = np.random.default_rng([count("seed", seed), 1])
    # Cycle through the backgrounds, which keeps every range of seeds balanced.
    name = _nth(_PLAIN_BACKDROPS, seed + seed // 10)
    background = _PLAIN_BACKDROPS[name](rng, height)
    # Draw the lights.
    shapes: list[Lamp] = []
    words: list[str] = []
    if seed % 10 != 9:
        first = _nth(lamps.PLAIN, seed)
        shapes, words = lamps.draw(rng, lamps.PLAIN, first, contrast=(8, 500), gap_deg=3)
    # Take the picture.
    camera, picture = _camera(rng, height, 0.02 * (name == "noise"), may_clip=_is_large(shapes))
    note = _note(words, name, picture)
    return scene(height, background=background, shapes=shapes, camera=camera, note=note)


def hard(seed: int, height: int = 512) -> SyntheticMap:
    """Map with distractors that look like lights.

    Glare around lights, bright walls and bright clouds are not lights. A window with bars is one
    light. Some maps have noise of 2 %. Every eighth map has clouds or bright walls and no light.

    Parameters
    ----------
    seed : int
        Number of the map; see `TUNING` and `EVALUATION`.
    height : int
        Rows, 128 or more, so that all lights are visible; the map is twice as wide.

    Returns
    -------
    SyntheticMap

    Examples
    --------
    >>> hard(3, height=128).note
    'sun, window before clouds; linear, x 1, 0 % noise'
    """
    height = count("height", height, least=_LEAST_HEIGHT, most=MOST_ROWS)
    rng = np.random.default_rng([count("seed", seed), 2])
    has_lights = seed % 8 != 7
    name = _nth(_HARD_BACKDROPS, seed) if has_lights else _CLUTTER[seed // 8 % 2]
    background = _HARD_BACKDROPS[name](rng, height)
    has_glare = has_lights and rng.random() < 0.4
    # Draw the lights, farther apart and brighter if there is glare.
    shapes: list[Lamp] = []
    words: list[str] = []
    if has_lights:
        kinds, least, gap_deg = (lamps.ROUND, 20, 12) if has_glare else (lamps.HARD, 10, 3)
        shapes, words = lamps.draw(rng, kinds, _nth(kinds, seed), (least, 300), gap_deg)
    if has_glare:
        clear, halos = background, backdrops.glare(rng, height, shapes)
        background = in_blocks(halos.shape, lambda rows: clear[rows] + halos[rows])
        name += ", glare"
    # Take the picture without clipping of glare, which would widen the lights.
    may_clip = _is_large(shapes) and not has_glare
    camera, picture = _camera(rng, height, 0.02 * (rng.random() < 0.6), may_clip)
    note = _note(words, name, picture)
    return scene(height, background=background, shapes=shapes, camera=camera, note=note)


def _nth(choices: Mapping[str, object], n: int) -> str:
    return list(choices)[n % len(choices)]


def _note(lights: list[str], backdrop: str, picture: str) -> str:
    return f"{', '.join(lights) or 'no light'} before {backdrop}; {picture}"


def _is_large(shapes: list[Lamp]) -> bool:
    """True if all lights survive clipping; one white pixel is not recognisable as a light."""
    return not any(isinstance(shape, PixelSun) for shape in shapes)


def _camera(
    rng: np.random.Generator, height: int, noise: float, may_clip: bool
) -> tuple[Camera, str]:
    """A camera, and a description of its pictures."""
    # Draw the kind of picture and its exposure.
    picture = rng.choice(["as is", "exposure", "clipped", "8 bit"], p=[0.3, 0.3, 0.2, 0.2])
    is_clipped = may_clip and picture in ("clipped", "8 bit")
    exposure = 1.0
    if picture == "exposure":
        exposure = 10 ** rng.uniform(-3, 3)
    elif is_clipped:
        exposure = 10 ** rng.uniform(np.log10(0.05), np.log10(0.4))
    # Draw the noise. Grain is proportional to the radiance. Hum is constant: a tenth of the grain
    # on the brightest surroundings, whose luminance is 1, and the larger of the two in the dark.
    size = 2, height, 2 * height, 3
    normal = normal_numbers(rng, size) if noise else np.broadcast_to(0.0, size)

    def round_trip(radiance: NDArray[np.float64], rows: slice) -> NDArray[np.float64]:
        grain, hum = noise * normal[:, rows]
        values = np.maximum(exposure * ((1 + grain) * radiance[rows] + 0.1 * hum), 0)
        if is_clipped:
            values = np.minimum(values, 1)
        return _eight_bits(values) if is_clipped and picture == "8 bit" else values

    def camera(radiance: NDArray[np.float64]) -> NDArray[np.float64]:
        return in_blocks(radiance.shape, lambda rows: round_trip(radiance, rows))

    words = [picture if is_clipped else "linear", f"x {exposure:.3g}", f"{100 * noise:g} % noise"]
    return camera, ", ".join(words)


def _eight_bits(radiance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Radiance up to 1 after rounding to 8 bits of sRGB."""
    levels = decode_srgb(np.arange(256) / 255)
    between = decode_srgb((np.arange(255) + 0.5) / 255)
    nearest: NDArray[np.float64] = levels[np.searchsorted(between, radiance)].astype(np.float64)
    return nearest
