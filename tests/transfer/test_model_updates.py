"""Models: refusals, added pairs and copies."""

import copy
import os
import pickle
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import strategies as st

import envlights as el
from tests.helpers import oblong, pairs_of_room, relative_errors

room = partial(pairs_of_room, 80, 32)
NEW = slice(64, None)
FACTOR = st.floats(1e-3, 1e3)
#: The note of every model of this room.
BLACK = "10 of 1024 texels are black in every image, so they are predicted black"


def scene():
    return room().direct[:64], room().indirect[:64]


@pytest.fixture(scope="module")
def model():
    return el.TransferModel.fit(*scene(), rank=32)


def with_value(images, value):
    images = images.copy()
    images[2, 1, 0, 1] = value
    return images


SMALL, LARGE = oblong(4)


@pytest.mark.parametrize(
    ("direct", "indirect", "options", "message"),
    [
        (SMALL[0], LARGE, {}, r"direct must have the shape \(k, height, width, 3 or 4\); got \(3"),
        (SMALL, LARGE[..., :2], {}, r"indirect must have the shape .* got \(4, 7, 11, 2\)"),
        (SMALL[:0], LARGE[:0], {}, r"got \(0, "),
        (SMALL[:3], LARGE, {}, r"the same number of images; got 3 and 4"),
        ([[[[1, 2, 3]]], [[[1, 2]]]], LARGE, {}, r"images of one size"),
        (SMALL, LARGE.astype(np.uint8), {}, r"floating point; got the dtype uint8"),
        (
            with_value(SMALL, np.nan),
            LARGE,
            {},
            r"direct must be finite; image 2 holds nan at row 1",
        ),
        (SMALL, with_value(LARGE, np.inf), {}, r"indirect must be finite; image 2 holds inf"),
        (SMALL, np.full((4, 256, 256, 3), 1e30, np.float32), {}, r"overflow float32"),
        (
            np.ldexp(SMALL, -100),
            np.ldexp(LARGE, 97).astype(np.float32),
            {"notebook": True},
            r"the mean of indirect .* overflows float32",
        ),
        (0 * SMALL, LARGE, {}, r"direct is black in every image"),
        (SMALL, 0 * LARGE, {}, r"indirect is black in every image"),
        (SMALL, LARGE, {"rank": 0}, r"rank must be a whole number, 1 or more; got 0"),
        (SMALL, LARGE, {"rank": 1.5}, r"share of the energy must be a finite number, from 0 to 1"),
        (SMALL, LARGE, {"rank": 0.0}, r"must be more than 0"),
        (SMALL, LARGE, {"rank": "all"}, r"rank must be a whole number"),
        (SMALL, LARGE, {"ridge": -1}, r"ridge must be a finite number, 0 or more; got -1"),
        (SMALL, LARGE, {"ridge": "cv"}, r"ridge must be 'loo'; got 'cv'"),
        (SMALL, LARGE, {"error": -0.1}, r"error must be a finite number"),
    ],
)
def test_what_cannot_be_learnt_is_refused(direct, indirect, options, message):
    with pytest.raises(el.EnvLightsError, match=message):
        el.TransferModel.fit(direct, indirect, **options)


@pytest.mark.parametrize(
    ("name", "images", "message"),
    [
        ("predict", np.zeros((16, 8, 3)), r"direct must be 16x16 pixels, .* got 8x16"),
        ("predict", np.zeros((16, 16)), r"direct must have the shape"),
        ("predict", np.full((16, 16, 3), np.nan), r"direct must be finite; image 0"),
        ("project", np.zeros((2, 4, 4, 3)), r"indirect must be 32x32 pixels, .* got 4x4"),
    ],
)
def test_other_images_than_were_learnt_are_refused(model, name, images, message):
    with pytest.raises(el.EnvLightsError, match=message):
        getattr(model, name)(images)


