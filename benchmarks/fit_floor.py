"""A ball and a box on a floor, rendered by Mitsuba: the gain of `floor=True`.

The truth is the image under the map itself, from eight sides. `worst` is the ratio of the worst
side. `noise` is that of the mean of the two images, relative RMS. Lights are points: what is
compared is where they stand.

Some minutes. Usage: python benchmarks/fit_floor.py MAP...
"""

import sys
from pathlib import Path

from ball_and_box import AZIMUTHS, from_all_sides, of_side

import envlights as el

LIGHTS = (4, 8)


def table(paths):
    print("relative RMS error of images, fitted without a floor and over one")
    columns = f"{'without':>10}{'over':>10}{'ratio':>8}{'worst':>8}{'noise':>8}"
    print(f"{'map':<28}{'noise':>8}{'lights':>8}{columns}")
    for path in paths:
        env = el.EnvMap.open(path)
        truth = from_all_sides(env)
        for lights in LIGHTS:
            plain, over = (
                from_all_sides(el.fit(env, lights, floor=floor, sizes=False))
                for floor in (False, True)
            )
            print(row(path.stem, lights, truth, plain, over), flush=True)


def row(name, lights, truth, plain, over):
    without, with_floor = plain.error(truth), over.error(truth)
    by_side = []
    for side in range(len(AZIMUTHS)):
        one, two, seen = (of_side(stills, side) for stills in (over, plain, truth))
        by_side.append(one.error(seen) / two.error(seen))
    return (
        f"{name:<28}{100 * truth.noise:>6.2f} %{lights:>8}"
        f"{100 * without:>8.2f} %{100 * with_floor:>8.2f} %{with_floor / without:>8.3f}"
        f"{max(by_side):>8.3f}{100 * over.noise:>6.2f} %"
    )


if __name__ == "__main__":
    table([Path(argument) for argument in sys.argv[1:]])
