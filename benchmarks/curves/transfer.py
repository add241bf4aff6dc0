"""Indirect light from direct light: run time of a frame against the error on unseen lights.

The error is the median of the relative errors of the unseen images. The second panel shows the same
error against the time of a fit. The settings are ranks. At rank 32, `fewer pairs` has a setting for
the number of pairs, and `smaller direct` one for the texels along a side of the direct image. The
ridge is 1e-3, except for `ridge="loo"`. The pairs are those of the generated room without noise,
64x64, and of the database in `ENVLIGHTS_TRANSFER_DB`, if any.
"""

import os
from functools import partial

import numpy as np
from curves.peers_of_transfer import notebook, scikit, scikit_linear
from curves.results import point, run_times, those_installed
from tests.helpers import relative_errors

import envlights as el

TITLE = "Indirect light"
READ = ": left is faster, down is better"
ERRORS = {"unseen": "error on unseen lights", "fit": "seconds of a fit"}
#: Errors that are run times.
TIMED = ("fit",)
COUNTED = None
#: What the run time is of, and those whose frames take what those of `TransferModel` do.
CALL, UNDRAWN = "milliseconds of a frame", ("fewer pairs", "smaller direct")
OURS = ("TransferModel", 'ridge="loo"', "compressed", "fewer pairs", "smaller direct")
RANKS, RANK = (4, 8, 16, 32), 32
#: Pairs of the room, and the share of all pairs that is learnt.
PAIRS, LEARNT = 96, 0.75


def ours(direct, indirect, rank, **options):
    return el.TransferModel.fit(direct, indirect, rank, **options).predict


def compressed_model(direct, indirect, rank):
    return el.TransferModel.fit(direct, indirect, rank).compressed().predict


def of_fewer_pairs(direct, indirect, pairs):
    return ours(direct[:pairs], indirect[:pairs], RANK)


def of_smaller_direct(direct, indirect, side):
    predict = ours(reduce_images(direct, side), indirect, RANK)
    return lambda image: predict(reduce_images(image[None], side)[0])


def reduce_images(images, side):
    """Images of direct light in fewer texels, each the mean of a block."""
    count, height, width, _ = images.shape
    return images.reshape(count, side, height // side, side, width // side, 3).mean(axis=(2, 4))


METHODS = {
    "TransferModel": (RANKS, ours),
    'ridge="loo"': (RANKS, partial(ours, ridge="loo")),
    "compressed": (RANKS, compressed_model),
    "fewer pairs": ((12, 24, 36), of_fewer_pairs),
    "smaller direct": ((2, 4, 8), of_smaller_direct),
    "notebook": (RANKS, notebook),
    "scikit-learn": (RANKS, scikit),
    "scikit-learn, linear": (RANKS, scikit_linear),
}
NEEDS = dict.fromkeys(("scikit-learn", "scikit-learn, linear"), "sklearn")
METHODS = those_installed(METHODS, NEEDS)


def are_comparable(our, their):
    """At the same rank, or where ours has the rank of all others."""
    return our.setting == their.setting or (our.method in OURS[3:] and their.setting == RANK)


def points(_, effort):
    """Yield a point for each data set, method and setting."""
    for name, direct, indirect in data(effort.is_quick):
        learnt = int(LEARNT * len(direct))
        new, truth = direct[learnt:], indirect[learnt:]
        fits = {
            (method, setting): partial(fit, direct[:learnt], indirect[:learnt], setting)
            for method, (settings, fit) in METHODS.items()
            for setting in settings
        }
        models = {key: fit() for key, fit in fits.items()}
        fitted = run_times(fits, effort)
        frames = {key: partial(model, new[0]) for key, model in models.items()}
        seconds = run_times(frames, effort)
        for key, model in models.items():
            seen = np.stack([model(image) for image in new])
            errors = {"unseen": float(np.median(relative_errors(seen, truth)))}
            yield point("transfer", name, *key, errors, call=[seconds[key]], fit=[fitted[key]])


def data(is_quick):
    """Names, and pairs in float32; of a quick run those of the room alone."""
    room = el.synthetic.room(PAIRS, width=64)
    yield "room", room.direct, room.indirect
    folder = os.environ.get("ENVLIGHTS_TRANSFER_DB")
    if folder and not is_quick:
        pairs = el.read_pairs(folder)
        both = (np.asarray(each, np.float32) for each in (pairs.direct, pairs.indirect))
        yield "database", *both
