"""`envlights transfer`: learn, apply, draw; nothing is left where a step is refused."""

from functools import partial

import numpy as np
import pytest
from click.testing import CliRunner

import envlights as el
from envlights import io
from envlights.cli import main
from tests.conftest import fills_a_disk
from tests.helpers import cuts, disk_that_is_full_after, pairs_of_room, write_pairs
from tests.reference.rooms import room_prior

room = partial(pairs_of_room, 12, 32)
PAIRS = 8


@pytest.fixture
def folder(tmp_path):
    """Eight pairs as files."""
    return write_pairs(tmp_path / "room", room().direct[:PAIRS], room().indirect[:PAIRS])


@pytest.fixture(scope="module")
def model():
    return el.TransferModel.fit(room().direct[:PAIRS], room().indirect[:PAIRS])


def run(*arguments):
    return CliRunner().invoke(main, ["transfer", *map(str, arguments)])


def test_a_model_is_learnt_and_predicts_what_the_functions_do(folder, tmp_path):
    model, out = tmp_path / "model.npz", tmp_path / "out.exr"
    result = run("fit", folder, "-o", model, "--rank", 4, "--ridge", "loo")
    assert result.exit_code == 0, result.output
    assert "rank 4 from 8 pairs" in result.stdout
    result = run("apply", model, folder / "direct_0000.exr", "-o", out)
    assert result.exit_code == 0, result.output
    predicted = el.TransferModel.load(model).predict(room().direct[0])
    np.testing.assert_array_equal(io.read_image(out).pixels, predicted)


@pytest.mark.parametrize(("options", "ridge"), [((), 1e-3), (("--nonnegative",), None)])
def test_the_ridge_has_the_default_of_the_library(folder, tmp_path, options, ridge):
    result = run("fit", folder, "-o", tmp_path / "m.npz", *options)
    assert result.exit_code == 0, result.stderr
    parameters = el.TransferModel.load(tmp_path / "m.npz").parameters
    assert parameters["ridge"] == (ridge or "loo")
    assert parameters["nonnegative"] == bool(options)


def test_rank_is_a_number_or_a_share_and_ridge_a_number(tmp_path):
    folder = write_pairs(tmp_path / "room", room().direct, room().indirect)
    for rank, wanted in (("3", 3), ("0.9", 0.9)):
        result = run("fit", folder, "-o", tmp_path / "m.npz", "--rank", rank, "--ridge", "0.25")
        assert result.exit_code == 0, result.output
        parameters = el.TransferModel.load(tmp_path / "m.npz").parameters
        assert (parameters["rank"], parameters["ridge"]) == (wanted, 0.25)


def test_duplicates_black_images_and_a_high_rank_are_learnt_from_and_noted(tmp_path):
    order = [0, 1, 2, 2, 2, 3, 4, 5]
    direct, indirect = room().direct[order], room().indirect[order]
    direct[5] = indirect[5] = 0
    indirect[6] = 0
    folder = write_pairs(tmp_path / "room", direct, indirect)
    result = run("fit", folder, "-o", tmp_path / "m.npz", "--rank", 500, "--ridge", "loo")
    assert result.exit_code == 0, result.output
    assert "1 image is left out, because direct is black: image 5" in result.stdout
    assert "the images have no more than" in result.stdout
    report = el.TransferModel.load(tmp_path / "m.npz").report
    assert len(report.unseen_errors) == 6
    assert np.isfinite(report.unseen_errors).all()


