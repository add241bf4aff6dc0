"""Error on rough metal by number of lights, and the lights needed for an error: docs/lab/fit.md.

The first table has the geometric mean over the maps and the worst map. The second has the fewest
lights for each error on metal of roughness 0.33, of at most 32.

Some 10 to 60 seconds for each map on two cores. Usage: python benchmarks/gloss.py MAP...
"""

import sys
from pathlib import Path

import numpy as np

import envlights as el

LIGHTS = (4, 8, 16)
ROUGHNESS = (0.33, 0.5)
GOALS = (0.2, 0.1, 0.05)


def fewest_lights(env, goal):
    """Fewest lights for an error, or a remark."""
    rig = el.fit(env, gloss_error=goal)
    missed = rig.report.stop_reason is el.rigs.StopReason.ERROR_NOT_REACHED
    return f"> 32 ({100 * rig.report.gloss_error():.0f} %)" if missed else str(len(rig.lights))


def table(paths):
    figures = []
    heads = [f"{lights} at {roughness}" for roughness in ROUGHNESS for lights in LIGHTS]
    goals = [f"for {goal:.0%}" for goal in GOALS]
    print(f"| map | {' | '.join([*heads, *goals])} |\n|{'---|' * (len(heads) + len(goals) + 1)}")
    for path in paths:
        env = el.EnvMap.open(path)
        reports = [el.fit(env, lights).report for lights in LIGHTS]
        errors = [report.gloss_error(each) for each in ROUGHNESS for report in reports]
        figures.append(errors)
        cells = [f"{100 * error:.1f} %" for error in errors] + [
            fewest_lights(env, goal) for goal in GOALS
        ]
        print(f"| {path.stem} | {' | '.join(cells)} |", flush=True)
    for name, values in (
        ("geometric mean", np.exp(np.log(figures).mean(axis=0))),
        ("worst", np.max(figures, axis=0)),
    ):
        print(f"| {name} | {' | '.join(f'{100 * value:.1f} %' for value in values)} |  |  |  |")


if __name__ == "__main__":
    table([Path(argument) for argument in sys.argv[1:]])
