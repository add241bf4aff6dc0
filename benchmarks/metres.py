"""Errors of lights in metres, for docs/lab/metres.md: rooms, bad depths, two maps, run time."""

import time

import numpy as np
from scipy.ndimage import gaussian_filter
from tests.placing.rooms import OFFSETS, room, seen

import envlights as el
from envlights import kernels

NORMALS, WEIGHTS = kernels.icosphere(320)
POINTS = np.array([(0, 0, 0), *OFFSETS])
#: Points at each distance.
GROUPS = ([0], [1, 2], [3, 4], [5, 6])
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
    """Distance of each light to the nearest lamp, relative to its own, in percent."""
    lamps = np.array([lamp.centre for lamp in room(kind).lamps])
    near = [each for each in placed if each.kind != "sun"]
    return [
        100 * np.linalg.norm(lamps - light.position, axis=1).min() / light.distance
        for light in near
    ]


def of_depths(kind, split, depth, truth):
    """Print the errors for each kind of depth."""
    cases = {
        "exact": [{"depth": depth}],
        "smooth noise": [{"depth": noisy(depth, seed, 14)} for seed in range(4)],
        "noise of pixels": [{"depth": noisy(depth, 1, 0)}],
        "scale 1.05": [{"depth": depth, "scale": 1.05}],
        "room": [{"room": (6, 3, 5)}],
    }
    for name, options in cases.items():
        placed = [el.place(split, **each) for each in options]
        rows = [errors_of(each.irradiance(POINTS, NORMALS), truth) for each in placed]
        moved = [error for each in placed for error in position_errors(each, kind)]
        print(f"{kind:11s} {name:16s}", np.mean(rows, axis=0).round(2), end=" ")
        print(f"positions RMS {np.sqrt(np.mean(np.square(moved))):.2f}, most {max(moved):.2f}")
    return el.place(split, depth)


def main():
    """Print all figures."""
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
