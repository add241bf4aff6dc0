"""Non-negative operators as prior means: closed forms, SciPy, laws of light, folds."""

from functools import partial

import numpy as np
import pytest
from scipy.optimize import nnls

import envlights as el
from envlights.transfer.training.blocks import blocks
from envlights.transfer.training.nonnegative import minimiser
from envlights.transfer.training.remainder import estimator_around
from envlights.transfer.training.ridge import regression
from tests.helpers import oblong, pairs_of_room, relative_errors

room = partial(pairs_of_room, 80, 32)
NEW = slice(64, None)


def scene(count=64):
    return room().direct[:count], room().indirect[:count]


@pytest.fixture(scope="module")
def model():
    return el.TransferModel.fit(*scene(), rank=48, nonnegative=True)


@pytest.mark.parametrize("rows", [7, 40])  # fewer and more images than texels
def test_the_minimiser_is_that_of_scipy(rows):
    rng = np.random.default_rng(rows)
    direct, sums = rng.random((rows, 12)), rng.normal(size=(rows, 5))
    found = minimiser(direct, sums, steps=3000)
    damped = np.vstack([direct, 1e-3 * np.eye(12)])
    for column, right in zip(found.T, sums.T, strict=True):
        truth, residual = nnls(damped, np.concatenate([right, np.zeros(12)]))
        assert column.min() >= 0
        cost = np.linalg.norm(damped @ column - np.concatenate([right, np.zeros(12)]))
        assert cost <= residual * (1 + 1e-4)
        if rows > 12:
            np.testing.assert_allclose(column, truth, atol=1e-3 * truth.max() + 1e-6)


def test_a_non_negative_operator_is_recovered_from_as_many_pairs_as_texels():
    rng = np.random.default_rng(0)
    direct = rng.random((12, 3, 4, 3))
    operator = rng.random((12, 8 * 8)) * (rng.random((12, 64)) < 0.5)
    light = np.einsum("khwc,hwt->ktc", direct, operator.reshape(3, 4, 64))
    model = el.TransferModel.fit(
        direct, light.reshape(12, 8, 8, 3), rank=36, ridge=1e-12, nonnegative=True
    )
    spots = np.repeat(np.eye(12).reshape(12, 3, 4, 1), 3, axis=3)
    truth = np.repeat(operator.reshape(12, 8, 8, 1), 3, axis=3)
    np.testing.assert_array_less(relative_errors(model.predict(spots), truth), 1e-4)


def test_block_sums_and_gains_are_those_of_the_images():
    direct, indirect = oblong()
    indirect[:, 2:5, 1:7] = 0
    model = el.TransferModel.fit(direct, indirect, rank=36)
    found = blocks(model.basis, model.lit, model.learnt.coefficients, most=8)
    scale = 1 / np.linalg.norm(direct.reshape(12, -1), axis=1)
    padded = np.zeros((12, 8, 12, 3))
    padded[:, :7, :11] = indirect * scale[:, None, None, None]
    texels = padded.reshape(12, 2, 4, 3, 4, 3)
    sums = texels.sum(axis=(2, 4)).reshape(12, 6, 3)
    from_basis = model.learnt.coefficients @ found.sums.T
    np.testing.assert_allclose(from_basis, sums.swapaxes(1, 2), atol=1e-9)
    # Each channel of the images in the coordinates of the basis, weighted by the gains.
    power = np.sum(padded**2, axis=0).reshape(2, 4, 3, 4, 3)
    gains = np.sqrt(power / np.sum(sums.reshape(12, 2, 3, 3) ** 2, axis=0)[:, None, :, None])
    weighted = (texels * gains).sum(axis=(2, 4)).reshape(12, 6, 3)
    seen = np.einsum("kcr,cbr->kbc", model.learnt.coefficients, found.spread)
    np.testing.assert_allclose(seen, weighted, atol=1e-9)


def test_new_lights_are_predicted_better(model):
    plain = el.TransferModel.fit(*scene(), rank=48)
    ours, theirs = (
        relative_errors(each.predict(room().direct[NEW]), room().indirect[NEW])
        for each in (model, plain)
    )
    assert np.median(ours) < 0.85 * np.median(theirs)
    assert ours.max() < 0.85 * theirs.max()


def test_reported_errors_are_those_of_new_lights():
    """Each half of the lights is new to the model of the other half."""
    halves = slice(0, 40), slice(40, 80)
    reported, true = [], []
    for known, new in (halves, halves[::-1]):
        model = el.TransferModel.fit(
            room().direct[known], room().indirect[known], rank=48, nonnegative=True
        )
        reported += model.report.unseen_errors
        true += relative_errors(model.predict(room().direct[new]), room().indirect[new]).tolist()
    assert np.median(reported) == pytest.approx(np.median(true), rel=0.25)


