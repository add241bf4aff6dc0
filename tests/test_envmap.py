"""Maps from arrays: values that are unchanged, cleaned or refused."""

import numpy as np
import pytest

import envlights as el
from tests.reference import srgb

RADIANCE = np.random.default_rng(1).gamma(0.5, 2.0, size=(16, 32, 3)).astype(np.float32)


def test_float32_arrays_are_not_copied():
    array = RADIANCE.copy()
    env = el.EnvMap(array)
    assert np.shares_memory(env.radiance, array)
    assert not env.radiance.flags.writeable
    array.flags.writeable = False
    assert np.shares_memory(el.EnvMap(array).radiance, array)


@pytest.mark.parametrize(
    "array",
    [
        RADIANCE.astype(np.float64),
        RADIANCE.astype(np.longdouble),
        RADIANCE.astype(">f4"),
        np.asfortranarray(RADIANCE),
        RADIANCE.repeat(2, axis=1)[:, ::2],
        RADIANCE.tolist(),
    ],
    ids=["float64", "longdouble", "big-endian", "fortran", "strided", "lists"],
)
def test_any_floating_point_array_like_gives_the_same_map(array):
    env = el.EnvMap(array)
    assert env.radiance.dtype == np.float32
    assert env.radiance.flags.c_contiguous
    assert not env.radiance.flags.writeable
    np.testing.assert_array_equal(env.radiance, RADIANCE)


def test_a_black_map_is_a_map():
    env = el.EnvMap(np.zeros((4, 8, 3)))
    assert env.notes == ()
    np.testing.assert_array_equal(env.probe([[0, 1, 0]]), 0)


def test_a_note_may_be_given_as_text():
    assert el.EnvMap(RADIANCE, notes="from the stage").notes == ("from the stage",)


def test_codes_are_read_in_either_byte_order():
    codes = np.arange(4 * 8 * 3).reshape(4, 8, 3) * 600
    little, big = (el.EnvMap(codes.astype(order)) for order in ("<u2", ">u2"))
    np.testing.assert_array_equal(little.radiance, big.radiance)
    assert little.notes == big.notes == ("uint16 samples were decoded from sRGB",)


def test_integer_arrays_are_taken_as_srgb_and_noted():
    codes = np.full((4, 8, 3), 188, np.uint8)
    env = el.EnvMap(codes)
    np.testing.assert_allclose(env.radiance, srgb.decode(188 / 255), rtol=1e-6)
    assert env.notes == ("uint8 samples were decoded from sRGB",)


def test_unusable_samples_are_cleaned_and_counted():
    array = np.ones((4, 8, 3))
    array[0, 0] = np.nan, np.inf, -1
    array[1, 1] = -np.inf, 5, 1e300
    env = el.EnvMap(array)
    np.testing.assert_allclose(env.radiance[0, 0], [6 / 7, 65504, 0], rtol=0.2)
    np.testing.assert_array_equal(env.radiance[1, 1], [0, 5, 65504])
    assert env.notes == (
        "2 negative samples set to 0",
        "2 infinite samples set to 65504 and counted as clipped",
        "1 NaN sample set to the mean of the neighbours",
    )
    assert np.isnan(array[0, 0, 0]), "the caller's array was changed"


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (np.ones(8), r"shape \(height, width, 3\), or \(height, width\) for grey; got \(8,\)"),
        (np.ones((4, 8, 2)), r"got \(4, 8, 2\)"),
        (np.ones((4, 8, 3, 1)), r"got \(4, 8, 3, 1\)"),
        (np.ones((8, 8, 3)), r"twice as wide as high; got 8x8"),
        (np.ones((1, 2, 3)), r"at least 4x2 pixels; got 2x1"),
        (np.ones((2, 1, 3)), r"twice as wide as high; got 1x2"),
        (np.ones((0, 0, 3)), r"at least 4x2 pixels; got 0x0"),
        (np.ones((4, 8, 3), complex), r"got the dtype complex128"),
        (np.ones((4, 8, 3), bool), r"got the dtype bool"),
        (np.ones((4, 8, 3), np.int32), r"got the dtype int32"),
        ([[1, 2], [3]], r"a map must be an array of numbers"),
        ("hall.exr", r"`EnvMap.open` reads files; got 'hall.exr'"),
        (None, r"a map must be an array of numbers; got NoneType"),
        (el.Lights([[0, 1, 0]], [[1, 1, 1]]), r"an array of numbers; got Lights"),
        (np.full((4, 8, 3), np.nan), r"no finite sample"),
    ],
)
def test_arrays_that_are_no_map_are_refused(array, message):
    with pytest.raises(el.EnvLightsError, match=message):
        el.EnvMap(array)


