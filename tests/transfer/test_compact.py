"""Faster frames: kernels against NumPy, rounded bases, frames that stop early, parts of frames."""

from dataclasses import replace
from functools import cache, partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import envlights as el
from envlights.transfer import compact
from tests.helpers import pairs_of_room, printed_by_threads, relative_errors

room = partial(pairs_of_room, 48, 64)


def new():
    return room().direct[40:]


@cache
def indirect_light():
    """Images with a border and a pillar that are black, and no whole number of tiles."""
    images = room().indirect[:40, :, :61].copy()
    images[:, :7] = 0
    images[:, 30:40, 20:55] = 0
    return images


@pytest.fixture(scope="module")
def model():
    return el.TransferModel.fit(room().direct[:40], indirect_light(), rank=24)


@pytest.fixture(scope="module")
def both(model):
    """In bytes and in halves."""
    return [model.compressed(error) for error in (0.02, 0.001)]


def test_large_images_are_learnt_by_the_kernels_as_by_numpy():
    """Over 2^16 texels float32 goes through the kernels, float64 does not."""
    rng = np.random.default_rng(0)
    direct = rng.random((7, 4, 4, 3))
    shares = rng.gamma(1, 1, (7, 3, 21)) * np.geomspace(1, 0.1, 21)
    indirect = np.moveaxis(np.tensordot(shares, rng.random((21, 256, 261)), 1), 1, -1)
    indirect[:, 40:50, 30:] = 0
    alpha = np.concatenate([indirect, indirect[..., :1]], axis=-1).astype(np.float32)
    for notebook in (False, True):
        wanted = el.TransferModel.fit(direct, indirect, rank=12, notebook=notebook)
        found = el.TransferModel.fit(direct, alpha, rank=12, notebook=notebook)
        np.testing.assert_array_equal(found.lit, wanted.lit)
        assert relative_errors(found.predict(direct), wanted.predict(direct)).max() < 1e-5
        assert found.report.energy == pytest.approx(wanted.report.energy, abs=1e-7)
        assert found.report.error == pytest.approx(wanted.report.error, rel=1e-4)
    grown = [
        el.TransferModel.fit(direct[:4], images[:4], rank=12).add(direct[4:], images[4:])
        for images in (alpha, indirect)
    ]
    # What the old basis leaves of the new images cancels in float32; NumPy is off by 3e-4 as well.
    assert relative_errors(*(model.predict(direct) for model in grown)).max() < 1e-3


def test_any_number_of_threads_gives_the_same_bits():
    script = """
import hashlib
import numpy as np
import envlights as el
rng = np.random.default_rng(0)
direct, indirect = rng.random((5, 4, 4, 3)), rng.random((5, 256, 300, 3), np.float32)
model = el.TransferModel.fit(direct, indirect, rank=8).compressed(0.1)
print(hashlib.sha256(model.predict(direct).tobytes()).hexdigest())
"""
    assert len(printed_by_threads(script)) == 1


BASES = hnp.arrays(
    np.float32,
    st.tuples(st.integers(1, 90), st.integers(1, 3)),
    elements=st.floats(-1, 1, width=32).map(lambda value: 0.0 if abs(value) < 1e-6 else value),
)


@given(BASES, st.sampled_from(list(compact.LARGEST)))
@settings(max_examples=60)
def test_values_are_rounded_by_half_a_step_at_most(basis, dtype):
    lit = np.ones((1, len(basis)), bool)
    kept, wrong = compact.round_basis(basis, lit, dtype)
    change = np.abs(kept.dense(lit) - basis)
    for first in range(0, len(basis), 16):
        largest = np.abs(basis[first : first + 16]).max(axis=0)
        # Half a step of 127 to the largest; 11 digits of the value, or 24 places under the largest.
        own = np.abs(basis[first : first + 16])
        step = largest / 254 if dtype == "int8" else np.maximum(own * 2**-11, largest * 2**-25)
        assert (change[first : first + 16] <= step * (1 + 1e-4)).all()
    exact = (kept.dense(lit).astype(float) - basis).T @ (kept.dense(lit).astype(float) - basis)
    np.testing.assert_allclose(wrong, exact, atol=1e-6)


