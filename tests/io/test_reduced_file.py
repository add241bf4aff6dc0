"""A fit that reads its file by rows gives the lights of a fit of the whole map, to the bit."""

import re

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
import pytest

import envlights as el
from envlights.environment.reduced_file import reduce_file
from envlights.fitting.reduction import POINT_SHARE
from envlights.kernels.probe import WORKING_COLUMNS
from tests.conftest import real_maps
from tests.layouts.files import jpeg_with

FORMATS = {
    "map.hdr": ("float", {}),
    "map.jpg": ("uint8", {"compression": "jpeg:95"}),
    "8.png": ("uint8", {}),
    "16.png": ("uint16", {}),
    "half.exr": ("half", {"compression": "zip"}),
    "float.exr": ("float", {"compression": "piz"}),
    "tiled.exr": ("half", {"tile": 16}),
    "float.tif": ("float", {}),
    "16.tif": ("uint16", {}),
}


def scene(height=300):
    """Sky with a sun of a few pixels, a lamp on the seam, and light at the last row."""
    radiance = np.random.default_rng(0).uniform(0.05, 0.1, (height, 2 * height, 3))
    radiance[: height // 2] += [0.05, 0.1, 0.2]
    radiance[40:43, 100:103] = [0.98, 0.9, 0.8]
    radiance[160:180, :8] = radiance[160:180, -8:] = [0.5, 0.4, 0.1]
    radiance[-1, 20:40] = 0.7
    return radiance.astype(np.float32)


def save(path, sample, attributes, radiance, **more):
    height, width, _ = radiance.shape
    spec = oiio.ImageSpec(width, height, 3, sample)
    tile = attributes.get("tile", 0)
    spec.tile_width = spec.tile_height = tile
    for name, value in (attributes | more).items():
        spec.attribute(name, value)
    file = oiio.ImageOutput.create(str(path))
    assert file.open(str(path), spec), file.geterror()
    assert file.write_image(radiance)
    file.close()
    return path


def cells_of(path, floor=False):
    return reduce_file(path, WORKING_COLUMNS, POINT_SHARE, floor, 2)


def assert_same(one, other):
    np.testing.assert_array_equal(one.ambient, other.ambient)
    np.testing.assert_array_equal(one.lights.direction, other.lights.direction)
    np.testing.assert_array_equal(one.lights.irradiance, other.lights.irradiance)
    np.testing.assert_array_equal(one.lights.angular_radius, other.lights.angular_radius)
    assert one.error == other.error
    assert one.notes == other.notes
    assert one.report.skipped == other.report.skipped


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize("floor", [False, True])
def test_lights_of_a_file_are_those_of_its_map(tmp_path, name, floor):
    path = save(tmp_path / name, *FORMATS[name], scene())
    assert cells_of(path, floor) is not None
    assert_same(el.fit(path, floor=floor), el.fit(el.EnvMap.open(path), floor=floor))


@pytest.mark.parametrize("height", [2, 16, 127, 257])
def test_files_of_any_height_are_read(tmp_path, height):
    radiance = np.random.default_rng(height).uniform(0, 1, (height, 2 * height, 3))
    for name in ("map.hdr", "8.png", "float.exr"):
        path = save(tmp_path / name, *FORMATS[name], radiance.astype(np.float32))
        assert_same(el.fit(path, lights=2), el.fit(el.EnvMap.open(path), lights=2))


def test_files_that_are_not_the_rows_of_a_map_are_opened_whole(tmp_path):
    rec2020 = (0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290)
    path = tmp_path / "wide.exr"
    spec = oiio.ImageSpec(600, 300, 3, "float")
    spec.attribute("chromaticities", oiio.TypeDesc("float[8]"), rec2020)
    file = oiio.ImageOutput.create(str(path))
    file.open(str(path), spec)
    file.write_image(scene())
    file.close()
    mirrored = save(tmp_path / "mirrored.tif", "uint8", {}, scene(), Orientation=2)
    for odd in (path, mirrored):
        assert cells_of(odd) is None
        assert_same(el.fit(odd), el.fit(el.EnvMap.open(odd)))


@pytest.mark.parametrize("name", ["half.exr", "float.exr", "tiled.exr", "float.tif"])
def test_samples_that_no_light_can_have_are_cleaned_as_in_the_whole_map(tmp_path, name):
    """A sun beyond the format over the seam and over rows that are read one after the other."""
    radiance = scene()
    radiance[120:136, -5:] = radiance[120:136, :4] = np.inf
    radiance[0, 7, 1] = radiance[-1, 8, 2] = np.inf
    radiance[5, 5] = radiance[126, 300, 0] = np.nan
    radiance[9, 9, 2] = -1.0
    path = save(tmp_path / name, *FORMATS[name], radiance)
    assert cells_of(path) is not None
    rig, env = el.fit(path), el.EnvMap.open(path)
    assert_same(rig, el.fit(env))
    assert any("infinite samples set to 65504 and counted as clipped" in note for note in rig.notes)
    clipped = cells_of(path).clipped_flux_fraction
    assert clipped == pytest.approx(env.clipped_flux_fraction, rel=1e-5)
    assert clipped > 0.9


def test_a_file_without_a_finite_sample_is_refused(tmp_path):
    path = save(tmp_path / "nan.exr", "float", {}, np.full_like(scene(), np.nan))
    with pytest.raises(el.EnvLightsError, match=r"nan\.exr: the image holds no finite sample"):
        el.fit(path)


def test_negative_samples_count_as_0_and_are_noted(tmp_path):
    """Lossy compression leaves them in most rows."""
    radiance = scene() - np.float32(0.06)
    radiance[3, 4], radiance[7, 8, 0] = -0.0, -np.inf
    for name in ("half.exr", "float.exr", "float.tif"):
        path = save(tmp_path / name, *FORMATS[name], radiance)
        assert cells_of(path) is not None
        rig = el.fit(path)
        assert_same(rig, el.fit(el.EnvMap.open(path)))
        assert any("negative samples set to 0" in note for note in rig.notes)


@real_maps("*/*.hdr", "*/*.exr", "*/*.png", "*/*.jpg")
def test_lights_of_real_files_are_those_of_their_maps(path):
    try:
        env = el.EnvMap.open(path)
    except el.EnvLightsError as refusal:
        reason = re.escape(str(refusal))
    else:
        assert_same(el.fit(path), el.fit(env))
        return
    with pytest.raises(el.EnvLightsError, match=reason):
        el.fit(path)


@pytest.mark.parametrize(
    "said",
    [
        {"GPano__ProjectionType": "cylindrical"},
        {"GSpherical__StereoMode": "left-right"},
        {"GPano__ProjectionType": "equirectangular"},
    ],
)
def test_rows_of_other_projections_are_left_to_the_whole_map(tmp_path, said):
    path = jpeg_with(tmp_path / "map.jpg", scene(64), **said)
    assert (cells_of(path) is None) is ("equirectangular" not in said.values())


def test_cubes_are_left_to_the_whole_map(tmp_path):
    said = {"textureformat": "CubeFace Environment"}
    assert cells_of(save(tmp_path / "cube.exr", "half", said, scene(64))) is None
