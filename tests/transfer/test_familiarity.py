"""Unfamiliar lights: dense algebra, the greedy choice, the order of errors."""

from functools import partial

import numpy as np
import pytest

import envlights as el
from tests.helpers import pairs_of_room, relative_errors

room = partial(pairs_of_room, 80, 32)


@pytest.fixture(scope="module")
def model():
    return el.TransferModel.fit(room().direct[:40], room().indirect[:40])


def dense(pairs, image):
    """Unfamiliarity of one image (h, w, 3) after others (k, h, w, 3), by ridge regression."""
    total = 0.0
    for channel in range(3):
        X = pairs[..., channel].reshape(len(pairs), -1)
        X = X / np.linalg.norm(pairs.reshape(len(pairs), -1), axis=1)[:, None]
        x = image[..., channel].ravel() / np.linalg.norm(image)
        explained = X.T @ np.linalg.solve(X @ X.T + 1e-3 * np.eye(len(X)), X @ x)
        total += np.sum((x - explained) ** 2)
    return np.sqrt(total)


def test_unfamiliarity_is_the_residual_of_a_ridge_regression(model):
    direct = room().direct.astype(float)
    truth = [dense(direct[:40], image) for image in direct[40:]]
    np.testing.assert_allclose(model.unfamiliar(5 * direct[40:]), truth, rtol=1e-6)
    assert model.unfamiliar(direct[40]) == pytest.approx(truth[0])
    assert model.unfamiliar(0 * direct[40]) == 0


def test_unfamiliarity_orders_the_errors(model):
    new = slice(40, None)
    errors = relative_errors(model.predict(room().direct[new]), room().indirect[new])
    ranks = [
        np.argsort(np.argsort(each)) for each in (errors, model.unfamiliar(room().direct[new]))
    ]
    assert np.corrcoef(*ranks)[0, 1] > 0.7


def test_next_lights_are_each_the_most_unfamiliar_after_those_before(model):
    direct = room().direct.astype(float)
    # Mixtures become familiar once their parts are chosen.
    candidates = np.concatenate([direct[40:46], direct[40:46] + 0.3 * direct[46:52]])
    chosen = model.next_lights(candidates, count=5)
    known = direct[:40]
    for best in chosen:
        sizes = [dense(known, image) for image in candidates]
        assert best == np.argmax(sizes)
        known = np.concatenate([known, candidates[best : best + 1]])


def test_all_candidates_can_be_chosen_once(model):
    order = model.next_lights(np.repeat(room().direct[40:43], 2, axis=0), count=6)
    assert sorted(order) == list(range(6))
    assert len(model.next_lights(room().direct[40:43], count=0)) == 0


@pytest.mark.parametrize(
    ("count", "message"),
    [(4, "count must be at most the 3 candidates; got 4"), (-1, "count must be a whole number")],
)
def test_impossible_counts_are_refused(model, count, message):
    with pytest.raises(el.EnvLightsError, match=message):
        model.next_lights(room().direct[40:43], count)
