"""A ball and a box on a floor, rendered by Mitsuba: what a fit gains that knows of the floor.

The truth is the image under the map itself: shadows and one bounce, from two views, the scene
turned four times. `worst` is the ratio of the worst turn. `noise` is that of the mean of the two
images, relative RMS. Lights are points: what is compared is where they stand.

Some minutes. Usage: python benchmarks/fit_floor.py MAP...
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from ball_and_box import TURNS, error, under_ambient, under_map, under_rig
from tests.reference.mitsuba_images import noise_of

import envlights as el

LIGHTS = (4, 8)


def table(paths):
    under_one = under_ambient()
    print("relative RMS error of images, fitted without a floor and over one")
    columns = f"{'without':>10}{'over':>10}{'ratio':>8}{'worst':>8}{'noise':>8}"
    print(f"{'map':<28}{'noise':>8}{'lights':>8}{columns}")
    for path in paths:
        env = el.EnvMap.open(path)
        truth = under_map(env)
        for lights in LIGHTS:
            plain, over = (
                under_rig(el.fit(env, lights, floor=floor, sizes=False), under_one)
                for floor in (False, True)
            )
            print(row(path.stem, lights, truth, plain, over), flush=True)


def row(name, lights, truth, plain, over):
    without, with_floor = error(plain, truth), error(over, truth)
    by_turn = [
        error(over[:, k], truth[:, k]) / error(plain[:, k], truth[:, k]) for k in range(len(TURNS))
    ]
    return (
        f"{name:<28}{100 * noise_of(*truth):>6.2f} %{lights:>8}"
        f"{100 * without:>8.2f} %{100 * with_floor:>8.2f} %{with_floor / without:>8.3f}"
        f"{max(by_turn):>8.3f}{100 * noise_of(*over):>6.2f} %"
    )


if __name__ == "__main__":
    table([Path(argument) for argument in sys.argv[1:]])
