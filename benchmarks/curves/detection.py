"""Lights found in maps whose lights are known: run time against what was missed."""

from functools import partial

import numpy as np
from curves.results import Point, timed
from detectors import DETECTORS, ours

from envlights import synthetic

TITLE = "Detection"
READ = ": left is faster, down is more accurate"
ERRORS = {"missed": "1 - F1", "angle": "median angle of the hits, radians", "flux": "flux error"}
COUNTED = None
OURS = ("tree",)
COLUMNS = (128, 256, 512, 1024)
PEERS = ("article", "threshold + components", "Otsu + components", "median cut")
#: Maps of each family.
MAPS = 12

METHODS = {
    "tree": [(columns, ours(working_width=columns)) for columns in COLUMNS],
    **{name: [(0, DETECTORS[name])] for name in PEERS},
}


def are_comparable(our, their):
    """Every setting against every other: they are no promise to the user."""
    return our.case == their.case


def points(_, rounds):
    """Yield a point for each family, method and setting."""
    for make in (synthetic.plain, synthetic.hard):
        worlds = [make(seed) for seed in synthetic.JUDGING[:MAPS]]
        work = {
            (method, setting): partial(_all, find, worlds)
            for method, settings in METHODS.items()
            for setting, find in settings
        }
        found = {key: find() for key, find in work.items()}
        seconds = timed(work, rounds)
        for (method, setting), answers in found.items():
            typical, spread = seconds[method, setting]
            score = synthetic.judge([(w, *each) for w, each in zip(worlds, answers, strict=True)])
            yield Point(
                "detection", make.__name__, method, setting, typical / MAPS, spread, _errors(score)
            )


def _all(find, worlds):
    return [find(world.radiance) for world in worlds]


def _errors(score):
    hit = len(score.angles_deg) > 0
    return {
        "missed": max(1 - score.f1, 1e-3),
        "angle": float(np.deg2rad(np.median(score.angles_deg))) if hit else np.pi,
        "flux": float(np.median(score.flux_errors)) if hit else 1.0,
    }
