"""Skipped work changes the result by at most its bound, and is reported."""

import numpy as np
import pytest

import envlights as el
from tests.conftest import real_maps
from tests.skips import SCENES, of_frames, of_map, of_scene

EVERY_SCENE = pytest.mark.parametrize("scene", SCENES)


def assert_holds(skip):
    assert skip.skipped
    error = skip.error()
    assert error <= skip.bound, f"{skip.stage}: {error:.2g}, bound {skip.bound:.2g}: {skip.reason}"


@EVERY_SCENE
def test_on_and_off_agree_to_the_bound_on_a_scene(scene):
    for skip in of_scene(scene, 256):
        assert_holds(skip)


def test_on_and_off_agree_to_the_bound_on_frames():
    for skip in of_frames(64):
        assert_holds(skip)


@real_maps("hdr/*.hdr", "exr/*.exr", "openexr_envmaps/*LatLong.exr")
def test_on_and_off_agree_on_a_real_map(path):
    radiance = np.ascontiguousarray(el.EnvMap.open(path).radiance)
    for skip in of_map(path.stem, radiance):
        error = skip.error()
        assert error <= skip.bound, f"{skip.stage}: {error:.2g}, bound {skip.bound:.2g}"


@EVERY_SCENE
def test_without_dark_tiles_all_are_opened(scene):
    """The specks of the comparison open every tile."""
    (tiles,) = (skip for skip in of_scene(scene, 256) if skip.stage == "detection")
    details = tiles.off().report.details
    assert any(line.startswith("0 of ") for line in details), details


def test_black_texels_are_told_once_and_counted_anew():
    room = el.synthetic.room(12, width=16)
    indirect = room.indirect.copy()
    indirect[:, :4] = 0
    model = el.TransferModel.fit(room.direct[:8], indirect[:8])
    black = np.count_nonzero(~indirect[:8].any(axis=(0, 3)))
    assert [note for note in model.report.notes if "black" in note] == [
        f"{black} of 256 texels are black in every image, so they are predicted black"
    ]
    grown = model.add(room.direct[8:], room.indirect[8:])
    is_seen = indirect[:8].any(axis=(0, 3)) | room.indirect[8:].any(axis=(0, 3))
    black = np.count_nonzero(~is_seen)
    assert black > 0
    assert [note for note in grown.report.notes if "black" in note] == [
        f"{black} of 256 texels are black in every image, so they are predicted black"
    ]
