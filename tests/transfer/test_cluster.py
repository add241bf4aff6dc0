"""Indirect images as an array of Dask: the same models, block by block."""

from functools import partial

import numpy as np
import pytest

import envlights as el
from tests.helpers import oblong, pairs_of_room, relative_errors

dask = pytest.importorskip("dask")
da = pytest.importorskip("dask.array")

room = partial(pairs_of_room, 40, 32)
NEW = slice(32, None)


@pytest.fixture(autouse=True)
def small_blocks():
    """Blocks of few rows."""
    with dask.config.set({"array.chunk-size": "50 kB"}):
        yield


@pytest.mark.parametrize("chunks", [(1, 32, 32, 3), (32, 5, 32, 3), (7, 6, 9, 2)])
@pytest.mark.parametrize(
    "options", [{}, {"ridge": "loo"}, {"notebook": True}, {"nonnegative": True}]
)
def test_the_model_is_that_of_numpy(chunks, options):
    direct, indirect = room().direct[:32], room().indirect[:32]
    lazy = da.from_array(indirect, chunks=chunks)
    model = el.TransferModel.fit(direct, lazy, rank=24, **options)
    local = el.TransferModel.fit(direct, indirect, rank=24, **options)
    new = room().direct[NEW]
    np.testing.assert_array_less(relative_errors(model.predict(new), local.predict(new)), 1e-6)
    np.testing.assert_allclose(model.report.unseen_errors, local.report.unseen_errors, rtol=1e-4)
    np.testing.assert_array_equal(model.lit, local.lit)
    assert (model.basis.dtype, model.report.rank) == (local.basis.dtype, local.report.rank)


def test_blocks_are_many_and_each_holds_all_images(monkeypatch):
    shapes = []
    gram = el.transfer.training.cluster.local_gram.gram

    def record(pairs, centred):
        shapes.append(pairs.indirect.shape)
        return gram(pairs, centred)

    monkeypatch.setattr(el.transfer.training.cluster.local_gram, "gram", record)
    el.TransferModel.fit(room().direct, da.from_array(room().indirect, chunks=(3, 32, 32, 3)))
    assert len(shapes) > 5
    assert sum(shape[1] for shape in shapes) == 32
    assert {(shape[0], *shape[2:]) for shape in shapes} == {(40, 32, 3)}


@pytest.mark.parametrize("notebook", [False, True])
def test_doubles_black_texels_and_alpha_are_treated_alike(notebook):
    direct, indirect = oblong()
    indirect[:, 2:5, 1:7] = 0
    indirect = np.concatenate([indirect, np.ones((12, 7, 11, 1))], axis=-1)
    lazy = da.from_array(indirect, chunks=(5, 2, 11, 4))
    model = el.TransferModel.fit(da.from_array(direct), lazy, notebook=notebook)
    local = el.TransferModel.fit(direct, indirect, notebook=notebook)
    np.testing.assert_array_less(
        relative_errors(model.predict(direct), local.predict(direct)), 1e-9
    )
    assert model.report.notes == local.report.notes
    assert model.basis.shape == local.basis.shape == (7 * 11 - 3 * 6, model.report.rank)


def test_pairs_are_added_and_images_projected_as_well():
    direct, indirect = oblong()
    lazy = da.from_array(indirect, chunks=(5, 2, 11, 3))
    grown = el.TransferModel.fit(direct[:6], lazy[:6]).add(direct[6:], lazy[6:])
    whole = el.TransferModel.fit(direct, indirect)
    np.testing.assert_array_less(
        relative_errors(grown.predict(direct), whole.predict(direct)), 1e-9
    )
    np.testing.assert_array_equal(whole.project(lazy), whole.project(indirect))


def test_images_are_read_from_files_by_the_workers(tmp_path):
    paths = [tmp_path / f"{k}.exr" for k in range(40)]
    for path, image in zip(paths, room().indirect, strict=True):
        el.io.write_exr(path, image)
    read = dask.delayed(lambda path: el.io.read_image(path).pixels)
    lazy = da.stack([da.from_delayed(read(path), (32, 32, 3), np.float32) for path in paths])
    model = el.TransferModel.fit(room().direct, lazy)
    local = el.TransferModel.fit(room().direct, room().indirect)
    errors = relative_errors(model.predict(room().direct), local.predict(room().direct))
    np.testing.assert_array_less(errors, 1e-6)
    paths[30].write_bytes(paths[30].read_bytes()[:900])
    with pytest.raises(el.EnvLightsError, match=r"30\.exr"):
        el.TransferModel.fit(room().direct, lazy)


def nan_at_row_17(indirect):
    indirect = indirect.copy()
    indirect[3, 17, 2, 0] = np.nan
    return da.from_array(indirect)


@pytest.mark.parametrize(
    ("lazy", "message"),
    [
        (nan_at_row_17, r"^indirect must be finite; image 3 holds nan at row 17, column 2$"),
        (lambda images: 0 * da.from_array(images), r"indirect is black in every image"),
        (lambda images: da.from_array(images)[:31], r"the same number of images; got 40 and 31"),
        (lambda images: da.from_array(images)[0], r"indirect must have the shape"),
        (lambda images: da.from_array(images).astype(int), r"floating point; got the dtype int64"),
        (lambda images: (whole := da.from_array(images))[whole[:, 0, 0, 0] > 0], r"got \(nan, 32"),
    ],
)
def test_what_cannot_be_learnt_is_refused(lazy, message):
    with pytest.raises(el.EnvLightsError, match=message):
        el.TransferModel.fit(room().direct, lazy(room().indirect))


def test_tasks_and_refusals_travel_between_processes():
    lazy = da.from_array(room().indirect, chunks=(7, 16, 32, 3))
    with dask.config.set({"scheduler": "processes", "num_workers": 1}):
        model = el.TransferModel.fit(room().direct, lazy)
        with pytest.raises(el.EnvLightsError, match="image 3 holds nan at row 17"):
            el.TransferModel.fit(room().direct, nan_at_row_17(room().indirect))
    local = el.TransferModel.fit(room().direct, room().indirect)
    errors = relative_errors(model.predict(room().direct), local.predict(room().direct))
    np.testing.assert_array_less(errors, 1e-6)
