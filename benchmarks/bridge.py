"""From a rig to a lightmap of the courtyard: error and run time of each step.

Direct light against Mitsuba's at four times as many points; indirect light against a path-traced
lightmap, with the error that the model states and the noise of the render; on rigs of the open air
that were not learnt, and on rigs fitted to maps. Some minutes.
Usage: python benchmarks/bridge.py [FOLDER of maps]
"""

import sys
import time
from pathlib import Path

import numpy as np
from stopwatch import compare

sys.path.insert(0, str(Path(__file__).parents[1]))
from tests.reference.mitsuba_images import noise_of, relative, texels_by_mitsuba

import envlights as el

PAIRS, WIDTH, SAMPLES, RANK = 128, 32, 512, 32


def rigs_of_maps(folder):
    """Rigs fitted to the maps in `folder`, or to maps that the package makes itself."""
    if folder:
        maps = [el.EnvMap.open(path) for path in sorted(Path(folder).glob("*.[he][dx]r"))]
    else:
        maps = [el.EnvMap(el.synthetic.hard(seed, 128).radiance) for seed in range(8)]
    return [el.fit(env, lights=4) for env in maps]


def print_time(what, work):
    start = time.perf_counter()
    result = work()
    print(f"  {what:<52}{time.perf_counter() - start:>9.2f} s", flush=True)
    return result


def spread(values):
    return f"median{100 * np.median(values):>6.2f} %  worst{100 * np.max(values):>6.2f} %"


def direct(yard, fine, rigs):
    """Print the error of direct images, 8 by 8 points a texel, against Mitsuba's 16 by 16."""
    errors, noise = [], []
    for rig, images in zip(rigs, texels_by_mitsuba(fine.lightmap, rigs, depth=2), strict=True):
        one, two = (fine.lightmap.means(image, 16) for image in images)
        errors.append(relative(yard.direct(rig), (one + two) / 2))
        noise.append(noise_of(one, two))
    print(
        f"  direct image against Mitsuba's {spread(errors)}   its noise {spread(noise)}", flush=True
    )


def indirect(yard, model, rigs):
    """Print the error of predicted lightmaps against path-traced ones."""
    errors, noise = [], []
    for k, rig in enumerate(rigs):
        truth = yard.indirect(rig, 2 * SAMPLES, seed=1000 + k)
        errors.append(relative(model.predict(yard.direct(rig)), truth.image))
        noise.append(truth.noise)
    allowed = model.report.error + np.median(noise)
    print(f"  lightmap against path-traced   {spread(errors)}   its noise {spread(noise)}")
    print(
        f"  stated by the model{100 * model.report.error:>6.2f} %, with that noise"
        f"{100 * allowed:>6.2f} %: {'within' if np.median(errors) < allowed else 'NOT within'}",
        flush=True,
    )


if __name__ == "__main__":
    folder = sys.argv[1] if sys.argv[1:] else None
    learnt, new = el.synthetic.rigs(PAIRS), el.synthetic.rigs(12, seed=1)
    print(f"courtyard, lightmap {WIDTH}x{WIDTH}, {PAIRS} rigs, {SAMPLES} paths a texel")
    yard = print_time("scene", lambda: el.scene.MitsubaScene(el.synthetic.courtyard(), WIDTH))
    fine = el.scene.MitsubaScene(el.synthetic.courtyard(), 256)
    print_time("first direct image, with the sky", lambda: yard.direct(new[0]))
    pairs = print_time("pairs", lambda: el.bake(yard, learnt, SAMPLES))
    model = el.TransferModel.fit(pairs.direct, pairs.indirect, RANK, ridge="loo")
    print(f"noise of the pairs {spread(pairs.noise)}\n{model}")
    for name, rigs in (("rigs of the open air", new), ("rigs of maps", rigs_of_maps(folder))):
        print(f"\n{name}, {len(rigs)} that were not learnt")
        direct(yard, fine, rigs)
        indirect(yard, model, rigs)
    image = yard.direct(new[0])
    work = {
        f"path-traced lightmap, {SAMPLES} paths a texel": lambda: yard.indirect(new[0], SAMPLES),
        f"direct image of {len(new[0].lights)} lights": lambda: yard.direct(new[0]),
        "predicted lightmap": lambda: model.predict(image),
    }
    compare("a frame", work, rounds=5)
