"""Tables of a batch, read back by other programs."""

import json

import numpy as np
import pytest

import envlights as el
from envlights.batches.columns import COLUMNS


@pytest.fixture(scope="module")
def result():
    maps = [(f"map-{seed}", el.synthetic.plain(seed, 128).radiance) for seed in range(3)]
    return el.batch([*maps, ("bad", [1])], lights=2, jobs=1)


@pytest.fixture(params=["lights", "maps"])
def table(result, request, tmp_path):
    """Rows, their number, and a Parquet file of them."""
    pytest.importorskip("pyarrow")
    path = tmp_path / f"{request.param}.parquet"
    result.save(path, request.param)
    return request.param, list(result.table(request.param)), path


def test_pyarrow_reads_the_same_rows_with_the_documented_columns(table):
    of, rows, path = table
    read = pytest.importorskip("pyarrow.parquet").read_table(path)
    assert read.column_names == list(COLUMNS[of])
    assert read.to_pylist() == rows
    assert len(rows) == {"lights": 6, "maps": 4}[of]


def test_pandas_reads_the_same_numbers(table):
    of, rows, path = table
    frame = pytest.importorskip("pandas").read_parquet(path)
    column = {"lights": "red", "maps": "ambient_red"}[of]
    expected = [np.nan if row[column] is None else row[column] for row in rows]
    np.testing.assert_array_equal(frame[column], expected)


def test_polars_reads_the_same_rows(table):
    _, rows, path = table
    assert pytest.importorskip("polars").read_parquet(path).to_dicts() == rows


@pytest.mark.parametrize("of", ["lights", "maps"])
def test_lines_of_json_have_the_same_rows(result, of, tmp_path):
    result.save(tmp_path / "table.jsonl", of)
    lines = (tmp_path / "table.jsonl").read_text().splitlines()
    assert [json.loads(line) for line in lines] == list(result.table(of))


def test_a_light_of_the_table_is_that_of_the_rig(result):
    rig = el.fit(el.synthetic.plain(1, 128).radiance, lights=2)
    rows = [row for row in result.table() if row["name"] == "map-1"]
    np.testing.assert_array_equal([[row[c] for c in "xyz"] for row in rows], rig.lights.direction)
    np.testing.assert_array_equal([row["green"] for row in rows], rig.lights.irradiance[:, 1])
    assert [row["light"] for row in rows] == [0, 1]
    assert {row["error"] for row in rows} == {rig.error}


def test_the_reason_of_a_failure_is_in_the_table_of_maps(result):
    failures = {row["name"]: row["failure"] for row in result.table("maps")}
    assert failures.pop("bad").startswith("EnvLightsError: ")
    assert set(failures.values()) == {None}


def test_values_of_a_function_are_columns_and_mixed_ones_are_text(tmp_path):
    pytest.importorskip("pyarrow")
    images = [np.full((16, 32, 3), value, np.float32) for value in (1, 2)]

    def work(env):
        peak = float(env.radiance.max())
        return {"peak": peak, "mixed": peak if peak > 1 else "low", "inner": {"a": 1}}

    el.batch(images, what=work, jobs=1).save(tmp_path / "table.parquet", "maps")
    parquet = pytest.importorskip("pyarrow.parquet")
    rows = parquet.read_table(tmp_path / "table.parquet").to_pylist()
    assert [row["value_peak"] for row in rows] == [1.0, 2.0]
    assert [row["value_mixed"] for row in rows] == ['"low"', "2.0"]
    assert [row["value_inner"] for row in rows] == ['{"a": 1}'] * 2


def test_a_folder_is_loaded_with_its_rows(tmp_path):
    result = el.batch([("hall", el.synthetic.plain(0, 128).radiance)], tmp_path, lights=1)
    loaded = el.batches.Batch.load(tmp_path)
    assert list(loaded.rows()) == list(result.rows())
    assert loaded == result
    with pytest.raises(el.EnvLightsError, match="no batch is in the folder"):
        el.batches.Batch.load(tmp_path / "none")