def test_large_bases_are_rounded_as_small_ones():
    """Several blocks, the last one partial, with holes."""
    rng = np.random.default_rng(0)
    lit = rng.random((150, 131)) < 0.9
    lit[40:45] = False
    basis = rng.normal(size=(np.count_nonzero(lit), 3)).astype(np.float32)
    kept, wrong = compact.round_basis(basis, lit, "int8")
    change = kept.dense(lit).astype(float) - basis
    np.testing.assert_allclose(wrong, change.T @ change, rtol=1e-5, atol=1e-5 * wrong.max())
    assert np.abs(change).max() <= np.abs(basis).max() / 254 * (1 + 1e-4)


def test_blocks_that_are_black_altogether_take_no_place():
    """More black rows above than one block of texels holds."""
    rng = np.random.default_rng(0)
    lit = np.zeros((300, 100), bool)
    lit[200:250] = True
    basis = rng.normal(size=(np.count_nonzero(lit), 3)).astype(np.float32)
    kept, wrong = compact.round_basis(basis, lit, "int8")
    change = kept.dense(lit).astype(float) - basis
    np.testing.assert_allclose(wrong, change.T @ change, rtol=1e-5, atol=1e-5 * wrong.max())


@pytest.mark.parametrize("dtype", list(compact.LARGEST))
def test_what_needs_no_rounding_comes_back(dtype):
    steps = np.random.default_rng(0).integers(-127, 128, (70, 3))
    steps[::16] = 127
    basis = (steps * np.float32(2.0**-9)).astype(np.float32)
    lit = np.ones((7, 10), bool)
    kept, wrong = compact.round_basis(basis, lit, dtype)
    assert kept.values.dtype == dtype
    if dtype == "int8":
        np.testing.assert_array_equal(kept.dense(lit), basis)
        assert not wrong.any()
    np.testing.assert_allclose(kept.dense(lit), basis, rtol=2**-11)


def test_black_texels_stay_black(model, both):
    for kept in both:
        assert not kept.predict(new())[:, ~model.lit].any()
        assert kept.basis.values.shape[0] < model.lit.size / compact.TILE - 10
        assert kept.basis.dense(model.lit).shape == model.basis.shape


def test_frames_are_the_sums_over_the_rounded_basis(model, both):
    rng = np.random.default_rng(0)
    coefficients = rng.normal(size=(3, 3, 24))
    for kept in both:
        dense = kept.basis.dense(model.lit).astype(float)
        for components in (24, 5, 0):
            first = coefficients[..., :components]
            found = kept.basis.expand(first, model.lit.shape, None)
            wanted = np.einsum("tr,ncr->ntc", dense[:, :components], first)
            np.testing.assert_allclose(found[:, model.lit], wanted, atol=1e-6)


def test_the_most_compact_type_that_keeps_the_bound_is_taken(model):
    assert model.compressed(0.02).basis.values.dtype == np.int8
    assert model.compressed(0.001).basis.values.dtype == np.float16
    _, wrong = compact.round_basis(model.basis, model.lit, "int8")
    most = np.sqrt(np.linalg.eigvalsh(wrong)[-1])
    assert model.compressed(most * 1.0001).basis.values.dtype == np.int8
    assert model.compressed(most * 0.9999).basis.values.dtype == np.float16
    assert f"more than {100 * most:.2g} % of" in model.compressed(0.02).report.notes[-1]
    as_it_is = model.compressed(1e-6)
    assert as_it_is.basis is model.basis
    assert (
        as_it_is.report.notes[-1]
        == "the basis is not compressed: int8 and float16 exceed the error 1e-06"
    )
    assert (
        model.compressed(0.02).report.notes[-1].startswith("the basis is stored as int8: no frame")
    )


@pytest.mark.parametrize("dtype", list(compact.LARGEST))
def test_the_bound_holds_and_is_reached(model, dtype):
    """By the frame of the largest singular vector, and by no other."""
    kept, wrong = compact.round_basis(model.basis, model.lit, dtype)
    values, vectors = np.linalg.eigh(wrong)
    others = np.random.default_rng(0).normal(size=(20, 24))
    change = kept.dense(model.lit).astype(float) - model.basis
    for coefficients in (*others, *vectors.T):
        error = np.linalg.norm(change @ coefficients) / np.linalg.norm(coefficients)
        assert error <= np.sqrt(values[-1]) * (1 + 1e-6)
    assert error == pytest.approx(np.sqrt(values[-1]), rel=1e-6)


