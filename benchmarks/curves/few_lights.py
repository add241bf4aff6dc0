"""A few lights for a map: run time against the error of a white probe and of its shadows.

Each method starts with the map in memory, float32, and ends with its lights. The settings are
numbers of lights, orders of harmonics, and for Radiance's `mksource` its threshold over the mean.
The time of `mksource` includes its files; it is random, and its errors are medians of three. A peer
is called better only if it has no more lights than ours; harmonics and `mksource` always count.
"""

from functools import partial

import numpy as np
from curves import peers_of_lights as peers
from curves.errors_of_rigs import Evaluation
from curves.results import point, run_times, those_installed, warm_up

import envlights as el

TITLE = "Few lights for a map"
READ = ": left is faster, down is more accurate"
ERRORS = {"probe": "error of a white probe", "shadows": "error of shadows"}
#: What the settings count, and whose settings count something else.
COUNTED, UNCOUNTED = "lights", ("harmonics, projected", "mksource")
#: Calls of a method that draws anew at each, whose errors are medians.
DRAWS, DRAWN = 3, ("mksource",)
FEW = (1, 2, 4, 8, 16)
MANY = (4, 16, 64, 256)


def ours(radiance, lights, **options):
    return el.fit(radiance, lights=lights, **options)


OURS = ("fit", "fit, points", "fit, harmonics")

#: By name: numbers of lights, and what finds them.
NEEDS = {"k-means": "sklearn", "JAXopt": "jaxopt", "mksource": "pyradiance"}
METHODS = {
    "fit": (FEW, ours),
    "fit, points": (FEW, partial(ours, sizes=False)),
    "fit, harmonics": ((0, 1, 2, 4), partial(ours, ambient="sh2")),
    "median cut": (MANY, peers.median_cut),
    "variance cuts": (MANY, peers.variance_cuts),
    "k-means": (MANY, peers.k_means),
    "importance samples": (MANY, peers.importance_samples),
    "harmonics, projected": ((2, 4), peers.projected_harmonics),
    "SciPy, bounded": (FEW[:4], peers.by_scipy),
    "JAXopt": (FEW[:4], peers.by_jaxopt),
    "mksource": (peers.THRESHOLDS, peers.by_mksource),
}
METHODS = those_installed(METHODS, NEEDS)


def are_comparable(our, their):
    """True if the peer has no more lights than ours; harmonics and `mksource` always count."""
    return their.method in UNCOUNTED or their.setting <= our.setting


def points(maps, effort):
    """Yield a point for each map, method and number of lights."""
    return points_of("lights", METHODS, maps, effort)


def points_of(part, methods, maps, effort):
    """Yield a point of a part for each map, method and number of lights."""
    for name, env in maps.items():
        work = {
            (method, setting): partial(find, env.radiance, setting)
            for method, (settings, find) in methods.items()
            for setting in (settings[::2] if effort.is_quick else settings)
        }
        # The first call also compiles, where a method does.
        if effort.is_judged:
            errors = errors_of(env, work, effort.is_quick)
        else:
            errors = warm_up(work, env.radiance.shape)
        seconds = run_times(work, effort)
        for key in work:
            yield point(part, name, *key, errors[key], call=[seconds[key]])


def errors_of(env, work, is_quick):
    """Both errors of each method, the medians of those that draw anew."""
    evaluation, found = Evaluation(env), {}
    kinds = {"probe": evaluation.probe_error, "shadows": evaluation.shadow_error}
    for key, find in work.items():
        answers = [find() for _ in range(DRAWS if key[0] in DRAWN and not is_quick else 1)]
        errors = {name: [error(each) for each in answers] for name, error in kinds.items()}
        found[key] = {name: float(np.median(values)) for name, values in errors.items()}
    return found
