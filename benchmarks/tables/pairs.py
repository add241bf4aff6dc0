"""Errors of indirect light on unseen lights, by the number of pairs.

Relative errors of the images in percent: median, 90th percentile and worst. "reported" is the
median of the errors for new lights that the model itself reports. "fit" is the time of the fit, and
its ratio to that of the default. The rank is 128, and the ridge is the default of each method. The
room has 64x64 texels, and 256 of its lights are unseen. The pairs of the folder in
`ENVLIGHTS_TRANSFER_DB`, if any, are path-traced; all but 48 are unseen, and "means" are those of
4x4 texels, which have less noise. `prior` knows the geometry of the scene from 256 rays a texel; at
0 pairs it predicts alone.
"""

import os
from functools import partial

import numpy as np
from curves.results import run_times, typical
from tests.helpers import relative_errors
from tests.reference.rooms import prior, room_prior

import envlights as el

TITLE = "Indirect light by the number of pairs"
RANK = 128
METHODS = {"default": {}, "nonnegative=True": {"nonnegative": True}}


def rows(_, effort):
    """Yield a row for each scene, number of pairs and method."""
    for scene, counts, first, direct, indirect, geometry in data(effort.is_quick):
        alone = geometry.predict(direct[first:])
        yield {
            "scene": scene,
            "pairs": 0,
            "method": "prior",
            **spread(relative_errors(alone, indirect[first:])),
            **dict.fromkeys(("reported", "fit", "ratio"), ""),
        }
        for count in counts:
            known = direct[:count], indirect[:count]
            fits = {
                name: partial(el.TransferModel.fit, *known, RANK, **options)
                for name, options in {**METHODS, "prior": {"prior": geometry}}.items()
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
                    **spread(errors),
                    "reported": f"{100 * model.report.error:.1f} %",
                    "fit": f"{1e3 * seconds[name]:.3g} ms",
                    "ratio": f"{seconds[name] / seconds['default']:.1f}",
                }


def spread(errors):
    return dict(zip(("median", "90th", "worst"), percentiles(errors), strict=True))


def percentiles(errors):
    return [f"{100 * share:.1f} %" for share in (*np.percentile(errors, [50, 90]), errors.max())]


def data(is_quick):
    """Scenes: name, numbers of pairs, first unseen pair, the images, and the prior."""
    width = 32 if is_quick else 64
    room = el.synthetic.room(48 if is_quick else 384, width=width)
    counts, first = ((16, 32), 32) if is_quick else ((32, 64, 128), 128)
    yield "room", counts, first, *both(room), room_prior(width)
    folder = os.environ.get("ENVLIGHTS_TRANSFER_DB")
    if folder and not is_quick:
        direct, indirect = both(el.read_pairs(folder))
        maps = [
            el.io.read_image(f"{folder}/{name}.exr").pixels[None, ..., :3].astype(float)
            for name in ("position", "normal", "albedo")
        ]
        of_database = prior(*(each[0] for each in maps))
        yield "database", (24, 48), 48, direct, indirect, of_database
        of_means = prior(*(means(each)[0] for each in maps))
        yield "database, means", (24, 48), 48, direct, means(indirect), of_means


def means(images):
    """Means of blocks of 4x4 texels."""
    k, height, width, _ = images.shape
    return images.reshape(k, height // 4, 4, width // 4, 4, 3).mean(axis=(2, 4))


def both(pairs):
    return [np.asarray(each, np.float32) for each in (pairs.direct, pairs.indirect)]