@pytest.mark.parametrize(
    ("name", "wanted"), [("projection", "spherical"), ("registration", "middle")]
)
def test_unknown_choices_are_refused(name, wanted):
    with pytest.raises(el.EnvLightsError, match=rf"{name} must be .*; got '{wanted}'"):
        el.EnvMap(np.ones((4, 8, 3)), **{name: wanted})


@pytest.mark.parametrize(
    ("array", "note"),
    [
        (RADIANCE[..., 0], "the only channel was read as grey"),
        (RADIANCE[..., :1], "the only channel was read as grey"),
    ],
)
def test_other_channels_are_taken_as_those_of_files_with_a_note(array, note):
    """Also where a fit takes the array: its rig holds the note."""
    wanted = np.repeat(RADIANCE[..., :1], 3, axis=2)
    env = el.EnvMap(array)
    np.testing.assert_array_equal(env.radiance, wanted)
    assert env.notes == (note,)
    assert el.fit(array, lights=1).notes == (note,)


def test_a_path_is_taken_where_a_map_is(tmp_path):
    path = tmp_path / "hall.exr"
    el.io.write_exr(path, el.synthetic.hall(32).radiance)
    env = el.EnvMap.open(path)
    for given in (path, str(path)):
        assert el.fit(given, lights=1) == el.fit(env, lights=1)
        assert el.detect(given) == el.detect(env)
    with pytest.raises(el.EnvLightsError, match=r"cannot read .*none\.exr"):
        el.fit(tmp_path / "none.exr")


def test_one_normal_gives_one_irradiance():
    env = el.EnvMap(RADIANCE)
    rig = el.fit(env, lights=1)
    for lit in (env, rig):
        np.testing.assert_array_equal(lit.probe([0, 1, 0]), lit.probe([[0, 1, 0]])[0])
        with pytest.raises(el.EnvLightsError, match="normals must have 2 axes"):
            lit.probe([])
        with pytest.raises(el.EnvLightsError, match="normals must be an array of real numbers"):
            lit.probe([[0, 1, 0], [0, 1]])


def test_a_map_is_its_radiance_to_numpy():
    env = el.EnvMap(RADIANCE.astype(np.float32))
    assert np.shares_memory(np.asarray(env), env.radiance)
    assert np.asarray(env, np.float64).dtype == np.float64
    copied = np.array(env, copy=True)
    assert not np.shares_memory(copied, env.radiance)
    assert copied.flags.writeable
    np.testing.assert_array_equal(np.sum(env, axis=2), env.radiance.sum(axis=2))
    with pytest.raises(ValueError, match="as float64 it must be copied"):
        np.array(env, np.float64, copy=False)


def test_maps_are_equal_where_their_content_is():
    env = el.EnvMap(RADIANCE, notes="a remark")
    assert env == el.EnvMap(RADIANCE)
    assert env != el.EnvMap(2 * RADIANCE)
    assert env != el.EnvMap(RADIANCE, layout=el.io.Layout(registration="border-sampled"))
    assert env != el.EnvMap(RADIANCE, clip_level=1.0)
    assert env != RADIANCE.tolist()
    with pytest.raises(TypeError, match="unhashable"):
        hash(env)
