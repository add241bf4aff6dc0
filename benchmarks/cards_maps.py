"""Cards of real maps: closing, time a light, shapes: `python benchmarks/cards_maps.py MAP...`."""

import sys
import time

import numpy as np

import envlights as el
from envlights.kernels.image import LUMINANCE

#: Runs; the fastest counts.
RUNS = 2


def fastest(work):
    """Least seconds of the runs, and the last result."""
    seconds = []
    for _ in range(RUNS):
        start = time.perf_counter()
        result = work()
        seconds.append(time.perf_counter() - start)
    return min(seconds), result


def closing(env, cards, rest):
    """Relative RMS difference of the irradiance under rest and cards, and under the map."""
    normals, _ = el.kernels.icosphere(1280)
    parts, whole = cards.to_map(env.width).probe(normals) + rest.probe(normals), env.probe(normals)
    return np.linalg.norm(parts - whole) / np.linalg.norm(whole)


def shares(cards):
    """Fraction of the irradiance of all cards, by shape."""
    light = cards.irradiance @ LUMINANCE
    names = np.array(cards.shape)
    return {name: light[names == name].sum() / light.sum() for name in dict.fromkeys(cards.shape)}


def main(paths):
    """Print a row for each map."""
    for path in paths:
        env = el.EnvMap.open(path)
        plain, _ = fastest(lambda env=env: el.split(env))
        seconds, (cards, rest) = fastest(lambda env=env: el.split(env, shapes=True))
        named = ", ".join(f"{name} {100 * share:.1f} %" for name, share in shares(cards).items())
        print(
            f"{path}: {len(cards)} cards, closing {100 * closing(env, cards, rest):.4f} %,"
            f" {1e3 * (seconds - plain) / max(len(cards), 1):.1f} ms a light; {named}"
        )


if __name__ == "__main__":
    main(sys.argv[1:])
