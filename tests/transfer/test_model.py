"""Indirect light from direct light: references, laws of light, odd pairs of images."""

from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import envlights as el
from tests.helpers import oblong, pairs_of_room, relative_errors
from tests.reference import transfer as reference

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


def test_notebook_is_the_notebooks_mathematics():
    for direct, indirect in (oblong(), [images.astype(float) for images in scene()]):
        model = el.TransferModel.fit(direct, indirect, rank=8, notebook=True)
        predict = reference.notebook(direct, indirect, 8, 1e-3)
        truth = np.stack([predict(image) for image in direct])
        np.testing.assert_array_less(relative_errors(model.predict(direct), truth), 1e-10)


@pytest.mark.parametrize(("dtype", "most"), [(np.float32, 1e-4), (np.float64, 1e-9)])
def test_the_model_is_that_of_dense_algebra(dtype, most):
    direct, indirect = scene()
    model = el.TransferModel.fit(direct, indirect.astype(dtype), rank=32)
    predict = reference.channelwise(direct.astype(float), indirect.astype(float), 32, 1e-3)
    truth = np.stack([predict(image.astype(float)) for image in room().direct[NEW]])
    np.testing.assert_array_less(relative_errors(model.predict(room().direct[NEW]), truth), most)


def test_projection_is_the_dense_projection(model):
    scale = 1 / np.linalg.norm(scene()[0].reshape(64, -1), axis=1)
    rows = np.moveaxis(scene()[1] * scale[:, None, None, None], -1, 1).reshape(3 * 64, -1)
    B = np.linalg.svd(rows.astype(float), full_matrices=False)[2][:32]
    new = np.moveaxis(room().indirect[NEW], -1, 1).reshape(16, 3, -1)
    truth = np.moveaxis((new @ B.T @ B).reshape(16, 3, 32, 32), 1, -1)
    np.testing.assert_array_less(relative_errors(model.project(room().indirect[NEW]), truth), 1e-4)


def test_a_bar_for_each_pass_changes_nothing(model, capsys):
    assert el.TransferModel.fit(*scene(), rank=32, progress=True) == model
    assert capsys.readouterr().err.count("learning: 100%") == 2
    el.TransferModel.fit(*scene(), rank=32)
    assert not capsys.readouterr().err


@pytest.mark.parametrize("notebook", [False, True])
def test_the_basis_holds_what_it_was_made_of(notebook):
    direct, indirect = oblong()
    model = el.TransferModel.fit(direct, indirect, notebook=notebook)
    learnt = indirect / np.linalg.norm(direct.reshape(12, -1), axis=1)[:, None, None, None]
    np.testing.assert_array_less(relative_errors(model.project(learnt), learnt), 1e-9)


def test_the_basis_is_orthonormal(model):
    np.testing.assert_allclose(model.basis.T @ model.basis, np.eye(32), atol=1e-4)


@given(FACTOR, FACTOR, st.integers(0, 15), st.integers(0, 15))
@settings(max_examples=25)
def test_light_is_linear(model, a, b, first, second):
    one, two = room().direct[64 + first].astype(float), room().direct[64 + second].astype(float)
    together = model.predict(a * one + b * two)[None]
    apart = a * model.predict(one).astype(float) + b * model.predict(two)
    assert relative_errors(together, apart[None])[0] < 1e-6


def test_a_batch_is_its_frames(model):
    frames = np.stack([model.predict(frame) for frame in room().direct[NEW]])
    np.testing.assert_array_less(relative_errors(model.predict(room().direct[NEW]), frames), 1e-6)


def test_training_images_come_back_at_full_rank_without_a_ridge():
    direct, indirect = oblong()
    model = el.TransferModel.fit(direct, indirect, rank=36, ridge=0.0)
    np.testing.assert_array_less(relative_errors(model.predict(direct), indirect), 1e-8)
    single = el.TransferModel.fit(direct, indirect.astype(np.float32), rank=36, ridge=0.0)
    np.testing.assert_array_less(relative_errors(single.predict(direct), indirect), 1e-5)


def test_new_lights_are_predicted_better_than_by_the_notebook(model):
    error = np.median(relative_errors(model.predict(room().direct[NEW]), room().indirect[NEW]))
    other = el.TransferModel.fit(*scene(), rank=32, notebook=True)
    theirs = np.median(relative_errors(other.predict(room().direct[NEW]), room().indirect[NEW]))
    assert error < 0.15
    assert error < theirs / 2


@pytest.mark.parametrize("rank", [8, 24, 48])
def test_leave_one_out_errors_are_those_of_fits_without_each_image(rank):
    model = el.TransferModel.fit(*scene(), rank=rank)
    truth = []
    for k in range(64):
        others = [np.delete(images, k, axis=0) for images in scene()]
        without = el.TransferModel.fit(*others, rank=rank)
        truth.append(
            relative_errors(without.predict(scene()[0][k])[None], scene()[1][k : k + 1])[0]
        )
    told = np.array(model.report.unseen_errors)
    assert np.median(told) == pytest.approx(np.median(truth), rel=0.05)
    assert np.median(np.abs(told / truth - 1)) < 0.02


