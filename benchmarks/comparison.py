"""One pair of lightings under each choice of a comparison, and the time of a comparison.

Usage: python benchmarks/comparison.py [MAP] [--time]

The truth is MAP, or the synthetic hall; the guess is a rig of eight lights that was fitted to it,
drawn as a map of 256x128 pixels. docs/lab/compare.md has the tables.
"""

import argparse
from dataclasses import replace

from stopwatch import compare as compare_times

import envlights as el
from envlights.comparison import Camera, Material

EXACT, PUBLISHED = (el.comparison.Protocol.named(name) for name in ("exact", "stylelight"))


def choices():
    """Protocols by the choice that each makes differently from StyleLight's code."""
    bare = {**PUBLISHED.materials, "diffuse": Material(base=0.8)}
    return {
        "`exact`: linear, all sides, reflectance 1": EXACT,
        "as StyleLight": PUBLISHED,
        "mean over channels": replace(PUBLISHED, channels="mean"),
        "no coat on the diffuse ball": replace(PUBLISHED, materials=bare),
        "camera on the other side": replace(PUBLISHED, camera=Camera(position=(16, 2, 0))),
        "mirror of 64 pixels": replace(PUBLISHED, camera=Camera(size=64)),
        "from all sides": replace(PUBLISHED, camera=None),
        "no common median": replace(PUBLISHED, median=None),
        "linear, same camera": replace(PUBLISHED, gamma=None, median=None),
    }


def print_choices(truth, guess):
    names = ("diffuse", "matte", "mirror")
    print("| choice | RMSE diffuse, matte, mirror | si-RMSE | RGB angle |\n|---|---|---|---|")
    for choice, protocol in choices().items():
        errors = [el.compare(truth, guess, protocol).spheres[name] for name in names]
        cells = [
            ", ".join(f"{getattr(each, what):.3g}" for each in errors)
            for what in ("rmse", "si_rmse", "angle")
        ]
        print(f"| {choice} | {' | '.join(cells)}° |")


def print_gains(truth, guess):
    """Errors of a guess that is twice as bright."""
    print("\n| matte ball | RMSE | RMSE of a guess twice as bright |\n|---|---|---|")
    for name, protocol in (("exact", EXACT), ("stylelight", PUBLISHED)):
        pair = [el.compare(truth, gain * guess.radiance, protocol) for gain in (1, 2)]
        rmse = " | ".join(f"{each.spheres['matte'].rmse:.3g}" for each in pair)
        print(f"| `{name}` | {rmse} |")


def print_times(truth, guess):
    normals, _ = el.kernels.icosphere(5120)
    work = {"exact, with lights and angles": lambda: el.compare(truth, guess)}
    work["probe of both maps at 5120 normals"] = lambda: [
        env.probe(normals) for env in (truth, guess)
    ]
    work["detect both"] = lambda: [el.detect(env) for env in (truth, guess)]
    work["stylelight"] = lambda: el.compare(truth, guess, PUBLISHED)
    compare_times("time of a pair", work, rounds=15)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("map", nargs="?", help="map; the synthetic hall when left out")
    parser.add_argument("--time", action="store_true", help="measure times as well")
    options = parser.parse_args()
    env = el.EnvMap(el.synthetic.hall(128).radiance)
    truth = env if options.map is None else el.EnvMap.open(options.map).resized(256)
    rig = el.fit(truth, lights=8)
    guess = rig.to_map(128)
    print_choices(truth, guess)
    print_gains(truth, guess)
    drawn, exact = el.compare(truth, guess), el.compare(truth, rig)
    print(f"\nprobe error: report {rig.error:.4%}, compare {exact.probe_error:.4%},")
    print(f"drawn as pixels {drawn.probe_error:.4%}")
    if options.time:
        print_times(truth, guess)


if __name__ == "__main__":
    main()
