"""Rigs over sequences: identities, steadiness, error and cost against a full fit of each frame.

Usage: python benchmarks/follow.py [--frames N] [--steadiness N] [MAP ...]

The maps turn by 0.5 degrees in a frame, at 512 columns. The other sequences are generated.

- lights: identities over all frames, and the largest number in a frame.
- flicker: `RigSequence.flicker`; of full fits with matched lights in brackets.
- jump: largest motion above the true one from frame to frame, in degrees, of lights with at least a
  tenth of the flux, and of all lights.
- error: mean error, and over that of a full fit to each frame; of the continued fits in brackets.
- time: that of all rigs over that of full fits to each frame, without the reading of maps; then the
  median time of a rig over that of a full fit, which leaves out the frames with a search.
- searches: full searches whose lights were taken.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from tests.helpers import angle_deg
from tests.sequence import shows

import envlights as el
from envlights.sequence.identity import Identities


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("maps", nargs="*", metavar="MAP")
    parser.add_argument("--frames", type=int, default=200)
    parser.add_argument("--steadiness", type=int, default=3)
    options = parser.parse_args()
    print(
        f"{'':<28}{'lights':>8}{'flicker':>20}{'jump':>15}{'error':>25}{'time':>12}  searches",
        flush=True,
    )
    for name, maps, fit, true_motion in sequences(options.maps, options.frames):
        row(name, list(maps), fit, true_motion, options.steadiness)


def sequences(paths, frames):
    """Name, maps, options of a fit, and true motion in degrees of a light by its direction."""
    four, two = {"lights": 4}, {"lights": 2}
    for path in paths:
        env = el.EnvMap.open(path).resized(512)
        yield Path(path).stem, shows.turning(env, frames), four, turn
    yield "a sun rises through clouds", shows.sun_through_clouds(frames), four, rise
    # With 2 lights, the second one would halve the lamp that burns alone.
    yield "a lamp switched on and off", shows.switch(60, 20, 40), {"error": 0.01}, rest
    yield "two lamps cross", shows.crossing(80, height=256), two, cross
    yield "1 % noise of the exposure", shows.exposure_noise(60), two, rest


def turn(direction):
    return 0.5 * np.hypot(direction[..., 0], direction[..., 2])


def cross(direction):
    return np.hypot(direction[..., 0], direction[..., 2])


def rest(direction):
    return np.zeros(direction.shape[:-1])


def rise(direction):
    """Motion of the sun; the sky rests."""
    sun = angle_deg(shows.towards(20, 15), shows.towards(20.05, 15.1))
    return np.full(direction.shape[:-1], sun)


def row(name, maps, fit, true_motion, steadiness):
    """Measure and print one sequence."""
    el.fit(maps[0], **fit)  # fills the tables that fits share
    full, full_seconds = seconds_of(el.fit(env, **fit) for env in maps)
    options = {"lights": None, "steadiness": steadiness, **fit}
    rigs, seconds = seconds_of(el.follow(maps, **options))
    rigs = el.sequence.RigSequence(rigs)
    error = np.mean([rig.error for rig in full])
    jump = rigs.motion_deg - true_motion(rigs.direction[:-1])
    flux = np.minimum(rigs.flux[1:], rigs.flux[:-1])
    is_strong = flux >= 0.1 * rigs.flux.sum(axis=1)[:-1, None]
    print(
        f"{name:<28}{len(rigs.ids):>4}, {max(len(rig.ids) for rig in rigs):>2}"
        f"{100 * rigs.flicker:>9.3f} % ({100 * flicker_alone(full):.3f} %)"
        f"{largest(jump[is_strong]):>7.2f}, {largest(jump):>5.2f}"
        f"{100 * rigs.error.mean():>8.3f} %"
        f"{rigs.error.mean() / error:>8.3f} ({rigs.fit_error.mean() / error:.3f})"
        f"{sum(seconds) / sum(full_seconds):>6.2f},"
        f"{np.median(seconds) / np.median(full_seconds):>5.2f}"
        f"  {sum(rig.is_search for rig in rigs)}",
        flush=True,
    )


def seconds_of(results):
    """All results of an iterator, and the seconds that each took."""
    found, seconds, start = [], [], time.perf_counter()
    for result in results:
        found.append(result)
        seconds.append(time.perf_counter() - start)
        start = time.perf_counter()
    return found, seconds


def flicker_alone(full):
    """Flicker of independent fits, whose lights are matched from frame to frame."""
    identities = Identities()
    rigs = [
        el.sequence.FrameRig(
            rig.ambient, rig.lights, 0.0, frame=k, ids=identities.follow(rig.lights)
        )
        for k, rig in enumerate(full)
    ]
    return el.sequence.RigSequence(rigs).flicker


def largest(values):
    return np.nanmax(values, initial=0.0)


if __name__ == "__main__":
    main()
