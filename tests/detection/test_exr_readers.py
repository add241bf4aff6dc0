"""Detection on EXR files as two libraries read them: the same lights, to the last bit."""

import numpy as np
import pytest

import envlights as el
from envlights import io

OpenEXR = pytest.importorskip("OpenEXR")

#: Compressions without loss, by the names of OpenEXR.
COMPRESSIONS = ("NO_COMPRESSION", "RLE_COMPRESSION", "ZIP_COMPRESSION", "PIZ_COMPRESSION")


@pytest.fixture(scope="module")
def radiance():
    return el.synthetic.hard(el.synthetic.EVALUATION[0], 128).radiance.astype(np.float32)


def read(path):
    """The colour channels as the OpenEXR module reads them, in float32."""
    channels = OpenEXR.File(str(path)).channels()
    if "RGB" in channels:
        return channels["RGB"].pixels.astype(np.float32)
    return np.stack([channels[name].pixels for name in "RGB"], axis=2).astype(np.float32)


def assert_same_lights(path):
    own, other = el.detect(el.EnvMap.open(path)), el.detect(read(path))
    assert len(own) > 0
    np.testing.assert_array_equal(own.direction, other.direction)
    np.testing.assert_array_equal(own.irradiance, other.irradiance)


@pytest.mark.parametrize("dtype", [np.float16, np.float32])
@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_files_of_the_openexr_module(radiance, dtype, compression, tmp_path):
    header = {"compression": getattr(OpenEXR, compression), "type": OpenEXR.scanlineimage}
    pixels = radiance.clip(0, 6e4).astype(dtype)
    with OpenEXR.File(header, {"RGB": np.ascontiguousarray(pixels)}) as file:
        file.write(str(tmp_path / "map.exr"))
    np.testing.assert_array_equal(read(tmp_path / "map.exr"), pixels.astype(np.float32))
    assert_same_lights(tmp_path / "map.exr")


def test_files_of_our_own(radiance, tmp_path):
    io.write_exr(tmp_path / "map.exr", radiance)
    assert_same_lights(tmp_path / "map.exr")
