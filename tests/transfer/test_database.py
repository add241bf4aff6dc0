"""Odd folders, damaged files, full disks, little memory: nothing is left half-written."""

import contextlib
import subprocess
import sys

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
import pytest
from click.testing import CliRunner

import envlights as el
from envlights import io
from envlights.cli import main
from tests.helpers import relative_errors

resource = pytest.importorskip("resource", reason="sizes of files cannot be limited here")

ROOM = el.synthetic.room(8, width=32)


@pytest.fixture
def folder(tmp_path):
    """Eight pairs as files."""
    return write(tmp_path / "room", ROOM.direct, ROOM.indirect)


@pytest.fixture(scope="module")
def model():
    return el.TransferModel.fit(ROOM.direct, ROOM.indirect)


def write(folder, direct, indirect):
    folder.mkdir()
    for k, pair in enumerate(zip(direct, indirect, strict=True)):
        for kind, image in zip(("direct", "lightmap"), pair, strict=True):
            io.write_exr(folder / f"{kind}_{k:04}.exr", image.astype(np.float32))
    return folder


def run(*arguments):
    return CliRunner().invoke(main, ["transfer", *map(str, arguments)])


@contextlib.contextmanager
def disk_that_is_full_after(size):
    """No file can grow beyond `size` bytes: a write fails as on a full disk, with EFBIG."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def ends(size, step=29):
    """Sizes at which a file of `size` bytes is cut: the start, the middle, and close to the end."""
    return sorted({0, 1, size // 2, *range(max(size - 600, 2), size, step), size - 1})


@pytest.mark.parametrize("suffix", ["npz", "exr", "png", "pdf", "svg"])
def test_a_full_disk_leaves_nothing_half_written(model, folder, tmp_path, suffix):
    saved, target = tmp_path / "saved.npz", tmp_path / "out" / f"o.{suffix}"
    model.save(saved)
    pair = folder / "direct_0003.exr", folder / "lightmap_0003.exr"
    command = {
        "npz": ("fit", folder, "-o", target),
        "exr": ("apply", saved, pair[0], "-o", target),
    }.get(suffix, ("figure", saved, *pair, "-o", target))
    target.parent.mkdir()
    assert run(*command).exit_code == 0
    # Seconds in a model, dates and random names in a picture make it a little longer or shorter.
    size = target.stat().st_size - (1000 if suffix in ("npz", "pdf", "svg") else 0)
    target.unlink()
    spool = 8 * ROOM.indirect[0].nbytes
    for cut in ends(size, step=29 if suffix == "exr" else 590):
        if suffix == "npz" and cut < spool:
            continue  # the images themselves do not fit: below
        for old in ([], [b"old"]):
            for content in old:
                target.write_bytes(content)
            with disk_that_is_full_after(cut):
                result = run(*command)
            assert result.exit_code == 2, (cut, result.output, result.exception)
            last = result.stderr.splitlines()[-1]
            assert last.startswith(f"envlights: cannot write {target}: "), result.stderr
            assert [path.read_bytes() for path in target.parent.iterdir()] == old
        target.unlink()


@pytest.mark.parametrize("notebook", [False, True])
def test_a_model_that_does_not_fit_on_the_disk_is_not_saved(tmp_path, notebook):
    model = el.TransferModel.fit(ROOM.direct, ROOM.indirect, notebook=notebook)
    target = tmp_path / "model.npz"
    model.save(target)
    whole = target.read_bytes()
    for cut in ends(len(whole)):
        with (
            disk_that_is_full_after(cut),
            pytest.raises(el.EnvLightsError, match=r"cannot write .*model\.npz: File too large"),
        ):
            model.save(target)
        assert target.read_bytes() == whole
        assert [path.name for path in tmp_path.iterdir()] == ["model.npz"]


def test_images_that_do_not_fit_on_the_disk_are_refused(folder, tmp_path, monkeypatch):
    spool = tmp_path / "spool"
    spool.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(spool))
    for images in (0, 0.5, 3, 7.99):
        size = int(images * ROOM.indirect[0].nbytes)
        with (
            disk_that_is_full_after(size),
            pytest.raises(el.EnvLightsError, match="File too large; set TMPDIR to a folder with"),
        ):
            el.read_pairs(folder)
        assert not list(spool.iterdir())
        with disk_that_is_full_after(size):
            result = run("fit", folder, "-o", tmp_path / "model.npz")
        assert result.exit_code == 2
        assert not (tmp_path / "model.npz").exists()


def test_a_computer_without_a_place_for_temporary_files_is_told_so(folder, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "none"))
    with pytest.raises(el.EnvLightsError, match="No such file or directory; set TMPDIR"):
        el.read_pairs(folder)


def recoded(path, image, compression, tile):
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
    whole = recoded(path, ROOM.indirect[4], compression, tile)
    assert io.read_image(path).pixels.shape == (32, 32, 3)
    for size in {*range(0, len(whole), 1 + len(whole) // 80), *range(len(whole) - 12, len(whole))}:
        path.write_bytes(whole[:size])
        with pytest.raises(el.EnvLightsError) as refusal:
            io.read_image(path)
        assert str(path) in str(refusal.value)
        assert "\n" not in str(refusal.value)


def test_a_folder_with_an_exr_that_is_cut_off_is_refused_by_its_name(folder, tmp_path):
    path = folder / "lightmap_0004.exr"
    whole = path.read_bytes()
    for size in ends(len(whole), step=100):
        path.write_bytes(whole[:size])
        result = run("fit", folder, "-o", tmp_path / "model.npz")
        assert result.exit_code == 2
        assert str(path) in result.stderr
        assert not (tmp_path / "model.npz").exists()


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


def test_a_folder_of_one_pair_is_enough_for_its_own_light(tmp_path):
    folder = write(tmp_path / "room", ROOM.direct[:1], ROOM.indirect[:1])
    saved, out = tmp_path / "m.npz", tmp_path / "o.exr"
    assert run("fit", folder, "-o", saved, "--ridge", 0).exit_code == 0
    assert run("apply", saved, folder / "direct_0000.exr", "-o", out).exit_code == 0
    assert relative_errors(io.read_image(out).pixels[None], ROOM.indirect[:1])[0] < 1e-5
    pairs = el.read_pairs(folder)
    notebook = el.TransferModel.fit(pairs.direct, pairs.indirect, notebook=True)
    assert np.isfinite(notebook.predict(ROOM.direct[1])).all()


def test_duplicates_black_images_and_a_high_rank_are_learnt_from_and_noted(tmp_path):
    order = [0, 1, 2, 2, 2, 3, 4, 5]
    direct, indirect = ROOM.direct[order], ROOM.indirect[order]
    direct[5] = indirect[5] = 0
    indirect[6] = 0
    folder = write(tmp_path / "room", direct, indirect)
    result = run("fit", folder, "-o", tmp_path / "m.npz", "--rank", 500, "--ridge", "loo")
    assert result.exit_code == 0, result.output
    assert "direct is black in 1 of the images (5 first): left out" in result.stdout
    assert "the images have no more than" in result.stdout
    report = el.TransferModel.load(tmp_path / "m.npz").report
    assert len(report.unseen_errors) == 6
    assert np.isfinite(report.unseen_errors).all()


def test_a_folder_of_black_images_is_refused(tmp_path):
    folder = write(tmp_path / "room", 0 * ROOM.direct, ROOM.indirect)
    result = run("fit", folder, "-o", tmp_path / "m.npz")
    assert result.exit_code == 2
    assert "direct is black in every image; there is nothing to learn from" in result.stderr


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
    tall = np.tile(ROOM.indirect, (8, 6, 6, 1))
    folder = write(tmp_path / "room", np.tile(ROOM.direct, (8, 1, 1, 1)), tall)
    done = subprocess.run(
        [sys.executable, "-c", LITTLE_MEMORY, str(folder)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "rank 8 from 64 pairs" in done.stdout
    assert "the images themselves do not fit" in done.stdout


@pytest.mark.parametrize("seed", range(4))
def test_a_model_with_damaged_bytes_is_read_or_refused(tmp_path, seed):
    room = el.synthetic.room(4, width=16)
    model = el.TransferModel.fit(room.direct, room.indirect, rank=2)
    model.save(tmp_path / "model.npz")
    whole = (tmp_path / "model.npz").read_bytes()
    rng = np.random.default_rng(seed)
    # Where zipfile looks: the headers of the first arrays, and the table at the end.
    places = np.concatenate([rng.integers(0, 400, 150), rng.integers(-1500, 0, 150) + len(whole)])
    refused = 0
    for place in places:
        damaged = bytearray(whole)
        damaged[place] ^= 1 << rng.integers(8)
        (tmp_path / "damaged.npz").write_bytes(damaged)
        try:
            el.TransferModel.load(tmp_path / "damaged.npz")
        except el.EnvLightsError:
            refused += 1
    assert refused > 100
