"""Models as files: round trips, refusals and full disks."""

import json
import tracemalloc
from functools import partial

import numpy as np
import pytest

import envlights as el
from tests.conftest import fills_a_disk
from tests.helpers import cuts, disk_that_is_full_after, pairs_of_room

room = partial(pairs_of_room, 64, 32)


def scene():
    return room().direct, room().indirect


@pytest.fixture(scope="module")
def model():
    return el.TransferModel.fit(*scene(), rank=32)


def test_parameters_may_be_numpys_own(tmp_path):
    model = el.TransferModel.fit(*scene(), rank=np.int64(8), ridge=np.float32(0.01))
    model.save(tmp_path / "model.npz")
    assert el.TransferModel.load(tmp_path / "model.npz").parameters["rank"] == 8
    assert el.TransferModel.fit(*scene(), rank=np.float32(0.9)).report.energy >= 0.9


@pytest.mark.parametrize("notebook", [False, True])
def test_saved_models_come_back_to_the_bit(tmp_path, notebook):
    model = el.TransferModel.fit(*scene(), ridge="loo", notebook=notebook)
    model.save(tmp_path / "model.npz")
    again = el.TransferModel.load(tmp_path / "model.npz")
    np.testing.assert_array_equal(again.predict(scene()[0]), model.predict(scene()[0]))
    assert again.report == model.report
    assert again.parameters == model.parameters
    assert [path.name for path in tmp_path.iterdir()] == ["model.npz"]
    with np.load(tmp_path / "model.npz", allow_pickle=False) as file:
        assert str(file["format"]) == "envlights transfer model"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"format": np.array("another")}, "is not a model"),
        ({"version": np.array(5)}, "version 5; this package reads 1, 2, 3, 4"),
        ({"version": np.array("1" * 5000)}, "a model without a readable version"),
        ({"basis": np.zeros((5, 2), np.float32)}, "does not hold a model: basis must hold"),
        ({"transfer": np.full((3, 256, 32), np.nan)}, "transfer must be finite"),
        (
            {"lit": np.zeros((16, 16), bool)},
            r"basis must .* \(0, 32\); got float32 .* \(1014, 32\)",
        ),
        ({"basis": np.full((1014, 32), np.nan, np.float32)}, "basis must be finite"),
        ({"basis": np.zeros((1014, 32), bool)}, "basis must hold float32 or float64 .* got bool"),
        ({"size": np.array([-16, -16])}, "size must be a whole number, 1 or more; got -16"),
        ({"report": np.array(json.dumps({"pairs": 1, "seconds": None}))}, "does not hold a model"),
        ({"report": np.array(json.dumps({"pairs": -1}))}, "pairs must be a whole number"),
        (
            {"parameters": np.array("{}")},
            "parameters must be error, nonnegative, prior, rank, ridge",
        ),
        ({"energy": None}, "does not hold a model: the entry 'energy' is missing"),
    ],
)
def test_impossible_files_are_refused(model, tmp_path, change, message):
    model.save(tmp_path / "model.npz")
    with np.load(tmp_path / "model.npz") as file:
        arrays = {**file, **change}
    np.savez(tmp_path / "bad.npz", **{k: v for k, v in arrays.items() if v is not None})
    with pytest.raises(el.EnvLightsError, match=message):
        el.TransferModel.load(tmp_path / "bad.npz")


def test_other_files_are_refused(model, tmp_path):
    model.save(tmp_path / "model.npz")
    whole = (tmp_path / "model.npz").read_bytes()
    (tmp_path / "cut.npz").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "text.npz").write_text("no model")
    (tmp_path / "empty.npz").write_text("")
    np.save(tmp_path / "array.npy", np.zeros(3))
    for name in ("cut.npz", "text.npz", "empty.npz", "array.npy", "none.npz"):
        with pytest.raises(el.EnvLightsError, match=rf"{name}"):
            el.TransferModel.load(tmp_path / name)
    with pytest.raises(el.EnvLightsError, match=r"the suffix must be \.npz"):
        model.save(tmp_path / "model.pkl")


@fills_a_disk
@pytest.mark.parametrize("notebook", [False, True])
def test_a_model_that_does_not_fit_on_the_disk_is_not_saved(tmp_path, notebook):
    model = el.TransferModel.fit(room().direct[:8], room().indirect[:8], notebook=notebook)
    target = tmp_path / "model.npz"
    model.save(target)
    whole = target.read_bytes()
    for cut in cuts(len(whole)):
        with (
            disk_that_is_full_after(cut),
            pytest.raises(el.EnvLightsError, match=r"cannot write .*model\.npz: File too large"),
        ):
            model.save(target)
        assert target.read_bytes() == whole
        assert [path.name for path in tmp_path.iterdir()] == ["model.npz"]


@pytest.mark.parametrize("seed", range(4))
def test_a_model_with_damaged_bytes_is_read_or_refused(tmp_path, seed):
    room = el.synthetic.room(4, width=16)
    model = el.TransferModel.fit(room.direct, room.indirect, rank=2)
    model.save(tmp_path / "model.npz")
    whole = (tmp_path / "model.npz").read_bytes()
    rng = np.random.default_rng(seed)
    # Where zipfile looks: the headers of the first arrays, and the table at the end.
    places = np.concatenate([rng.integers(0, 400, 150), rng.integers(-1500, 0, 150) + len(whole)])
    refused = 0
    for place in places:
        damaged = bytearray(whole)
        damaged[place] ^= 1 << rng.integers(8)
        (tmp_path / "damaged.npz").write_bytes(damaged)
        try:
            el.TransferModel.load(tmp_path / "damaged.npz")
        except el.EnvLightsError:
            refused += 1
    assert refused > 100


@pytest.mark.parametrize(
    "size", [[2.5, 2.5], [2**32, 1], [np.inf, 1], ["a", "b"], [True, False], [[16, 16]], 3]
)
def test_impossible_sizes_are_refused(model, tmp_path, size):
    model.save(tmp_path / "model.npz")
    with np.load(tmp_path / "model.npz") as file:
        np.savez(tmp_path / "bad.npz", **{**file, "size": np.array(size)})
    with pytest.raises(el.EnvLightsError, match="does not hold a model"):
        el.TransferModel.load(tmp_path / "bad.npz")


def test_only_what_a_model_has_is_unpacked(model, tmp_path):
    """Beside the model, and in place of a part of it, 64 MB of zeros that pack to 64 kB."""
    model.save(tmp_path / "model.npz")
    with np.load(tmp_path / "model.npz") as file:
        arrays = dict(file)
    zeros = np.zeros(2**23)
    np.savez_compressed(tmp_path / "beside.npz", **arrays, more=zeros)
    tracemalloc.start()
    try:
        again = el.TransferModel.load(tmp_path / "beside.npz")
        assert tracemalloc.get_traced_memory()[1] < zeros.nbytes / 4
    finally:
        tracemalloc.stop()
    np.testing.assert_array_equal(again.predict(scene()[0]), model.predict(scene()[0]))
    np.savez_compressed(tmp_path / "within.npz", **{**arrays, "mean": zeros})
    with pytest.raises(el.EnvLightsError, match=r"would unpack to 6.* which a model never needs"):
        el.TransferModel.load(tmp_path / "within.npz")