def test_errors_of_folds_are_those_of_estimators_without_each_fold(model):
    rng = np.random.default_rng(3)
    direct, coefficients = rng.random((20, 3, 9)), rng.normal(size=(20, 3, 4))

    def prior(solver, coefficients):
        return 0.5 * solver.transfer(0.1, coefficients)

    whole = estimator_around(direct, coefficients, prior, prior)
    missed = whole.left_out(0.01)
    for k in range(20):
        others = np.arange(20) % 8 != k % 8
        without = estimator_around(direct[others], coefficients[others], prior, prior)
        seen = np.einsum("cs,csr->cr", direct[k], without.transfer(0.01))
        np.testing.assert_allclose(missed[k], coefficients[k] - seen, atol=1e-10)


def test_light_is_linear_and_no_light_is_black(model):
    one, two = room().direct[64:66].astype(float)
    first, second = model.predict(one).astype(float), model.predict(two).astype(float)
    together, apart = model.predict(2 * one + two), 2 * first + second
    # Negative texels become 0, which is not linear.
    is_kept = (first > 0) & (second > 0)
    assert is_kept.mean() > 0.9
    assert relative_errors((together * is_kept)[None], (apart * is_kept)[None])[0] < 1e-6
    assert not model.predict(0 * one).any()


def test_permuted_channels_give_permuted_images(model):
    order = [2, 0, 1]
    other = el.TransferModel.fit(*(each[..., order] for each in scene()), rank=48, nonnegative=True)
    seen = other.predict(room().direct[NEW][..., order])
    truth = model.predict(room().direct[NEW])[..., order]
    np.testing.assert_array_less(relative_errors(seen, truth), 1e-4)


@pytest.mark.parametrize("notebook", [False, True])
def test_without_the_argument_the_matrix_is_that_of_the_ridge_alone_to_the_bit(notebook):
    model = el.TransferModel.fit(*scene(), rank=32, notebook=notebook)
    solver = regression(model.learnt.direct, channelwise=not notebook)
    truth = solver.transfer(1e-3, model.learnt.coefficients)
    np.testing.assert_array_equal(model.transfer, truth)
    assert model.report.ridge == 1e-3


@pytest.mark.parametrize("stops", [-100, 100])
def test_the_scale_of_the_images_does_not_matter(stops):
    direct, indirect = scene()
    model = el.TransferModel.fit(direct, indirect, rank=24, nonnegative=True)
    scaled = el.TransferModel.fit(direct, np.ldexp(indirect, stops), rank=24, nonnegative=True)
    seen = np.ldexp(scaled.predict(room().direct[NEW]), -stops)
    np.testing.assert_array_less(relative_errors(seen, model.predict(room().direct[NEW])), 1e-4)


def test_pairs_can_be_added_and_models_saved_and_compressed(model, tmp_path):
    first = el.TransferModel.fit(*scene(40), rank=48, nonnegative=True)
    grown = first.add(room().direct[40:64], room().indirect[40:64])
    errors = [
        np.median(relative_errors(each.predict(room().direct[NEW]), room().indirect[NEW]))
        for each in (model, grown)
    ]
    assert errors[1] < 1.15 * errors[0]
    assert sum("8 folds" in note for note in grown.report.notes) == 1
    grown.save(tmp_path / "model.npz")
    assert el.TransferModel.load(tmp_path / "model.npz") == grown
    frames = grown.compressed(0.01).predict(room().direct[NEW])
    np.testing.assert_array_less(relative_errors(frames, grown.predict(room().direct[NEW])), 0.011)


def test_one_pair_is_enough_and_black_channels_stay_black():
    direct, indirect = oblong(3)
    direct[..., 0] = indirect[..., 0] = 0
    one = el.TransferModel.fit(direct[:1], indirect[:1], nonnegative=True)
    assert np.isfinite(one.predict(direct)).all()
    assert one.report.unseen_errors == pytest.approx((1.0,), abs=1e-6)
    every = el.TransferModel.fit(direct, indirect, nonnegative=True)
    assert not every.predict(direct)[..., 0].any()


def test_the_notebooks_model_has_no_operator_without_negative_values():
    with pytest.raises(el.EnvLightsError, match="nonnegative=True and notebook=True exclude"):
        el.TransferModel.fit(*oblong(), nonnegative=True, notebook=True)


def test_no_texel_is_negative(model):
    """Under new lights and under light of single texels; the expansion alone has negative ones."""
    size = np.prod(model.size)
    spots = np.repeat(np.eye(size).reshape(size, *model.size, 1), 3, axis=3)
    for direct in (room().direct[NEW], spots):
        predicted = model.predict(direct)
        assert predicted.min() == 0
        assert predicted.max() > 0