def test_copies_of_a_pair_are_left_out_together():
    """Another exposure of a pair is a copy too; the first pair is given three times."""
    twice = [np.concatenate([images, 2 * images[:32], images[:1]]) for images in scene()]
    report = el.TransferModel.fit(*twice, rank=24, ridge=0.0).report
    alone = el.TransferModel.fit(*scene(), rank=24, ridge=0.0).report
    told = np.array(report.unseen_errors)
    np.testing.assert_allclose(told[64:96], told[:32], rtol=1e-12)
    assert told[96] == told[0]
    # The basis leans to what is given more often: errors differ by that alone.
    assert np.median(told[:64] / alone.unseen_errors) == pytest.approx(1, rel=0.05)
    assert report.notes == (BLACK, "33 pairs are copies of others: left out together with them")
    assert alone.notes == (BLACK,)


def test_frames_beyond_single_precision_are_refused(model):
    for each in (model, model.compressed(0.05)):
        bright = 1e30 * scene()[0][0].astype(float)
        assert np.isfinite(each.predict(bright)).all()
        with pytest.raises(el.EnvLightsError, match=r"direct is too bright: .* divide direct by"):
            each.predict(1e10 * bright)
        with pytest.raises(el.EnvLightsError, match=r"direct is too bright"):
            each.predict(1e130 * bright, error=0.1)


@pytest.mark.parametrize("texels", [8, 128])  # summed by NumPy, and by the kernels
@pytest.mark.parametrize(("stops", "dim"), [(100, -100), (-100, 100)])
def test_pairs_two_hundred_stops_apart_have_the_model_of_the_same_pairs_at_one_scale(
    stops, dim, texels
):
    rng = np.random.default_rng(texels)
    direct = rng.random((6, 4, 4, 3)).astype(np.float32)
    indirect = rng.random((6, texels, texels, 3)).astype(np.float32)
    plain = el.TransferModel.fit(direct, indirect, rank=4)
    apart = el.TransferModel.fit(np.ldexp(direct, stops), np.ldexp(indirect, dim), rank=4)
    seen = np.ldexp(apart.predict(np.ldexp(direct[0], stops)), -dim)
    np.testing.assert_allclose(seen, plain.predict(direct[0]), rtol=1e-5)


def test_training_errors_are_those_of_the_predictions(model):
    truth = relative_errors(model.predict(scene()[0]), scene()[1])
    np.testing.assert_allclose(model.report.training_errors, truth, rtol=1e-2, atol=1e-4)


def test_a_ridge_of_its_own_choice_is_least_wrong():
    noise = np.random.default_rng(0).normal(1, 0.1, scene()[1].shape)
    clean = el.TransferModel.fit(*scene(), ridge="loo").report
    noisy = el.TransferModel.fit(scene()[0], scene()[1] * noise, ridge="loo").report
    assert clean.ridge < noisy.ridge
    for ridge in (1e-6, 1e-2):
        other = el.TransferModel.fit(*scene(), ridge=ridge).report
        assert np.mean(clean.unseen_errors) <= np.mean(other.unseen_errors)


@pytest.mark.parametrize("share", [0.5, 0.9, 0.99, 1.0])
def test_rank_by_share_is_the_least_that_holds_it(share):
    direct, indirect = oblong()
    report = el.TransferModel.fit(direct, indirect, rank=share).report
    assert report.energy >= share - 1e-9
    if report.rank > 1:
        fewer = el.TransferModel.fit(direct, indirect, rank=report.rank - 1).report
        assert fewer.energy < share


def test_rank_by_error_is_the_least_that_reaches_it():
    report = el.TransferModel.fit(*scene(), error=0.05).report
    assert np.sqrt(1 - report.energy) <= 0.05
    fewer = el.TransferModel.fit(*scene(), rank=report.rank - 1).report
    assert np.sqrt(1 - fewer.energy) > 0.05
    missed = el.TransferModel.fit(*scene(), rank=2, error=1e-4).report
    assert missed.rank == 2
    assert "the error 0.0001 was not reached; allow a higher rank" in missed.notes


def test_a_share_of_the_energy_limits_a_rank_by_error():
    by_error, by_share = {"error": 0.05}, {"rank": 0.9}
    ranks = [
        el.TransferModel.fit(*scene(), **{"rank": 1.0, **each}).report.rank
        for each in (by_error, by_share, {**by_error, **by_share}, {**by_error, "rank": 0.9999})
    ]
    assert ranks[1] == ranks[2] < ranks[0] == ranks[3]


def test_a_higher_rank_than_the_images_have_is_cut_and_noted():
    direct, indirect = oblong()
    report = el.TransferModel.fit(direct, indirect, rank=500).report
    assert report.rank == 36
    assert report.notes == ("the images have no more than 36 directions above rounding",)


