"""Price tags: the gain of each rule and search step over the method without it.

Usage: python benchmarks/prices.py [detect] [fit] [--every N]

`detect` switches one rule of detection off at a time. It prints F1 on three synthetic families,
and for real maps (with `ENVLIGHTS_MAPS` set) how many of them get other lights and how many lights
with more than 1 % of the flux are lost.

`fit` compares the search with forward selection and eight plain starts, for points: the error of
`fit` over that of the plain search (geometric mean, best and worst map) and the processor time.
"""

import argparse
import sys
from pathlib import Path
from time import process_time

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

import probes
from answers import FLOOR, detected_row, pairs_of_lights

import envlights as el
from envlights import _native, synthetic
from envlights.fitting import ambient_terms, map_fit
from envlights.fitting.reduction import reduction_of
from envlights.fitting.request import FitOptions

#: Rules of detection, each with the option that switches it off.
RULES = {
    "joining of panes behind bars": {"gap_deg": 0},
    "saddles between lights": {"prominence": 1},
    "peaks well above the threshold": {"rise": 1},
    "dropping of weak lights": {"min_worth": 0},
    "extent of a light": {"extent": 0},
}
FAMILIES = {"plain": synthetic.plain, "hard": synthetic.hard, "openings": synthetic.openings}
#: Numbers of lights, and ambient terms, of the fits.
LIGHTS = (4, 8)
AMBIENTS = ("constant", "none", "sh2")


def detection_prices(every):
    worlds = {
        name: [make(seed) for seed in synthetic.JUDGING[::every]] for name, make in FAMILIES.items()
    }
    maps = [el.EnvMap.open(path) for path in probes.paths()[::every]]
    whole = [detected_row(el.detect(env)) for env in maps]
    print(f"{'without':<34}" + "".join(f"{name:>10}" for name in worlds) + "   real maps")
    for rule, options in {"(nothing)": {}, **RULES}.items():
        scores = (f1(family, options) for family in worlds.values())
        print(f"{rule:<34}" + "".join(f"{score:>10.3f}" for score in scores), end="   ")
        print(changes(whole, [detected_row(el.detect(env, **options)) for env in maps]))


def f1(family, options):
    found = [el.detect(world.radiance, **options) for world in family]
    results = [
        (world, lights.direction, lights.flux) for world, lights in zip(family, found, strict=True)
    ]
    return synthetic.judge(results).f1


def changes(whole, reduced):
    """Real maps whose lights change, and lights that are lost."""
    pairs = list(zip(whole, reduced, strict=True))
    other = sum(one["direction"] != two["direction"] for one, two in pairs)
    lost = sum(match is None for one, two in pairs for _, match in pairs_of_lights(one, two))
    return f"{other} of {len(pairs)} change, {lost} lights lost"


def fit_prices(every):
    maps = list(probes.maps().values())[::every]
    print(f"{'search':<20}{'error: mean':>13}{'best':>8}{'worst':>8}{'time':>8}")
    for ambient in AMBIENTS:
        for lights in LIGHTS:
            full, full_time = fits(maps, lights, ambient, is_plain=False)
            plain, plain_time = fits(maps, lights, ambient, is_plain=True)
            ratios = np.maximum(full, FLOOR) / np.maximum(plain, FLOOR)
            mean = np.exp(np.log(ratios).mean())
            figures = f"{mean:>13.4f}{ratios.min():>8.3f}{ratios.max():>8.3f}"
            print(f"{f'{lights}, {ambient}':<20}{figures}{full_time / plain_time:>8.2f}")


def fits(maps, lights, ambient, is_plain):
    """Errors of the fits, and their processor time together."""
    nowhere = np.zeros((0, 3))
    options = FitOptions(
        ambient_terms.AMBIENTS[ambient],
        nowhere,
        0,
        lights,
        error_floor=map_fit.RENDERING_ERROR,
        is_plain=is_plain,
    )
    start = process_time()
    errors = [
        _native.fit_reduced(reduction_of(env, floor=False).cells, options, [lights])[0].error
        for env in maps
    ]
    return np.array(errors), process_time() - start


def main():
    parts = {"detect": detection_prices, "fit": fit_prices}
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", default=list(parts))
    parser.add_argument("--every", type=int, default=1, help="every N-th map alone")
    options = parser.parse_args()
    for part in options.parts:
        parts[part](options.every)


if __name__ == "__main__":
    main()
