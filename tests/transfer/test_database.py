"""Pairs on disk: odd folders, damaged files, full disks, little memory."""

import subprocess
import sys
from functools import partial

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
import pytest

import envlights as el
from envlights import io
from tests.conftest import fills_a_disk
from tests.helpers import disk_that_is_full_after, pairs_of_room, write_pairs

room = partial(pairs_of_room, 8, 32)


@pytest.fixture
def folder(tmp_path):
    """Eight pairs as files."""
    return write_pairs(tmp_path / "room", room().direct, room().indirect)


@pytest.fixture
def pair_folder(tmp_path):
    """Six pairs as files; the names are not in the order of the numbers."""
    for name, direct, indirect in zip("fbcade", room().direct, room().indirect, strict=False):
        io.write_exr(tmp_path / f"direct_{name}.exr", direct)
        io.write_exr(tmp_path / f"lightmap_{name}.exr", indirect)
    (tmp_path / "albedo.exr").write_bytes((tmp_path / "direct_a.exr").read_bytes())
    return tmp_path


def test_a_folder_gives_the_model_of_its_arrays(pair_folder):
    pairs = el.read_pairs(pair_folder)
    order = np.argsort(list("fbcade"))
    np.testing.assert_array_equal(pairs.direct, room().direct[order])
    np.testing.assert_array_equal(pairs.indirect, room().indirect[order])
    assert isinstance(pairs.indirect, np.memmap)
    model = el.TransferModel.fit(pairs.direct, pairs.indirect)
    other = el.TransferModel.fit(room().direct[order], room().indirect[order])
    np.testing.assert_array_equal(model.predict(room().direct), other.predict(room().direct))


def test_pairs_that_were_read_are_saved_again(folder, tmp_path):
    pairs = el.read_pairs(folder)
    pairs.save(tmp_path / "copy")
    copy = el.read_pairs(tmp_path / "copy")
    assert copy == pairs
    np.testing.assert_array_equal(copy.indirect, room().indirect)


def test_paths_are_taken_in_their_order_and_notes_once(pair_folder, capsys):
    grey = np.ones((32, 32, 1), np.float32)
    io.write_exr(pair_folder / "lightmap_a.exr", grey)
    io.write_exr(pair_folder / "lightmap_b.exr", grey)
    paths = [
        (pair_folder / f"direct_{name}.exr", pair_folder / f"lightmap_{name}.exr") for name in "ab"
    ]
    pairs = el.read_pairs(paths, progress=True)
    np.testing.assert_array_equal(pairs.direct, room().direct[[3, 1]])
    assert pairs.notes == ("the only channel, Y, was read as grey in the lightmap images",)
    assert "2/2" in capsys.readouterr().err


def test_images_that_do_not_fit_together_are_refused_by_the_name_of_the_file(pair_folder):
    nan = room().indirect[0].copy()
    nan[5, 7, 0] = np.nan
    for name, change, message in [
        ("lightmap_c.exr", lambda path: io.write_exr(path, nan), "holds nan at row 5, column 7"),
        ("lightmap_c.exr", lambda path: io.write_exr(path, nan[:8]), "32x8 pixels, .* 32x32"),
        ("direct_c.exr", lambda path: io.write_exr(path, nan), "32x32 pixels, .* 16x16"),
    ]:
        change(pair_folder / name)
        with pytest.raises(el.EnvLightsError, match=message) as refusal:
            el.read_pairs(pair_folder)
        assert str(pair_folder / name) in str(refusal.value)
        assert "\n" not in str(refusal.value)


def test_what_holds_no_pairs_is_refused(tmp_path):
    (tmp_path / "empty").mkdir()
    for pairs, message in [
        (tmp_path / "none", "No such file or directory; give a folder"),
        (tmp_path / "empty", "holds no pairs; give files"),
        ([], "pairs is empty"),
        (["a.exr"], "pairs must hold two paths each; number 0 is 'a.exr'"),
    ]:
        with pytest.raises(el.EnvLightsError, match=message):
            el.read_pairs(pairs)


@fills_a_disk
def test_images_that_do_not_fit_on_the_disk_are_refused(folder, tmp_path, monkeypatch):
    spool = tmp_path / "spool"
    spool.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(spool))
    for images in (0, 0.5, 3, 7.99):
        size = int(images * room().indirect[0].nbytes)
        with (
            disk_that_is_full_after(size),
            pytest.raises(el.EnvLightsError, match="File too large; set TMPDIR to a folder with"),
        ):
            el.read_pairs(folder)
        assert not list(spool.iterdir())


