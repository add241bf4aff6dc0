"""Maps of a batch from folders, patterns, lists, addresses and iterators."""

import json

import numpy as np
import pytest

import envlights as el

GREY = np.full((16, 32, 3), 0.5, np.float32)


def names(maps, *arguments, **options):
    return [row["name"] for row in el.batch(maps, *arguments, what=peak, jobs=1, **options).rows()]


def peak(env, factor=1):
    """Largest sample, times a factor."""
    return {"peak": factor * float(env.radiance.max())}


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "below").mkdir()
    for name in ("one.exr", "two.hdr", "below/one.exr"):
        el.EnvMap(GREY).save(tmp_path / name)
    (tmp_path / "notes.md").write_text("no map")
    return tmp_path


def test_folders_patterns_and_lists_name_their_maps(folder):
    assert names(folder) == ["below/one", "one", "two"]
    assert names(str(folder / "*.exr")) == ["one"]
    (folder / "list.txt").write_text("# maps\none.exr\n\ntwo.hdr\none.exr\n")
    assert names(folder / "list.txt") == ["one", "two"]
    (folder / "list.txt").write_bytes(b"\xef\xbb\xbfone.exr\r\n")  # by an editor on Windows
    assert names(folder / "list.txt") == ["one"]
    lines = [json.dumps("one.exr"), json.dumps({"path": "two.hdr", "name": "night"})]
    (folder / "list.jsonl").write_text("\n".join(lines))
    assert names(folder / "list.jsonl") == ["night", "one"]


@pytest.mark.parametrize("source", ["sky", "sky/{face}.exr"])
def test_a_named_folder_or_pattern_of_six_faces_is_one_map(tmp_path, source):
    (tmp_path / "sky").mkdir()
    for number, face in enumerate(("px", "nx", "py", "ny", "pz", "nz")):
        el.io.write_exr(tmp_path / f"sky/{face}.exr", np.full((8, 8, 3), number, np.float32))
    maps = [("cube", str(tmp_path / source))]
    result = el.batch(maps, tmp_path / "out", what=peak, jobs=1)
    assert [row["values"] for row in result.rows()] == [{"peak": pytest.approx(5.0, abs=0.01)}]


def test_maps_of_one_name_get_different_ones(folder):
    both = names([folder / "one.exr", folder / "below" / "one.exr"])
    assert both[0] == "one"
    assert both[1].startswith("one-")


def test_files_of_the_results_are_no_maps_of_the_next_run(folder):
    out = folder / "out"
    for _ in range(2):
        result = el.batch([folder, str(folder / "**/*.exr")], out, what="split", jobs=1)
        assert len(result) == 3
        assert (out / "below" / "one.exr").exists()
    with pytest.raises(el.EnvLightsError, match="outside of the folder of the results"):
        el.batch(folder, folder)


def test_a_map_is_not_overwritten_by_its_result(folder):
    before = (folder / "one.exr").read_bytes()
    result = el.batch(folder / "one.exr", folder, what="split", jobs=1)
    assert "over its map" in result.failures["one"]
    assert (folder / "one.exr").read_bytes() == before


def test_an_iterator_is_read_a_few_maps_ahead():
    done, ahead = [], []

    def maps():
        for number in range(200):
            ahead.append(number - len(done))
            yield f"map-{number}", GREY

    def work(env):
        done.append(env)
        return {}

    assert len(el.batch(maps(), what=work, jobs=2)) == 200
    assert max(ahead) <= 4


def test_maps_at_addresses_are_listed_by_fsspec(folder):
    pytest.importorskip("fsspec")
    assert names(f"file://{folder}/*.exr") == ["one"]
    with pytest.raises(el.FileError, match="cannot list nosuch://"):
        names("nosuch://folder/*.exr")


@pytest.mark.parametrize(
    ("maps", "message"),
    [
        (3, "maps must be paths"),
        ("no-map-*.exr", "no file matches"),
        ([("../out", GREY)], "must name a file in the folder"),
        ([("same", GREY), ("same", GREY)], "two maps of the batch have the name 'same'"),
    ],
)
def test_bad_input_is_refused(maps, message):
    with pytest.raises(el.EnvLightsError, match=message):
        el.batch(maps)


def test_a_function_with_another_text_or_other_options_is_done_again(folder, tmp_path):
    out = tmp_path / "rows"
    maps = folder / "one.exr"
    first = el.batch(maps, out, what=peak)
    assert [row["value_peak"] for row in first.table("maps")] == [0.5]
    assert el.batch(maps, out, what=peak).unchanged == 1
    assert el.batch(maps, out, what=peak, factor=2).unchanged == 0

    def other(env, factor=1):
        return {"peak": 3 * factor * float(env.radiance.max())}

    other.__qualname__, other.__module__ = peak.__qualname__, peak.__module__
    again = el.batch(maps, out, what=other, factor=2)
    assert again.unchanged == 0
    assert [row["value_peak"] for row in again.table("maps")] == [3.0]


def test_a_result_of_another_kind_costs_its_row():
    result = el.batch([GREY], what=lambda env: env.radiance[0, 0, 0], jobs=1)
    assert "must return a dict, a rig, lights" in next(iter(result.failures.values()))
