"""Share of each pixel that is seen: alpha, masked arrays, `seen`."""

import copy
import pickle

import numpy as np
import pytest

import envlights as el
from tests.reference import srgb

SKY = np.full((32, 64, 3), 0.25, np.float32)


def lower_half():
    share = np.ones((32, 64), np.float32)
    share[16:] = 0
    return share


def with_hidden_light():
    hidden = SKY.copy()
    hidden[16:] = 1e6
    return hidden


@pytest.mark.parametrize("hidden", [1e6, np.nan, np.inf, -3.0])
@pytest.mark.parametrize("kind", ["alpha", "mask", "mask of one channel", "seen"])
def test_what_is_hidden_is_no_light(kind, hidden):
    array, share = SKY.copy(), lower_half()
    array[16:] = hidden
    mask = np.zeros(array.shape, bool)
    mask[16:, :, slice(None) if kind == "mask" else slice(1)] = True
    env = {
        "alpha": lambda: el.EnvMap(np.dstack([array, share])),
        "seen": lambda: el.EnvMap(array, coverage=share),
    }.get(kind, lambda: el.EnvMap(np.ma.masked_array(array, mask)))()
    assert env.coverage_fraction == pytest.approx(0.5, abs=1e-6)
    np.testing.assert_array_equal(env.coverage, share)
    np.testing.assert_array_equal(env.radiance[16:], 0)
    np.testing.assert_array_equal(env.radiance[:16], SKY[:16])
    assert env.notes == ("50 % of the sphere is not seen",)
    # The closed form of the irradiance of half a sphere.
    np.testing.assert_allclose(
        env.probe([[0, -1, 0], [0, 1, 0]], fill="black")[:, 0], [0, 0.25 * np.pi], atol=1e-6
    )


def test_a_note_on_a_small_part_has_its_digits():
    """Four pixels at the horizon are a fraction of sin(pi / 32) / 32 of the sphere."""
    seen = np.zeros((32, 64))
    seen[15:17, :2] = 1
    assert el.EnvMap(SKY, coverage=seen).notes == ("99.7 % of the sphere is not seen",)


def test_partly_seen_pixels_are_multiplied_by_alpha_in_linear_light():
    codes = np.full((4, 8, 4), 188, np.uint8)
    codes[..., 3] = 51
    env = el.EnvMap(codes)
    np.testing.assert_allclose(env.radiance, 0.2 * srgb.decode(188 / 255), rtol=1e-5)
    assert env.coverage_fraction == pytest.approx(0.2)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32, np.float64])
def test_opaque_alpha_changes_nothing(dtype):
    most = 1 if np.dtype(dtype).kind == "f" else np.iinfo(dtype).max
    env = el.EnvMap(np.full((4, 8, 4), most, dtype))
    assert env.coverage is None
    assert env.coverage_fraction == 1.0
    assert not any("seen" in note for note in env.notes)


def test_the_share_survives_copies_and_turns_with_the_map():
    env = el.EnvMap(SKY, coverage=lower_half())
    for twin in (pickle.loads(pickle.dumps(env)), copy.deepcopy(env)):
        assert twin == env
        assert twin.notes == env.notes
    assert env != el.EnvMap(env.radiance)
    turned = env.rotated(np.diag([1.0, -1.0, -1.0]))
    np.testing.assert_allclose(turned.coverage, lower_half()[::-1], atol=1e-6)
    assert env.repaired().coverage_fraction == env.coverage_fraction
    # Half a sphere once counted as black without a word; now a fit asks what is there.
    notes = el.fit(env, lights=1, fill="black").notes
    assert any("not seen counts as black" in note for note in notes)
    with pytest.raises(ValueError, match="read-only"):
        env.coverage[0] = 0


@pytest.mark.parametrize(
    ("seen", "message"),
    [
        (np.ones((4, 4)), r"the shape \(32, 64\) of the pixels; got \(4, 4\)"),
        (np.full((32, 64), 1.5), "from 0 to 1; got 1.5 to 1.5"),
        (np.full((32, 64), np.nan), "from 0 to 1; got nan"),
        (np.zeros((32, 64)), "no pixel of the map is seen"),
        ("all", "coverage must be an array of numbers"),
    ],
)
def test_other_shares_are_refused(seen, message):
    with pytest.raises(el.EnvLightsError, match=message):
        el.EnvMap(SKY, coverage=seen)
