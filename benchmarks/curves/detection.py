"""Detection of lights in generated maps with known lights: run time against missed lights.

The settings of `tree` and `article` are working widths. Two families of maps are measured as
radiance and as 8-bit sRGB pictures with 1 % of the sphere clipped. For the pictures the peers read
the decoded radiance, and the error of flux includes the clipped light. Angle and flux are medians
over the detected lights. Each family has eight maps of 1024x512 pixels; two are timed.
"""

from functools import partial

import numpy as np
from curves.results import point, run_times, those_installed
from detectors import DETECTORS, ours, sphere

import envlights as el
from envlights import synthetic
from envlights._common.srgb import encode_srgb
from envlights.kernels.image import LUMINANCE

TITLE = "Detection"
READ = ": left is faster, down is more accurate"
ERRORS = {"missed": "1 - F1", "angle": "angle of detected lights, radians", "flux": "error of flux"}
COUNTED = None
OURS = ("tree", "article")
COLUMNS = (128, 256, 512, 1024)
PEERS = (
    "threshold + components",
    "threshold + OpenCV",
    "Otsu + components",
    "median cut",
)
#: Maps of each family, and of a quick run; those that are timed.
MAPS, FEW_MAPS, TIMED_MAPS = 8, 1, 2
#: Share of the sphere that is white in an 8-bit picture.
CLIPPED = 0.01

METHODS = {
    "tree": [(columns, ours(working_width=columns)) for columns in COLUMNS],
    "article": [
        (columns, ours(el.papers.loghin.detect, working_width=columns)) for columns in (256, 1024)
    ],
    **{name: [(None, DETECTORS[name])] for name in PEERS},
}
METHODS = those_installed(METHODS, {"threshold + OpenCV": "cv2"})


def are_comparable(our, their):
    """True for every pair of settings, because a setting guarantees nothing."""
    return our.case == their.case


def points(_, effort):
    """Yield a point for each family, method and setting."""
    count = FEW_MAPS if effort.is_quick else MAPS if effort.is_judged else TIMED_MAPS
    seeds = synthetic.EVALUATION[:count]
    for make in (synthetic.plain, synthetic.hard):
        worlds = [make(seed) for seed in seeds]
        yield from _on(make.__name__, worlds, [world.radiance for world in worlds], 1.0, effort)
        coded, whites = zip(*(_eight_bits(world.radiance) for world in worlds), strict=True)
        yield from _on(f"{make.__name__}, 8 bits", worlds, coded, whites, effort)


def _on(case, worlds, images, whites, effort):
    """Points of one family; `whites` has the clip level of each image."""
    decoded = [el.EnvMap(image).radiance for image in images]
    methods = {
        (method, setting): (find, images if method in OURS else decoded)
        for method, settings in METHODS.items()
        for setting, find in settings
    }
    whites, errors = np.broadcast_to(whites, len(worlds)), {}
    for key, (find, seen) in methods.items():
        rows = zip(worlds, _all(find, seen), whites, strict=True)
        score = synthetic.evaluate(
            [(w, towards, flux * white) for w, (towards, flux), white in rows]
        )
        errors[key] = _errors(score)
    few = images[:TIMED_MAPS]
    seconds = run_times(
        {key: partial(_all, find, seen[:TIMED_MAPS]) for key, (find, seen) in methods.items()},
        effort,
    )
    for key in methods:
        each = [time / len(few) for time in seconds[key]]
        yield point("detection", case, *key, errors[key], call=[each])


def _all(find, images):
    return [find(image) for image in images]


def _eight_bits(radiance):
    """The map as 8-bit sRGB codes, and the radiance that is white in them."""
    luminance = radiance @ LUMINANCE
    _, solid_angles = sphere(*luminance.shape)
    white = np.quantile(luminance, 1 - CLIPPED, weights=solid_angles, method="inverted_cdf")
    return np.round(255 * encode_srgb(radiance / white)).astype(np.uint8), float(white)


def _errors(score):
    """Errors of the detected lights; 1 if no light was detected."""
    hit = len(score.angles_deg) > 0
    return {
        "missed": max(1 - score.f1, 1e-3),
        "angle": float(np.deg2rad(np.median(score.angles_deg))) if hit else np.pi,
        "flux": float(np.median(np.abs(score.flux_errors))) if hit else 1.0,
    }