def test_added_pairs_count_as_if_they_had_been_there(model):
    first = el.TransferModel.fit(*(images[:40] for images in scene()), rank=32)
    grown = first.add(*(images[40:] for images in scene()))
    assert (grown.report.pairs, grown.report.rank) == (64, 32)
    np.testing.assert_allclose(grown.basis.T @ grown.basis, np.eye(32), atol=1e-3)
    errors = [
        relative_errors(each.predict(room().direct[NEW]), room().indirect[NEW])
        for each in (model, grown)
    ]
    assert np.median(errors[1]) < 1.1 * np.median(errors[0])
    assert grown.report.error == pytest.approx(model.report.error, rel=0.1)


def test_adding_loses_nothing_where_the_rank_holds_everything():
    direct, indirect = oblong()
    indirect[:6, 0] = 0  # texels that only the later pairs light
    grown = el.TransferModel.fit(direct[:6], indirect[:6]).add(direct[6:9], indirect[6:9])
    grown = grown.add(direct[9:], indirect[9:])
    whole = el.TransferModel.fit(direct, indirect)
    np.testing.assert_array_less(
        relative_errors(grown.predict(direct), whole.predict(direct)), 1e-9
    )
    np.testing.assert_allclose(grown.report.unseen_errors, whole.report.unseen_errors, rtol=1e-6)


def test_training_errors_are_known_after_adding_too():
    first = el.TransferModel.fit(*(images[:40] for images in scene()), rank=12)
    grown = first.add(*(images[40:] for images in scene()))
    truth = relative_errors(grown.predict(scene()[0]), scene()[1])
    told = np.array(grown.report.training_errors)
    np.testing.assert_allclose(told[40:], truth[40:], rtol=0.01)
    # What was left of the earlier images is known by its size alone, and the new basis sees some.
    assert np.median(told[:40]) == pytest.approx(np.median(truth[:40]), rel=0.1)


def test_notes_after_adding_are_those_of_all_pairs():
    few = "the images have no more than {} directions above rounding"
    copies = "{} pairs are copies of others: left out together with them"
    missed = "the error 0.0001 was not reached; allow a higher rank"
    direct, indirect = oblong()

    def notes(first, new, **options):
        model = el.TransferModel.fit(direct[first], indirect[first], **options)
        grown = model.add(direct[new], indirect[new])
        return model.report.notes, grown.report.notes

    rest = np.arange(4, 12)
    assert notes([0, 1, 2, 3], [4]) == ((few.format(12),), (few.format(15),))
    assert notes([0, 1, 2, 3], rest, rank=36) == ((few.format(12),), ())
    assert notes([0, 1, 0, 1], [0, 1]) == tuple(
        (few.format(6), copies.format(each)) for each in (2, 4)
    )
    # An error cuts the basis, which then has fewer directions than its images.
    assert notes([0, 1, 2, 3], [4], error=0.5) == ((few.format(12),), ())
    # What the first basis left out is not in the second either, though its pairs add no direction.
    indirect[4] = 0
    assert notes([0, 1], [4], rank=2, error=1e-4) == ((missed,), (missed,))


def test_an_error_that_later_pairs_reach_is_no_longer_noted():
    direct, indirect = oblong()
    indirect[1:] = indirect[:1, :, :, :1]
    model = el.TransferModel.fit(direct[:2], indirect[:2], rank=1, error=0.5)
    assert any("was not reached" in note for note in model.report.notes)
    grown = model.add(direct[2:], indirect[2:])
    assert np.sqrt(1 - grown.report.energy) < 0.5
    assert not any("was not reached" in note for note in grown.report.notes)


def test_pairs_that_do_not_fit_a_model_are_not_added(model):
    with pytest.raises(el.EnvLightsError, match="indirect must be 32x32 pixels"):
        model.add(scene()[0], scene()[1][:, :8])
    with pytest.raises(el.EnvLightsError, match="direct must have the shape"):
        model.add(1.0, 2.0)
    with pytest.raises(el.EnvLightsError, match="notebook=True cannot grow"):
        el.TransferModel.fit(*scene(), notebook=True).add(*scene())


