"""Errors of indirect light on unseen lights, by the number of pairs.

Relative errors of the images in percent: median, 90th percentile and worst. "reported" is the
median of the errors for new lights that the model itself reports. "fit" is the time of the fit, and
its ratio to that of the default. The rank is 128, and the ridge is the default of each method. The
room has 64x64 texels, and 256 of its lights are unseen. The pairs of the folder in
`ENVLIGHTS_TRANSFER_DB`, if any, are path-traced; all but 48 are unseen, and "means" are those of
4x4 texels, which have less noise.
"""

import os
from functools import partial

import numpy as np
from curves.results import run_times, typical
from tests.helpers import relative_errors

import envlights as el

TITLE = "Indirect light by the number of pairs"
RANK = 128
METHODS = {"default": {}, "nonnegative=True": {"nonnegative": True}}


def rows(_, effort):
    """Yield a row for each scene, number of pairs and method."""
    for scene, counts, first, direct, indirect in data(effort.is_quick):
        for count in counts:
            known = direct[:count], indirect[:count]
            fits = {
                name: partial(el.TransferModel.fit, *known, RANK, **options)
                for name, options in METHODS.items()
            }
            found = run_times(fits, effort)
            seconds = {name: typical([each]) for name, each in found.items()}
            for name, fit in fits.items():
                model = fit()
                errors = relative_errors(model.predict(direct[first:]), indirect[first:])
                yield {
                    "scene": scene,
                    "pairs": count,
                    "method": name,
                    **dict(zip(("median", "90th", "worst"), percentiles(errors), strict=True)),
                    "reported": f"{100 * model.report.error:.1f} %",
                    "fit": f"{1e3 * seconds[name]:.3g} ms",
                    "ratio": f"{seconds[name] / seconds['default']:.1f}",
                }


def percentiles(errors):
    return [f"{100 * share:.1f} %" for share in (*np.percentile(errors, [50, 90]), errors.max())]


def data(is_quick):
    """Scenes: name, numbers of pairs, first unseen pair, and the images."""
    room = el.synthetic.room(48 if is_quick else 384, width=32 if is_quick else 64)
    yield "room", (16, 32) if is_quick else (32, 64, 128), 32 if is_quick else 128, *both(room)
    folder = os.environ.get("ENVLIGHTS_TRANSFER_DB")
    if folder and not is_quick:
        direct, indirect = both(el.read_pairs(folder))
        yield "database", (24, 48), 48, direct, indirect
        k, height, width, _ = indirect.shape
        means = indirect.reshape(k, height // 4, 4, width // 4, 4, 3).mean(axis=(2, 4))
        yield "database, means", (24, 48), 48, direct, means


def both(pairs):
    return [np.asarray(each, np.float32) for each in (pairs.direct, pairs.indirect)]
