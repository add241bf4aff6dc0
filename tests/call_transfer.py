"""Calls of transfer models, for the table in `calls.py`."""

import numpy as np
from hypothesis import strategies as st

import envlights as el
from tests.call_values import DIRECT, FLAG, INDIRECT, MODEL, SHARE, array, method_of

#: Texels of both images, which see those of the direct one.
TEXELS = DIRECT[0, ..., 0].size
PRIOR = el.transfer.TransferPrior(
    hits=np.ones((INDIRECT[0, ..., 0].size, TEXELS), np.uint16),
    rays=TEXELS,
    between=np.full((TEXELS, TEXELS), 0.5 / TEXELS),
    visible=np.ones(TEXELS),
    albedo=np.full(INDIRECT.shape[1:], 0.5),
    covered=np.ones(INDIRECT.shape[1:3], bool),
    direct_albedo=np.full((TEXELS, 3), 0.5),
    size=DIRECT.shape[1:3],
)

TRANSFER_CALLS = {
    "TransferModel.fit": (
        el.TransferModel.fit,
        {
            "direct": st.one_of(array(6, 2, 3, 3), st.just(DIRECT)),
            "indirect": st.one_of(array(6, 4, 2, 3), st.just(INDIRECT)),
            "rank": st.one_of(st.integers(1, 9), SHARE),
            "ridge": st.one_of(SHARE, st.just("loo")),
            "error": st.one_of(st.none(), SHARE),
            "nonnegative": FLAG,
            "prior": st.one_of(st.none(), st.just(PRIOR)),
            "virtual": st.one_of(st.none(), st.just(DIRECT)),
            "notebook": FLAG,
        },
    ),
    "TransferModel.predict": (
        method_of(MODEL, "predict"),
        {"direct": st.just(DIRECT), "error": SHARE, "region": st.none()},
    ),
    "TransferModel.project": (method_of(MODEL, "project"), {"indirect": st.just(INDIRECT)}),
    "TransferModel.unfamiliar": (method_of(MODEL, "unfamiliar"), {"direct": st.just(DIRECT)}),
    "TransferModel.next_lights": (
        method_of(MODEL, "next_lights"),
        {"candidates": st.just(DIRECT), "count": st.integers(0, 2)},
    ),
    "TransferModel.add": (
        method_of(MODEL, "add"),
        {"direct": st.just(DIRECT[:1]), "indirect": st.just(INDIRECT[:1])},
    ),
    "TransferModel.compressed": (method_of(MODEL, "compressed"), {"error": SHARE}),
    "TransferPrior.predict": (method_of(PRIOR, "predict"), {"direct": st.just(DIRECT)}),
    "TransferPrior.errors": (
        method_of(PRIOR, "errors"),
        {"direct": st.just(DIRECT), "indirect": st.just(INDIRECT)},
    ),
    "TransferPrior.load": (el.transfer.TransferPrior.load, {"path": st.just("none.npz")}),
    "TransferPrior.save": (method_of(PRIOR, "save"), {"path": st.just("no-folder/p.npz")}),
    "TransferModel.load": (el.TransferModel.load, {"path": st.just("none.npz")}),
    "TransferModel.save": (method_of(MODEL, "save"), {"path": st.just("no-folder/m.npz")}),
}