@pytest.mark.parametrize("notebook", [False, True])
@pytest.mark.parametrize("copied", [copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
def test_copies_of_models_predict_the_same(copied, notebook):
    model = el.TransferModel.fit(*scene(), rank=8, notebook=notebook)
    np.testing.assert_array_equal(copied(model).predict(scene()[0]), model.predict(scene()[0]))
    assert copied(model).report == model.report


IMPOSSIBLE = [
    (lambda model: {"lit": model.lit[0]}, r"lit must have 2 axes; got the shape \(32,\)"),
    (lambda model: {"lit": model.lit.astype(int)}, "lit must hold bool .* got int64"),
    (lambda model: {"lit": ~model.lit}, r"basis must .* \(10, 32\); got float32 .* \(1014, 32\)"),
    (lambda model: {"basis": model.basis[:, :5]}, r"basis must .* \(1014, 32\); got"),
    (lambda model: {"basis": model.basis.tolist()}, "basis .* got an object of the type list"),
    (lambda model: {"transfer": model.transfer[..., :5]}, r"basis must .* \(1014, 5\); got"),
    (lambda model: {"transfer": model.transfer[:, 1:]}, r"transfer must .* \(3, 256, 32\); got"),
    (lambda model: {"transfer": 1.0}, r"basis must .* \(1014,\); got"),
    (lambda model: {"mean": model.basis[:, 0]}, r"transfer must .* \(3, 768, 32\); got"),
    (lambda model: {"mean": np.ones(7)}, r"mean must .* \(1014,\); got float64 .* \(7,\)"),
    (lambda model: {"size": (16, 8)}, r"transfer must .* \(3, 128, 32\); got"),
    (lambda model: {"size": (16,)}, "size must be two numbers, height and width"),
    (lambda model: {"size": (16, 16.0)}, "size must be a whole number"),
    (
        lambda model: {"parameters": {"rank": 3}},
        "parameters must be error, nonnegative, prior, rank, ridge; got rank",
    ),
    (lambda model: {"parameters": {**model.parameters, "ridge": -1}}, "ridge must be a finite"),
    (lambda model: {"learnt": None}, "learnt must be a PairSummary"),
    (lambda model: {"report": {}}, "report a TransferReport"),
    (
        lambda model: {"learnt": replace(model.learnt, energy=model.learnt.energy[1:])},
        r"energy must .* \(64,\); got float64 in the shape \(63,\)",
    ),
    (
        lambda model: {"learnt": replace(model.learnt, outside=model.learnt.outside.tolist())},
        "outside must .* got an object of the type list",
    ),
]


@pytest.mark.parametrize(("change", "message"), IMPOSSIBLE)
def test_fields_that_do_not_fit_together_are_refused_also_from_a_pickle(model, change, message):
    broken = copy.copy(model)
    for name, value in change(model).items():
        object.__setattr__(broken, name, value)
    for construct in (
        lambda: replace(model, **change(model)),
        lambda: copy.copy(broken),
        lambda: pickle.loads(pickle.dumps(broken)),
    ):
        with pytest.raises(el.EnvLightsError, match=message) as refusal:
            construct()
        assert "\n" not in str(refusal.value)


def test_path_traced_pairs_are_predicted_better_than_by_the_notebook():
    database = os.environ.get("ENVLIGHTS_TRANSFER_DB")
    if not database:
        pytest.skip("set ENVLIGHTS_TRANSFER_DB to a folder of pairs to try them as well")
    pairs = el.read_pairs(database)
    errors = []
    for notebook in (False, True):
        model = el.TransferModel.fit(pairs.direct[:48], pairs.indirect[:48], 32, notebook=notebook)
        unseen = relative_errors(model.predict(pairs.direct[48:]), pairs.indirect[48:])
        errors.append(np.median(unseen))
        if not notebook:
            assert model.report.error == pytest.approx(errors[0], rel=0.25)
    assert errors[0] < 0.22
    assert errors[0] < 2 / 3 * errors[1]