def test_compressed_frames_stay_in_the_bound_and_learnt_ones_in_the_usual_error(model, both):
    for kept, bound in zip(both, (0.02, 0.001), strict=True):
        assert relative_errors(kept.predict(new()), model.predict(new())).max() <= bound
        whole, rounded = (each.project(indirect_light()) for each in (model, kept))
        note = kept.report.notes[-1]
        usual = float(note.rsplit("by ", 1)[1].split()[0]) / 100
        scale = 1 / np.linalg.norm(room().direct[:40].reshape(40, -1), axis=1)[:, None, None, None]
        changed = np.linalg.norm((rounded - whole) * scale) / np.linalg.norm(whole * scale)
        assert changed == pytest.approx(usual, rel=0.1)


def test_a_batch_is_its_frames_to_the_bit(both):
    for kept in both:
        for error in (0.0, 0.05):
            frames = [kept.predict(frame, error=error) for frame in new()]
            np.testing.assert_array_equal(kept.predict(new(), error=error), frames)


REGIONS = [
    (slice(0, 5), slice(0, 9)),
    (slice(20, 47), slice(13, 14)),
    (slice(-3, None), slice(None, None, 3)),
    (slice(None), slice(None)),
    (slice(9, 9), slice(4)),
]


@pytest.mark.parametrize("region", REGIONS)
def test_a_region_is_the_crop_of_the_frame_to_the_bit(model, both, region):
    for each in (model, *both):
        for error in (0.0, 0.05):
            whole = each.predict(new(), error=error)
            part = each.predict(new(), error=error, region=region)
            np.testing.assert_array_equal(part, whole[(slice(None), *region)])
        one = each.predict(new()[0], region=region)
        np.testing.assert_array_equal(one, each.predict(new()[0])[region])


def test_large_regions_are_the_crop_too():
    """Several blocks of texels; the region needs some of them."""
    rng = np.random.default_rng(0)
    direct, indirect = rng.random((4, 2, 2, 3)), rng.random((4, 150, 100, 3), np.float32)
    indirect[:, 60:62] = 0
    model = el.TransferModel.fit(direct, indirect)
    region = (slice(63, 90), slice(10, 20))
    for each in (model, model.compressed(0.1)):
        np.testing.assert_array_equal(
            each.predict(direct, region=region), each.predict(direct)[:, 63:90, 10:20]
        )


@pytest.mark.parametrize("error", [0.3, 0.05, 0.01])
def test_a_frame_that_stops_early_stays_in_its_error(model, both, error):
    for each in (model, *both):
        early = relative_errors(each.predict(new(), error=error), each.predict(new()))
        # As much as the columns of the basis miss right angles, and rounding turns them.
        assert (early <= error * 1.01).all()
        assert early.max() > 0, "something was left out"


def test_frames_stop_at_the_first_component_that_will_do():
    """Squares 16, 8, 4, 2, 1 of 31: without the last two 3/31 are gone, without three 7/31."""
    from envlights.transfer.expand import truncate

    coefficients = np.sqrt([16.0, 8, 4, 2, 1])[None, None] * np.ones((2, 3, 1)) / np.sqrt(3)
    coefficients[1, :, 2:] = 0
    for left_out, components in [(0, 5), (0.5, 5), (1, 4), (3, 3), (7, 2), (30.9, 1), (31, 0)]:
        found = truncate(coefficients[:1], np.sqrt(left_out * (1 + 1e-9) / 31))
        np.testing.assert_array_equal(found, coefficients[:1, :, :components])
    together = truncate(coefficients, np.sqrt(1.01 / 31))
    np.testing.assert_array_equal(together, coefficients[..., :4])
    together = truncate(coefficients, np.sqrt(8.01 / 24))
    assert (together[1, :, 1:] == 0).all(), "each frame stops for itself"
    assert (together[0, :, 1] != 0).all()


def test_frames_of_any_brightness_stop_at_the_same_component():
    direct, indirect = (images[:40].astype(float) for images in (room().direct, room().indirect))
    model = el.TransferModel.fit(direct, indirect, rank=24)
    plain = model.predict(new(), error=0.05)
    for stops in (-800, 400):
        seen = model.predict(np.ldexp(new().astype(float), stops), error=0.05)
        np.testing.assert_array_equal(np.ldexp(seen, -stops), plain)


def test_no_direction_is_an_empty_stack(model, both):
    for each in (model, *both):
        assert each.directions(0).shape == (0, 64, 61)


