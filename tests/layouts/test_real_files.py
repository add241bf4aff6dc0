"""Every file of the shared maps: its layout, or the sentence that refuses it."""

import os
from pathlib import Path

import numpy as np
import pytest

import envlights as el
from envlights.environment.layouts import recognise
from envlights.environment.picture_files import read_picture

PANORAMA = ("equirectangular", "", "cell-centred", "shape")
BORDER = ("equirectangular", "", "border-sampled", "attribute")
CUBE = ("cube", "openexr", "border-sampled", "attribute")
FACES = ("cube", "opengl", "cell-centred", "name")
SQUARE = "twice as wide as high; got .*layout='octahedral'"
PHOTOGRAPH = "twice as wide as high; got .*Layout.planar.fov=65"
CHROMA = r"luminance and chroma of half resolution \(Y, RY, BY\)"

#: Pattern of files, and the source of the map or words of the refusal; the first match counts.
TABLE = [
    ("hdr/*.hdr", PANORAMA),
    ("exr/*.exr", PANORAMA),
    ("ldr/*.png", PANORAMA),
    ("openexr_envmaps/*LatLong.exr", BORDER),
    ("openexr_envmaps/*Cube.exr", CUBE),
    ("ldr/humus_citadella/*.jpg", "seems to be one face of a cube map; give its folder"),
    ("ldr/humus_citadella", FACES),
    ("loader_tests/damaged/*", "cannot read|it needs R, G and B"),
    ("loader_tests/*_YC.exr", CHROMA),
    ("loader_tests/*Trunks.exr", "it is a deep image"),
    ("loader_tests/TestImages_GrayRamps*.exr", "two panoramas, one above the other"),
    ("loader_tests/TestImages_*.exr", SQUARE),
    ("loader_tests/DisplayWindow_t01.exr", r"a cube map \(layout=.*faces='horizontal-cross'\)"),
    ("loader_tests/*.exr", PHOTOGRAPH),
]


def files():
    folder = Path(os.environ.get("ENVLIGHTS_MAPS", "nowhere"))
    images = {".hdr", ".exr", ".png", ".jpg", ""}
    each = sorted(path for path in folder.rglob("*") if path.suffix in images)
    return [path.relative_to(folder) for path in each if path.name not in _OTHERS]


_OTHERS = {"LICENSE", "hdr", "exr", "ldr", "openexr_envmaps", "loader_tests", "damaged"}


@pytest.mark.parametrize("path", files(), ids=str)
def test_each_shared_file_has_its_layout_or_its_sentence(path):
    wanted = next(result for pattern, result in TABLE if path.match(pattern))
    if isinstance(wanted, str):
        with pytest.raises(el.EnvLightsError, match=wanted):
            _recognise(path)
        return
    image, arranged = _recognise(path)
    source = arranged.source
    assert (source.projection, *source[2:5]) == wanted
    if source.projection == "equirectangular":
        assert arranged.samples is image.pixels
    assert arranged.samples.shape == (arranged.layout.height, arranged.layout.width, 3)


def _recognise(path):
    image = read_picture(Path(os.environ["ENVLIGHTS_MAPS"], path))
    return image, recognise(image.pixels, image.hints, coverage=image.coverage)


@pytest.mark.skipif("ENVLIGHTS_MAPS" not in os.environ, reason="needs the shared maps")
def test_the_sun_of_citadella_is_in_the_up_face_58_degrees_high():
    image, arranged = _recognise(Path("ldr/humus_citadella"))
    luminance = arranged.samples.mean(axis=2)
    rows, columns = np.nonzero(luminance >= 0.99 * luminance.max())
    face, row = np.divmod(rows, 512)
    assert set(face) == {4}
    a, b = (2 * (at + 0.5) / 512 - 1 for at in (columns, row))
    elevation = np.rad2deg(np.arctan(1 / np.hypot(a, b)))
    assert np.median(elevation) == pytest.approx(58, abs=2)
    assert image.clip_level == 1.0