def test_a_computer_without_a_place_for_temporary_files_is_told_so(folder, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "none"))
    with pytest.raises(el.EnvLightsError, match="No such file or directory; set TMPDIR"):
        el.read_pairs(folder)


def recode(path, image, compression, tile):
    """`image` as a file that is compressed in its own way, in rows or in tiles."""
    spec = oiio.ImageSpec(*image.shape[1::-1], 3, oiio.HALF if "b44" in compression else oiio.FLOAT)
    spec.attribute("compression", compression)
    spec.tile_width = spec.tile_height = tile
    file = oiio.ImageOutput.create(str(path))
    assert file.open(str(path), spec)
    assert file.write_image(image)
    assert file.close()
    return path.read_bytes()


@pytest.mark.parametrize("tile", [0, 16])
@pytest.mark.parametrize(
    "compression", ["none", "rle", "zips", "zip", "piz", "pxr24", "b44", "dwaa", "dwab"]
)
def test_an_exr_that_is_cut_off_is_refused_by_name_wherever_it_is_cut(folder, compression, tile):
    path = folder / "lightmap_0004.exr"
    whole = recode(path, room().indirect[4], compression, tile)
    assert io.read_image(path).pixels.shape == (32, 32, 3)
    for size in {*range(0, len(whole), 1 + len(whole) // 80), *range(len(whole) - 12, len(whole))}:
        path.write_bytes(whole[:size])
        with pytest.raises(el.EnvLightsError) as refusal:
            io.read_image(path)
        assert str(path) in str(refusal.value)
        assert "\n" not in str(refusal.value)


def test_names_may_hold_anything(folder):
    for kind in ("direct", "lightmap"):
        (folder / f"{kind}_0002.exr").rename(folder / f"{kind}_kitchen-02 b.1.exr")
    assert len(el.read_pairs(folder).direct) == len(list(folder.glob("direct_*.exr")))


def test_a_missing_partner_is_named_on_either_side(folder):
    (folder / "lightmap_0002.exr").rename(folder / "lightmap_0009.exr")
    with pytest.raises(
        el.EnvLightsError, match=r"direct_0002\.exr has no partner: .*lightmap_0002"
    ):
        el.read_pairs(folder)
    (folder / "direct_0002.exr").unlink()
    with pytest.raises(
        el.EnvLightsError, match=r"lightmap_0009\.exr has no partner: .*direct_0009"
    ):
        el.read_pairs(folder)


@pytest.mark.parametrize("name", ["none", "room/direct_0000.exr", "n" * 300, "a\0b"])
def test_what_is_no_folder_is_refused(folder, name):
    with pytest.raises(el.EnvLightsError, match=r"cannot read pairs from .*; give a folder"):
        el.read_pairs(folder.parent / name)


LITTLE_MEMORY = """
import re, resource, sys
from pathlib import Path
import envlights as el

def data():
    return 1024 * int(re.search(r"VmData:\\s+(\\d+)", Path("/proc/self/status").read_text())[1])

folder = sys.argv[1]
# What is allocated once: threads of OpenImageIO and BLAS, with their buffers.
warm = el.read_pairs(sorted(zip(Path(folder).glob("direct*"), Path(folder).glob("light*")))[:1])
el.TransferModel.fit(warm.direct, warm.indirect, 4)
size = 64 * warm.indirect.nbytes
resource.setrlimit(resource.RLIMIT_DATA, (data() + size // 4, -1))
pairs = el.read_pairs(folder)
assert pairs.indirect.nbytes == size
print(el.TransferModel.fit(pairs.direct, pairs.indirect, 8))
try:
    pairs.indirect.copy()
except MemoryError:
    print("the images themselves do not fit")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="Linux limits memory by itself")
def test_a_database_is_learnt_in_a_quarter_of_its_size(tmp_path):
    """RLIMIT_DATA counts what is allocated; pages of a mapped file are dropped where need be."""
    tall = np.tile(room().indirect, (8, 6, 6, 1))
    folder = write_pairs(tmp_path / "room", np.tile(room().direct, (8, 1, 1, 1)), tall)
    done = subprocess.run(
        [sys.executable, "-c", LITTLE_MEMORY, str(folder)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "rank 8 from 64 pairs" in done.stdout
    assert "the images themselves do not fit" in done.stdout