def test_darkness_needs_no_component(model, both):
    for each in (model, *both):
        assert not each.predict(np.zeros((16, 16, 3)), error=0.05).any()


def test_compressed_models_are_saved_whole(both, tmp_path):
    for kept in both:
        kept.save(tmp_path / "model.npz")
        again = el.TransferModel.load(tmp_path / "model.npz")
        np.testing.assert_array_equal(again.predict(new()), kept.predict(new()))
        np.testing.assert_array_equal(
            again.project(indirect_light()), kept.project(indirect_light())
        )
        assert again.report == kept.report


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"scales": np.ones((5, 24, 2), np.float32)}, "scales must hold float32"),
        (
            {"basis": np.zeros((90, 24, 16), np.int8)},
            r"basis must hold int8 or float16 .* 32\); got int8 .* 16\)",
        ),
        (
            {"basis": np.zeros((90, 24, 32), np.int16)},
            "basis must hold int8 or float16 .* got int16",
        ),
        ({"lit": np.ones((64, 61), bool)}, r"basis must hold .* \(122, 24, 32\); got"),
        ({"lit": np.zeros((64, 61), bool)}, r"basis must hold .* \(0, 24, 32\); got"),
        ({"scales": None}, "does not hold a model: basis must hold float32 or float64"),
        ({"scales": "nan"}, "scales must be finite"),
    ],
)
def test_impossible_files_are_refused(both, tmp_path, change, message):
    both[0].save(tmp_path / "model.npz")
    with np.load(tmp_path / "model.npz") as file:
        arrays = dict(file)
    for name, value in change.items():
        arrays[name] = np.full_like(arrays[name], np.nan) if isinstance(value, str) else value
    arrays = {name: array for name, array in arrays.items() if array is not None}
    np.savez(tmp_path / "bad.npz", **arrays)
    with pytest.raises(el.EnvLightsError, match=message):
        el.TransferModel.load(tmp_path / "bad.npz")


def test_a_compact_basis_of_other_tiles_is_refused(both):
    basis = both[0].basis
    moved = replace(basis, places=np.roll(basis.places, 1))
    for change, message in [
        ({"basis": moved}, "places of the basis must be the tiles in which lit has texels"),
        ({"basis": replace(basis, scales=basis.scales[:-1])}, r"scales must hold float32 .* got"),
        ({"lit": np.ones_like(both[0].lit)}, r"basis must .* \(122, 24, 32\); got int8"),
    ]:
        with pytest.raises(el.EnvLightsError, match=message):
            replace(both[0], **change)


def test_what_cannot_be_is_refused_in_a_sentence(model, both):
    around_a_mean = el.TransferModel.fit(
        room().direct[:40], indirect_light(), rank=4, notebook=True
    )
    for call, message in [
        (
            lambda: model.predict(new(), error=-1),
            "error must be a finite .*, from 0 to 1 \\(1 is 100 %\\); got -1",
        ),
        (lambda: model.predict(new(), error=np.nan), "error must be a finite number"),
        (lambda: model.predict(new(), region=(3, 4)), r"region must be two slices.*; got \(3, 4\)"),
        (lambda: model.predict(new(), region=slice(3)), "region must be two slices"),
        (lambda: model.predict(new(), region=(slice(3),)), "region must be two slices"),
        (lambda: model.predict(new(), region=(slice(0.5), slice(3))), "region must be two slices"),
        (lambda: model.predict(new(), region=(slice(0, 3, 0), slice(3))), "region must be two"),
        (lambda: model.compressed(-0.1), "error must be a finite number, 0 or more; got -0.1"),
        (lambda: both[0].compressed(), "a compressed model cannot be compressed again; use"),
        (lambda: both[0].add(new(), new()), "a compressed model cannot take more pairs"),
        (lambda: both[0].predict(new() * np.nan), "direct must be finite; image 0 holds nan"),
        (lambda: both[0].predict(new()[:, :4]), "direct must be 16x16 pixels"),
        (lambda: around_a_mean.compressed(), "notebook=True cannot be compressed; fit without it"),
        (lambda: around_a_mean.predict(new(), error=0.1), "notebook=True cannot leave directions"),
    ]:
        with pytest.raises(el.EnvLightsError, match=message) as refusal:
            call()
        assert "\n" not in str(refusal.value)