def test_a_picture_is_drawn_in_each_format(model, tmp_path):
    direct, indirect, saved = (tmp_path / name for name in ("d.exr", "i.exr", "m.npz"))
    io.write_exr(direct, room().direct[9])
    io.write_exr(indirect, room().indirect[9])
    model.save(saved)
    for suffix, head in (("png", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml")):
        picture = tmp_path / f"out.{suffix}"
        result = run("figure", saved, direct, indirect, "-o", picture)
        assert result.exit_code == 0, result.output
        assert picture.read_bytes().startswith(head)
        assert result.stderr == f"wrote {picture}\n"


def test_help_shows_everything():
    text = run("--help").stdout
    for word in ("fit", "apply", "figure", "direct_NAME.exr", "lightmap_NAME.exr"):
        assert word in text
    assert "..." not in text.split("Commands:")[1], "no line is cut off"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("fit none -o m.npz", "No such file or directory; give a folder"),
        ("fit room -o m.json", "the suffix must be .npz"),
        ("fit room -o m.npz --ridge x", "ridge must be 'loo'; got 'x'"),
        ("fit room -o m.npz --rank many", "got many"),
        ("apply m.npz direct.exr -o o.exr", "cannot read"),
        ("apply m.npz direct.exr -o o.png", "the suffix must be .exr"),
        ("apply m.npz direct.exr -o direct.exr", "it is the direct light"),
        ("apply direct.exr room/direct_0001.exr -o direct.exr", "it is the model"),
        ("figure m.npz direct.exr picture.png -o o.exr", "must be one of .png, .pdf, .svg"),
        ("figure m.npz direct.exr picture.png -o picture.png", "it is the indirect light"),
        ("figure m.npz direct.exr picture.png -o none/o.png", "does not exist"),
        ("figure m.npz direct.exr picture.png -o o.png", "cannot read"),
    ],
)
def test_a_refusal_is_a_sentence_and_leaves_the_folder_as_it_was(
    folder, tmp_path, monkeypatch, arguments, message
):
    (tmp_path / "picture.png").write_bytes(b"kept")
    (tmp_path / "direct.exr").write_bytes((folder / "direct_0000.exr").read_bytes())
    monkeypatch.chdir(tmp_path)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    result = run(*arguments.split())
    is_file = message.startswith(("No such file", "cannot read", "does not exist"))
    assert result.exit_code == (1 if is_file else 2)
    assert message in result.stderr
    assert result.stdout == ""
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def test_a_folder_with_an_exr_that_is_cut_off_is_refused_by_its_name(folder, tmp_path):
    path = folder / "lightmap_0004.exr"
    whole = path.read_bytes()
    for size in cuts(len(whole), step=100):
        path.write_bytes(whole[:size])
        result = run("fit", folder, "-o", tmp_path / "model.npz")
        assert result.exit_code == 1
        assert str(path) in result.stderr
        assert not (tmp_path / "model.npz").exists()


@fills_a_disk
@pytest.mark.parametrize(
    "suffix",
    ["npz", "exr", *(pytest.param(each, marks=pytest.mark.slow) for each in ("png", "pdf", "svg"))],
)
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
    spool = PAIRS * room().indirect[0].nbytes
    for cut in cuts(size, step=29 if suffix == "exr" else 590):
        refused = f"cannot write {target}: "
        if suffix == "npz" and cut < spool:
            refused = "cannot keep the images in a temporary file: "
        for old in ([], [b"old"]):
            for content in old:
                target.write_bytes(content)
            with disk_that_is_full_after(cut):
                result = run(*command)
            assert result.exit_code == 1, (cut, result.output, result.exception)
            last = result.stderr.splitlines()[-1]
            assert last.startswith(f"envlights: {refused}"), result.stderr
            assert [path.read_bytes() for path in target.parent.iterdir()] == old
        target.unlink()


def test_a_prior_is_read_from_a_file(folder, tmp_path):
    room_prior(32).save(tmp_path / "prior.npz")
    result = run("fit", folder, "-o", tmp_path / "m.npz", "--prior", tmp_path / "prior.npz")
    assert result.exit_code == 0, result.stderr
    assert "prior alone" in result.stdout
    assert el.TransferModel.load(tmp_path / "m.npz").parameters["prior"]
    result = run("fit", folder, "-o", tmp_path / "n.npz", "--prior", tmp_path / "m.npz")
    assert result.exit_code != 0
    assert "is not a prior" in result.stderr
    assert not (tmp_path / "n.npz").exists()