def test_one_pair_is_enough_for_its_own_light():
    direct, indirect = oblong(1)
    model = el.TransferModel.fit(direct, indirect, ridge=0.0)
    np.testing.assert_array_less(relative_errors(model.predict(3 * direct), 3 * indirect), 1e-8)
    assert model.report.error == pytest.approx(1, rel=1e-3), "nothing is left to learn from"
    notebook = el.TransferModel.fit(direct, indirect, notebook=True)
    assert np.isfinite(notebook.predict(3 * direct)).all()


def test_the_same_pair_twice_changes_nothing_and_predicts_itself():
    direct, indirect = oblong()
    twice = [np.concatenate([images, images]) for images in (direct, indirect)]
    model = el.TransferModel.fit(*twice, rank=36, ridge=0.0)
    np.testing.assert_array_less(relative_errors(model.predict(direct), indirect), 1e-6)
    # A copy says nothing of unseen lights.
    once = el.TransferModel.fit(direct, indirect, rank=36, ridge=0.0).report.unseen_errors
    np.testing.assert_allclose(model.report.unseen_errors, (*once, *once), rtol=1e-3)


def test_black_direct_images_are_left_out_and_noted():
    direct, indirect = (images.copy() for images in scene())
    direct[[3, 5]] = 0
    model = el.TransferModel.fit(direct, indirect, rank=32)
    kept = np.delete(np.arange(64), [3, 5])
    other = el.TransferModel.fit(direct[kept], indirect[kept], rank=32)
    new = room().direct[NEW]
    np.testing.assert_array_less(relative_errors(model.predict(new), other.predict(new)), 1e-4)
    assert (
        "2 images are left out, because direct is black; the first is image 3" in model.report.notes
    )
    assert len(model.report.unseen_errors) == 62


def test_darkness_gives_darkness(model):
    assert not model.predict(np.zeros((16, 16, 3))).any()
    other = el.TransferModel.fit(*scene(), notebook=True)
    assert not other.predict(np.zeros((16, 16, 3))).any()
    indirect = scene()[1].copy()
    indirect[4] = 0
    assert np.isfinite(el.TransferModel.fit(scene()[0], indirect).report.unseen_errors).all()


@pytest.mark.parametrize("notebook", [False, True])
def test_texels_that_are_always_black_are_not_kept(notebook):
    direct, indirect = oblong()
    masked = indirect.copy()
    masked[:, 2:5, 1:7] = 0
    model = el.TransferModel.fit(direct, masked, notebook=notebook)
    assert model.basis.shape[0] == 7 * 11 - 3 * 6
    assert not model.predict(direct)[:, 2:5, 1:7].any()
    assert not model.project(indirect)[:, 2:5, 1:7].any()
    if not notebook:
        predict = reference.channelwise(direct, masked, 36, 1e-3)
        truth = np.stack([predict(image) for image in direct])
        np.testing.assert_array_less(relative_errors(model.predict(direct), truth), 1e-9)


def test_brightness_is_kept_whatever_it_is():
    direct, indirect = scene()
    bright = el.TransferModel.fit(direct * 1e8, indirect * 1e8, rank=32)
    dim = el.TransferModel.fit(direct * 1e-8, indirect * 1e-8, rank=32)
    new = room().direct[NEW]
    np.testing.assert_array_less(relative_errors(bright.predict(new), dim.predict(new)), 1e-4)
    assert bright.predict(new).max() > 1, "nothing is clipped"


def test_alpha_is_dropped_and_noted(model):
    opaque = [np.concatenate([images, images[..., :1] > 9], axis=-1) for images in scene()]
    other = el.TransferModel.fit(*opaque, rank=32)
    notes = ("alpha of direct was dropped", "alpha of indirect was dropped")
    assert other.report.notes == (*notes, BLACK)
    np.testing.assert_array_equal(other.predict(opaque[0]), model.predict(scene()[0]))


@pytest.mark.parametrize("layout", ["fortran", "strided", "half", "lists"])
def test_any_array_of_floats_is_taken(layout):
    direct, indirect = (images[:8, :, :8].astype(np.float32) for images in scene())
    given = {
        "fortran": np.asfortranarray,
        "strided": lambda images: images.repeat(2, axis=2)[:, :, ::2],
        "half": lambda images: images.astype(np.float16),
        "lists": lambda images: images.tolist(),
    }[layout]
    model = el.TransferModel.fit(given(direct), given(indirect))
    other = el.TransferModel.fit(direct, indirect)
    np.testing.assert_array_less(
        relative_errors(model.predict(direct), other.predict(direct)), 1e-2
    )


def test_images_are_not_changed():
    before = [images.copy() for images in scene()]
    for notebook in (False, True):
        el.TransferModel.fit(*scene(), notebook=notebook)
    for images, old in zip(scene(), before, strict=True):
        np.testing.assert_array_equal(images, old)
