"""Priors from the geometry of a scene: closed forms, laws of light, and models around them."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import envlights as el
from envlights.transfer.training.around_prior import _best, _in_basis
from envlights.transfer.training.weights import weighted_regression
from tests.helpers import pairs_of_room, relative_errors
from tests.reference.rooms import room_prior

SIDE = 4


def furnace(albedo=0.5, irradiance=False):
    """A closed room without hidden parts, in which each texel sees all texels alike."""
    pixels = SIDE * SIDE
    return el.transfer.TransferPrior(
        hits=np.full((64, pixels), 4, np.uint16),
        rays=64,
        between=np.full((pixels, pixels), 1 / pixels),
        visible=np.ones(pixels),
        albedo=np.full((8, 8, 3), albedo),
        covered=np.ones((8, 8), bool),
        direct_albedo=np.full((pixels, 3), albedo),
        size=(SIDE, SIDE),
        irradiance=irradiance,
    )


@cache
def room():
    return pairs_of_room(80, 32), room_prior(32)


KNOWN, NEW = slice(0, 24), slice(24, None)


@cache
def model():
    pairs, prior = room()
    return el.TransferModel.fit(pairs.direct[KNOWN], pairs.indirect[KNOWN], prior=prior)


@pytest.mark.parametrize("irradiance", [False, True])
def test_constant_light_in_a_furnace_is_a_geometric_series(irradiance):
    """Each bounce keeps the albedo: indirect light is a / (1 - a) of the direct light."""
    prior = furnace(0.8, irradiance)
    np.testing.assert_allclose(prior.predict(np.ones((SIDE, SIDE, 3))), 4.0, rtol=1e-6)


def test_two_patches_exchange_light_for_ever():
    """Light returns with the factor a^2 f^2 for the form factor f and the albedo a."""
    f, a = 0.25, 0.6
    prior = el.transfer.TransferPrior(
        hits=np.array([[0, 1], [1, 0]], np.uint16),
        rays=4,
        between=np.array([[0, f], [f, 0]]),
        visible=np.ones(2),
        albedo=np.full((1, 2, 3), a),
        covered=np.ones((1, 2), bool),
        direct_albedo=np.full((2, 3), a),
        size=(1, 2),
    )
    one = np.zeros((1, 2, 3))
    one[0, 0] = 1
    series = 1 - (a * f) ** 2
    truth = [a * f * a * f / series, a * f / series]
    np.testing.assert_allclose(prior.predict(one)[0, :, 0], truth, rtol=1e-6)


def test_hidden_parts_of_a_texel_are_no_part_of_its_light():
    visible = np.ones(SIDE * SIDE)
    visible[3] = 0.5
    whole = replace(furnace(0.5), between=np.zeros((SIDE**2, SIDE**2)))
    half = replace(whole, visible=visible)
    light = np.random.default_rng(0).random((SIDE * SIDE, 3))
    mean = light * visible[:, None]
    seen = half.predict(mean.reshape(SIDE, SIDE, 3))
    np.testing.assert_allclose(seen, whole.predict(light.reshape(SIDE, SIDE, 3)), rtol=1e-6)


def test_form_factors_are_reciprocal():
    """Area times form factor is the same in both directions."""
    _, prior = room()
    area = np.zeros((16, 16))
    for k, chart in enumerate(el.synthetic.room_charts()):
        size = np.linalg.norm(np.cross(chart.rows, chart.columns)) / 16
        area[k // 4 * 4 : k // 4 * 4 + 4, k % 4 * 4 : k % 4 * 4 + 4] = size
    # A hidden point sends no rays, and receives none: count the points that do.
    flow = (area.ravel()[:, None] * prior.between).reshape(4, 4, 4, 4, 4, 4, 4, 4)
    flow = flow.sum(axis=(1, 3, 5, 7)).reshape(16, 16)
    assert np.linalg.norm(flow - flow.T) < 0.02 * np.linalg.norm(flow)
    np.testing.assert_allclose(prior.between.sum(axis=1), prior.visible, atol=0.05)


def test_a_prior_alone_predicts_the_room():
    pairs, prior = room()
    errors = prior.errors(pairs.direct, pairs.indirect)
    np.testing.assert_allclose(
        errors, relative_errors(prior.predict(pairs.direct), pairs.indirect), rtol=1e-5
    )
    assert np.median(errors) < 0.2


def test_a_model_around_a_prior_has_half_the_error_for_new_lights():
    pairs, _ = room()
    plain = el.TransferModel.fit(pairs.direct[KNOWN], pairs.indirect[KNOWN], ridge="loo")
    ours, theirs = (
        relative_errors(each.predict(pairs.direct[NEW]), pairs.indirect[NEW])
        for each in (model(), plain)
    )
    assert np.median(ours) < 0.5 * np.median(theirs)
    assert np.quantile(ours, 0.9) < 0.5 * np.quantile(theirs, 0.9)


def test_without_a_limit_of_rank_the_model_is_the_prior_and_a_ridge_on_its_remainder():
    pairs, prior = room()
    known, light = pairs.direct[KNOWN], pairs.indirect[KNOWN].astype(float)
    model = el.TransferModel.fit(known, light, rank=768, ridge=0.01, prior=prior)
    x = np.moveaxis(known, -1, 0).reshape(3, len(known), -1).astype(float)
    new = np.moveaxis(pairs.direct[NEW], -1, 0).reshape(3, -1, 256).astype(float)
    truth = prior.predict(pairs.direct[NEW]).astype(float)
    left = (light - prior.predict(known)).reshape(len(known), -1, 3)
    for c in range(3):
        # Weigh the texels, and count the noise of each image in proportion to its light.
        turned = x[c] * prior.strength[c] ** 2
        inner = turned @ x[c].T
        weights = new[c] @ turned.T @ np.linalg.inv(inner + 0.01 * np.diag(np.diag(inner)))
        truth[..., c] += (weights @ left[..., c]).reshape(truth.shape[:3])
    np.testing.assert_array_less(relative_errors(model.predict(pairs.direct[NEW]), truth), 1e-4)


def test_the_prior_in_a_basis_is_the_projection_of_its_images():
    pairs, prior = room()
    basis, lit = model().basis, model().lit
    matrix = _in_basis(prior, basis, lit)
    direct = pairs.direct[NEW].astype(float)
    rows = np.moveaxis(direct, -1, 1).reshape(len(direct), 3, -1)
    seen = np.einsum("kcs,csr->kcr", rows, matrix)
    images = np.moveaxis(prior.predict(direct), -1, 1)[:, :, lit]
    np.testing.assert_allclose(seen, images @ basis, atol=1e-4 * np.abs(seen).max())


def test_reported_errors_are_those_of_new_lights():
    """The mean over six sets of 24 pairs: that of one set varies by a quarter."""
    prior, ratios = room()[1], []
    for seed in range(6):
        pairs = el.synthetic.room(80, 32, seed)
        fit = el.TransferModel.fit(pairs.direct[KNOWN], pairs.indirect[KNOWN], prior=prior)
        true = relative_errors(fit.predict(pairs.direct[NEW]), pairs.indirect[NEW])
        ratios.append(fit.report.error / np.median(true))
    assert 0.95 < np.mean(ratios) < 1.25


def test_light_unlike_that_of_the_pairs_is_hardly_worse_than_by_the_prior_alone():
    """One texel after the other alone, as no lamp of the pairs lights it."""
    pairs, prior = room()
    alone = relative_errors(prior.predict(pairs.direct[NEW]), pairs.indirect[NEW])
    ours = relative_errors(model().predict(pairs.direct[NEW]), pairs.indirect[NEW])
    assert (ours / alone).max() < 1.5


def test_the_strength_of_a_direct_texel_is_the_norm_of_its_indirect_image():
    """It is exact for one bounce, where images of several texels do not add up."""
    prior = room()[1]
    first = replace(prior, between=np.zeros_like(prior.between))
    alone = np.zeros((4, 256, 3))
    some = np.arange(4) * 61
    alone[np.arange(4), some] = 1
    images = first.predict(alone.reshape(4, 16, 16, 3)).astype(float)
    np.testing.assert_allclose(
        np.linalg.norm(images, axis=(1, 2)), first.strength[:, some].T, rtol=1e-5
    )


def test_weights_are_those_by_which_the_remainder_was_made():
    """Random operators, with light from each direct texel equal or in proportion to weights."""
    rng = np.random.default_rng(1)
    direct, weights = rng.exponential(size=(24, 3, 64)) ** 3, np.ones((3, 64))
    weights[:, ::4] = 20
    solvers = [weighted_regression(direct, each) for each in (weights, np.ones_like(weights))]
    for made_by, solver in zip((weights, np.ones_like(weights)), solvers, strict=True):
        images = np.einsum("kcs,csp->kcp", direct * made_by, rng.normal(size=(3, 64, 200)))
        energy = np.sum(images**2, axis=(1, 2))
        assert _best(solvers, (0.01, 0.1), images, energy)[0] is solver


def test_leave_one_out_errors_are_those_of_fits_without_each_image():
    rng = np.random.default_rng(0)
    direct, images = rng.random((6, 3, 9)), rng.normal(size=(6, 3, 5))
    direct[2, 1] = 0  # one black channel
    weights = rng.random((3, 9))
    whole = weighted_regression(direct, weights)
    missed = whole.left_out(0.1, images)
    for k in range(6):
        others = np.delete(np.arange(6), k)
        part = weighted_regression(direct[others], weights)
        matrix = part.transfer(0.1, images[others])
        seen = np.einsum("cs,csr->cr", direct[k], matrix)
        np.testing.assert_allclose(missed[k], images[k] - seen, atol=1e-9)
        shares = part.shares(0.1, direct[k : k + 1])
        np.testing.assert_allclose(
            np.einsum("ck,kcr->cr", shares[:, 0], images[others]), seen, atol=1e-9
        )


def test_the_rank_leaves_out_less_than_the_error():
    report = model().report
    assert "the basis leaves out" in report.notes[0]
    assert report.rank < 256
    pairs, _ = room()
    truth = pairs.indirect[NEW]
    lost = relative_errors(model().project(truth), truth)
    assert np.median(lost) < report.error


def test_light_is_linear_and_no_light_is_black():
    one, two = room()[0].direct[40:42].astype(float)
    for each in (model(), room()[1]):
        together = each.predict(2 * one + two)[None]
        apart = 2 * each.predict(one).astype(float) + each.predict(two)
        assert relative_errors(together, apart[None])[0] < 1e-6
        assert not each.predict(0 * one).any()


def test_permuted_channels_give_permuted_images():
    pairs, prior = room()
    order = [2, 0, 1]
    turned = replace(
        prior, albedo=prior.albedo[..., order], direct_albedo=prior.direct_albedo[:, order]
    )
    known = (each[KNOWN][..., order] for each in (pairs.direct, pairs.indirect))
    other = el.TransferModel.fit(*known, prior=turned)
    seen = other.predict(pairs.direct[NEW][..., order])
    truth = model().predict(pairs.direct[NEW])[..., order]
    np.testing.assert_array_less(relative_errors(seen, truth), 1e-3)


def test_a_prior_of_another_scene_is_told_by_its_own_error():
    pairs, prior = room()
    other = np.roll(np.arange(len(prior.hits)), 700)
    wrong = replace(prior, hits=prior.hits[other])
    report = el.TransferModel.fit(pairs.direct[KNOWN], pairs.indirect[KNOWN], prior=wrong).report
    assert any("the prior does not describe the pairs" in note for note in report.notes)
    assert "prior alone" in str(report)


def test_priors_and_models_are_saved_and_read(tmp_path):
    prior = room()[1]
    prior.save(tmp_path / "prior.npz")
    assert el.transfer.TransferPrior.load(tmp_path / "prior.npz") == prior
    model().save(tmp_path / "model.npz")
    assert el.TransferModel.load(tmp_path / "model.npz") == model()
    with pytest.raises(el.EnvLightsError, match="is not a model"):
        el.TransferModel.load(tmp_path / "prior.npz")
    with pytest.raises(el.EnvLightsError, match="is not a prior"):
        el.transfer.TransferPrior.load(tmp_path / "model.npz")


def test_one_pair_is_enough():
    pairs, prior = room()
    one = el.TransferModel.fit(pairs.direct[:1], pairs.indirect[:1], prior=prior)
    new = pairs.direct[NEW], pairs.indirect[NEW]
    errors = relative_errors(one.predict(new[0]), new[1])
    assert np.median(errors) < 1.2 * np.median(prior.errors(*new))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"prior": 3}, "prior must be a TransferPrior; got an object of the type int"),
        ({"nonnegative": True}, "nonnegative=True and prior exclude each other"),
        ({"notebook": True}, "notebook=True and prior exclude each other"),
        ({"prior": None, "virtual": np.ones((1, 16, 16, 3))}, "virtual lights need a prior"),
        ({"virtual": np.ones((1, 8, 8, 3))}, "virtual must be 16x16 pixels, as in the prior"),
        ({"prior": furnace()}, "direct must be 4x4 pixels, as in the prior; got 16x16"),
    ],
)
def test_what_does_not_fit_the_pairs_is_refused(options, message):
    pairs, prior = room()
    with pytest.raises(el.EnvLightsError, match=message):
        el.TransferModel.fit(pairs.direct, pairs.indirect, **{"prior": prior, **options})


def test_black_indirect_images_are_refused_with_and_without_a_prior():
    pairs, prior = room()
    for each in (None, prior):
        with pytest.raises(el.EnvLightsError, match=r"^indirect is black in every image; there"):
            el.TransferModel.fit(pairs.direct[:8], 0 * pairs.indirect[:8], prior=each)


def test_pairs_that_are_those_of_the_prior_change_nothing():
    direct = np.eye(4, SIDE * SIDE).reshape(4, SIDE, SIDE, 1) * [1.0, 0, 0]
    model = el.TransferModel.fit(direct, furnace().predict(direct), prior=furnace())
    assert model.report.error == 0
    light = np.random.default_rng(0).random((SIDE, SIDE, 3))
    np.testing.assert_allclose(model.predict(light), furnace().predict(light), rtol=1e-5)


@pytest.mark.parametrize("brightness", [1e40, 1e308])
def test_light_beyond_single_precision_is_refused(brightness):
    light = np.ones((SIDE, SIDE, 3))
    assert np.isfinite(furnace().predict(1e37 * light)).all()
    with pytest.raises(el.EnvLightsError, match=r"too bright: .* the prior holds values up to"):
        furnace().predict(brightness * light)


def test_a_model_with_a_prior_does_not_grow():
    pairs, _ = room()
    with pytest.raises(el.EnvLightsError, match="a model with a prior cannot grow"):
        model().add(pairs.direct[:1], pairs.indirect[:1])


def test_albedo_that_never_fades_is_refused():
    with pytest.raises(el.EnvLightsError, match=r"albedo must be from 0 to below 1.*to 1;"):
        furnace(1.0)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"between": np.full((16, 16), -5.0)}, "between must be from 0 to 1"),
        ({"between": np.eye(16) * 2}, "between must be from 0 to 1.* 0 to 2"),
        ({"between": np.full((16, 16), 0.1)}, "sum of a row of between .* 0 to 1.6"),
        ({"between": np.full((16, 16), np.nan)}, "between must be from 0 to 1"),
        ({"visible": -np.ones(16)}, "visible must be from 0 to 1.*from -1"),
        ({"visible": np.full(16, 1.5)}, "visible must be from 0 to 1"),
        ({"rays": 63}, "sum of a row of hits over rays must be from 0 to 1"),
    ],
)
def test_fractions_that_are_none_are_refused(changes, message):
    with pytest.raises(el.EnvLightsError, match=message):
        replace(furnace(), **changes)


@pytest.mark.parametrize("visible", [1e-300, 1e-3, 0.5])
def test_light_that_would_not_fade_is_refused(visible):
    """A furnace of albedo a reflects a / v of its light: from 1 on the sum of bounces diverges."""
    prior = replace(furnace(0.5), visible=np.full(16, visible))
    with pytest.raises(el.EnvLightsError, match="light among the direct texels would not fade"):
        prior.predict(np.ones((SIDE, SIDE, 3)))
    half = replace(furnace(0.5), visible=np.full(16, 0.8)).predict(np.ones((SIDE, SIDE, 3)))
    np.testing.assert_allclose(half, 0.5 / 0.8 / (1 - 0.5 / 0.8), rtol=1e-6)


def test_pairs_of_noise_hardly_change_a_prior_and_a_note_says_when_they_do():
    pairs, prior = room()
    direct, light = pairs.direct[:6], pairs.indirect[:6].astype(float)
    noise = np.random.default_rng(0).normal(size=light.shape)
    noisy = light + np.sqrt((light**2).mean()) * noise
    chosen = el.TransferModel.fit(direct, noisy, prior=prior, rank=512)
    # The correction of the prior, in its basis, is below a thousandth of it.
    matrix = _in_basis(prior, chosen.basis, chosen.lit)
    assert np.linalg.norm(chosen.transfer - matrix) < 1e-3 * np.linalg.norm(matrix)
    given = el.TransferModel.fit(direct, noisy, prior=prior, ridge=1e-6).report
    assert any("the pairs make the prior worse" in note for note in given.notes)
    assert not any("worse" in note for note in model().report.notes)


@pytest.mark.parametrize("noise", [0.3, 1.0])
def test_pairs_of_noise_leave_the_prior_alone_which_is_said_and_true(noise):
    """The errors are those for new lights, whose images have no noise."""
    pairs, prior = room()
    light = pairs.indirect[:4].astype(float)
    random = np.random.default_rng(1).normal(size=light.shape)
    noisy = light + noise * np.sqrt((light**2).mean()) * random
    chosen = el.TransferModel.fit(pairs.direct[:4], noisy, prior=prior)
    assert any("the prior alone was kept" in note for note in chosen.report.notes)
    direct, truth = pairs.direct[NEW], pairs.indirect[NEW]
    ours, alone = (
        np.median(relative_errors(each.predict(direct), truth)) for each in (chosen, prior)
    )
    # 256 directions of the prior, and no direction of noise.
    assert ours < 1.05 * alone
    assert not any("alone was kept" in note for note in model().report.notes)
