"""Our axes in the frame of each target."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from envlights.export import AXES

#: The 24 turns of a cube.
TURNS = Rotation.create_group("O").as_matrix()


@pytest.mark.parametrize("name", AXES)
def test_a_matrix_is_a_permutation_of_axes_with_signs(name):
    matrix = np.array(AXES[name].matrix)
    np.testing.assert_array_equal(matrix @ matrix.T, np.eye(3))
    assert AXES[name].handedness in (1, -1)
    # An image is not mirrored: what a target reads of it has the target's handedness.
    assert AXES[name].map is None or np.linalg.det(AXES[name].turn_of_map()) == pytest.approx(1)


@pytest.mark.parametrize("name", AXES)
@pytest.mark.parametrize("seed", range(5))
def test_angles_and_the_way_back_are_kept_under_24_rotations(name, seed):
    rng = np.random.default_rng(seed)
    direction = rng.normal(size=(5, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    for turn in TURNS:
        turned = direction @ turn.T
        there = AXES[name].to_target(turned)
        np.testing.assert_allclose(there @ there.T, direction @ direction.T, atol=1e-12)
        np.testing.assert_array_equal(AXES[name].from_target(there), turned)
        volume = np.linalg.det(there[:3]) / np.linalg.det(direction[:3])
        assert volume == pytest.approx(AXES[name].handedness)
        # The same turn, made in the target's own frame.
        own = np.array(AXES[name].matrix) @ turn @ np.transpose(AXES[name].matrix)
        np.testing.assert_allclose(there, AXES[name].to_target(direction) @ own.T, atol=1e-12)


@pytest.mark.parametrize("name", AXES)
def test_the_names_of_our_axes_are_the_columns_of_the_matrix(name):
    columns = [np.eye(3)["xyz".index(axis)] * float(f"{sign}1") for sign, axis in AXES[name].names]
    np.testing.assert_array_equal(np.transpose(columns), AXES[name].matrix)
