"""Errors of lights in metres, for docs/lab/metres.md: rooms, bad depths, two maps, run time.

Rooms are in closed form, without indirect light. With folders as arguments, the truth is that of
path-traced maps: files KIND.npz of the rooms with `map0` and `depth0` at the camera, 512 x 256,
and `map1` to `map6` at `OFFSETS`.
"""

import sys
import time
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter
from tests.placing.rooms import OFFSETS, room, seen

import envlights as el
from envlights import kernels
from envlights.placing.depth import box_distance

NORMALS, WEIGHTS = kernels.icosphere(320)
POINTS = np.array([(0, 0, 0), *OFFSETS])
#: Points at each distance.
GROUPS = ([0], [1, 2], [3, 4], [5, 6])
#: Corner of the rooms, whose camera is in the middle.
CORNER = np.array([3, 1.5, 2.5])
ROOMS = ("pendants", "panel", "downlights", "hole", "furnished")


def noisy(depth, seed, width):
    """Depth with 5 % of noise, smooth over some pixels."""
    wave = np.random.default_rng(seed).standard_normal(depth.shape)
    if width:
        wave = gaussian_filter(wave, width, mode=("nearest", "wrap"))
    return depth * np.exp(0.05 * wave / wave.std())


def errors_of(irradiance, truth):
    """Relative RMS error at each distance, in percent."""
    each = [kernels.relative_rms(*pair, WEIGHTS) for pair in zip(irradiance, truth, strict=True)]
    return [100 * np.mean(np.take(each, group)) for group in GROUPS]


def position_errors(placed, kind):
    """Distance of each light to the lamp in its direction, relative to its own, in percent.

    Spots of bright ceiling, in whose direction there is no lamp, are left out.
    """
    lamps = np.array([lamp.centre for lamp in room(kind).lamps])
    towards = lamps / np.linalg.norm(lamps, axis=1)[:, None]
    return [
        100 * np.linalg.norm(lamps - light.position, axis=1).min() / light.distance
        for light in placed
        if light.kind != "sun" and (towards @ light.direction).max() > np.cos(0.1)
    ]


def of_depths(kind, split, depth, truth):
    """Print the errors for each kind of depth."""
    cases = {
        "exact": [{"depth": depth}],
        "smooth noise": [{"depth": noisy(depth, seed, 14)} for seed in range(4)],
        "noise of pixels": [{"depth": noisy(depth, 1, 0)}],
        "scale 1.05": [{"depth": depth, "scale": 1.05}],
        "box alone": [{"depth": box_distance((-CORNER, CORNER), 256), "reading": "ray"}],
        "box and shading": [{"room": 2 * CORNER}],
    }
    for name, options in cases.items():
        placed = [el.place(split, **each) for each in options]
        rows = [errors_of(each.irradiance(POINTS, NORMALS), truth) for each in placed]
        moved = [error for each in placed for error in position_errors(each, kind)]
        print(f"{kind:11s} {name:16s}", np.mean(rows, axis=0).round(2), end=" ")
        print(f"positions RMS {np.sqrt(np.mean(np.square(moved))):.2f}, most {max(moved):.2f}")
    return el.place(split, depth)


def of_traced_rooms(folder):
    """Print the errors in rooms that a renderer has traced."""
    for kind in ROOMS:
        with np.load(folder / f"{kind}.npz") as arrays:
            maps = [arrays[f"map{number}"] for number in range(7)]
            depth = without_window(arrays["depth0"], kind)
        truth = [el.EnvMap(each).probe(NORMALS) for each in maps]
        split = el.split(maps[0], shapes=True)
        received = of_depths(kind, split, depth, truth).irradiance(POINTS[:1], NORMALS)[0]
        print(" at infinity", np.round(errors_of([received] * 7, truth), 2))
        for number, point in enumerate(OFFSETS[2:], 3):
            other = el.place([(split, (0, 0, 0)), (maps[number], point)])
            print(" two maps", point, np.round(position_errors(other, kind), 2), f"of {len(other)}")


def without_window(depth, kind):
    """Depth that is unknown in a window, as behind glass."""
    rays = kernels.pixel_directions(*depth.shape)
    for lamp in room(kind).lamps:
        if getattr(lamp, "is_window", False):
            depth = np.where(np.isfinite(lamp.hit(np.zeros(3), rays)), np.inf, depth)
    return depth


def main():
    """Print all figures."""
    for folder in map(Path, sys.argv[1:]):
        of_traced_rooms(folder)
    if sys.argv[1:]:
        return
    for kind in ROOMS:
        radiance, depth = seen(kind)
        start = time.process_time()
        split = el.split(radiance, shapes=True)
        middle = time.process_time()
        el.place(split, depth)
        seconds = middle - start, time.process_time() - middle
        truth = [room(kind).probe(point, NORMALS) for point in POINTS]
        placed = of_depths(kind, split, depth, truth)
        received = placed.irradiance(POINTS, NORMALS)
        print(" at infinity", np.round(errors_of([received[0]] * 7, truth), 2))
        rigs = [placed.at(point) for point in POINTS]
        print(
            " rigs",
            [f"{100 * each.error:.2f}" for each in rigs],
            [len(each.lights) for each in rigs],
        )
        maps = [placed.map_at(point).probe(NORMALS) for point in POINTS]
        print(" maps", np.round(errors_of(maps, truth), 2))
        for point in OFFSETS[2:]:
            other = el.place([(split, (0, 0, 0)), (room(kind).panorama(256, point)[0], point)])
            print(" two maps", point, np.round(position_errors(other, kind), 2), f"of {len(other)}")
        many = np.random.default_rng(0).uniform(-1, 1, (1000, 3))
        start, clock = time.process_time(), time.perf_counter()
        placed.irradiance(many, NORMALS)
        seconds = (*seconds, time.process_time() - start, time.perf_counter() - clock)
        print(
            " seconds: split {:.2f}, place {:.2f}, irradiance {:.2f}, clock {:.2f}".format(*seconds)
        )


if __name__ == "__main__":
    main()
