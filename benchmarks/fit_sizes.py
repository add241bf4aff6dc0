"""A ball and a box on a floor, rendered by Mitsuba: the gain of lights with a size.

The truth is the image under the map itself, from eight sides. Each rig is that of `fit` without
sizes, or with sizes for an objective. For each the table has the error of the probe, the error with
shadows, that of the image, and the noise of the latter, all relative RMS. Last come the geometric
means of the ratios to the points of as many lights, and the rank correlation of the error with
shadows and that of the image.

Some four minutes for each map on two cores. Usage: python benchmarks/fit_sizes.py MAP...
"""

import sys
from pathlib import Path

import numpy as np
from ball_and_box import from_all_sides
from scipy.stats import spearmanr

import envlights as el

#: Paths through each pixel for each light. Rendering twice takes their noise out, so that few do.
PATHS = 32
#: Number of lights, and the objectives of the sizes; none for points.
RIGS = {4: (None, "shadows", "mixed"), 8: (None, "shadows", "mixed"), 16: (None,)}


def table(paths):
    columns = f"{'probe':>10}{'shadows':>10}{'image':>10}{'noise':>8}"
    print(f"{'map':<28}{'noise':>8}{'lights':>8} {'sizes':<8}{columns}")
    figures = {}
    for path in paths:
        env = el.EnvMap.open(path)
        truth = from_all_sides(env, PATHS)
        for lights, objectives in RIGS.items():
            for objective in objectives:
                options = {"objective": objective} if objective else {"sizes": False}
                rig = el.fit(env, lights, **options)
                seen = from_all_sides(rig, PATHS)
                figure = rig.error, rig.report.shadow_error, seen.error(truth), seen.noise
                figures[path.stem, lights, objective] = figure
                shown = "".join(f"{100 * value:>8.2f} %" for value in figure[:3])
                print(
                    f"{path.stem:<28}{100 * truth.noise:>6.2f} %{lights:>8}"
                    f" {objective or 'none':<8}{shown}{100 * figure[3]:>6.2f} %",
                    flush=True,
                )
    summary(figures)


def summary(figures):
    print(f"\n{'ratio to points':<16}{'probe':>16}{'shadows':>16}{'image':>16}   (mean, worst)")
    for lights, objectives in RIGS.items():
        for objective in filter(None, objectives):
            ratios = np.array(
                [
                    np.divide(figure, figures[name, lights, None])[:3]
                    for (name, count, other), figure in figures.items()
                    if (count, other) == (lights, objective)
                ]
            )
            means = zip(np.exp(np.log(ratios).mean(axis=0)), ratios.max(axis=0), strict=True)
            shown = "".join(f"{mean:>8.2f}{worst:>8.2f}" for mean, worst in means)
            print(f"{lights:>3} {objective:<12}{shown}")
    _, shadows, image, _ = np.transpose(list(figures.values()))
    print(f"rank correlation of shadows and image: {spearmanr(shadows, image).statistic:.3f}")


if __name__ == "__main__":
    table([Path(argument) for argument in sys.argv[1:]])
