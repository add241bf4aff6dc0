"""Rows are equal on all executors, also when a worker is killed."""

import os
import signal
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import envlights as el
from envlights.batches.executors import threads_of
from tests.batches.helpers import BROKEN, check_whole, write_maps


def rows(result):
    """Rows without their wall times."""
    return [{**row, "seconds": None} for row in result.rows()]


@pytest.mark.parametrize("executor", ["thread", "process", ThreadPoolExecutor(2)])
def test_rows_are_those_of_one_job(tmp_path, executor):
    write_maps(tmp_path / "maps", 9)
    expected = el.batch(tmp_path / "maps", tmp_path / "one", lights=1, jobs=1)
    result = el.batch(tmp_path / "maps", tmp_path / "two", lights=1, jobs=2, executor=executor)
    assert rows(result) == rows(expected)
    assert len(result) == 9


def test_an_executor_of_spawned_processes_is_taken(tmp_path):
    good = write_maps(tmp_path / "maps", 9)
    with ProcessPoolExecutor(1, get_context("spawn")) as executor:
        result = el.batch(tmp_path / "maps", tmp_path / "out", lights=1, executor=executor)
    check_whole(result, tmp_path / "out", good)


class Job:
    """Result of `Cluster.submit`, which is no future of the standard library."""

    def __init__(self, work, task):
        self.result = lambda: work(task)


class Cluster:
    """Executor that is none of the standard library."""

    submit = Job


def test_an_executor_needs_only_submit_and_jobs_only_result():
    maps = [el.synthetic.plain(seed, 128).radiance for seed in range(5)]
    expected = el.batch(maps, lights=1, jobs=1)
    assert rows(el.batch(maps, lights=1, executor=Cluster())) == rows(expected)


@pytest.mark.parametrize("executor", [3, object(), lambda: None])
def test_an_object_without_submit_is_refused(executor):
    with pytest.raises(el.EnvLightsError, match=r"an object with the method submit\(f, x\)"):
        el.batch([np.ones((8, 16, 3))], executor=executor)


def test_a_job_without_a_result_is_refused():
    cluster = SimpleNamespace(submit=lambda work, task: None)
    with pytest.raises(el.EnvLightsError, match=r"must return an object with .* result\(\)"):
        el.batch([np.ones((8, 16, 3))], executor=cluster)


class _Elsewhere(Executor):
    """Executor that could have its workers on other machines."""


def test_threads_of_this_machine_are_shared_only_by_its_workers():
    cores = el.threads()
    assert threads_of(None, cores) == threads_of("process", cores) == 1
    assert threads_of(None, 1) == cores
    with ThreadPoolExecutor(1) as pool:
        assert threads_of(pool, 1) == cores
    assert threads_of(_Elsewhere(), 64) is None


def test_threads_are_as_before_after_a_batch():
    before = el.threads()
    el.batch([el.synthetic.plain(seed, 128).radiance for seed in range(3)], lights=1, jobs=2)
    assert el.threads() == before


def kill_itself(env, *, mark):
    """Kill the process of the worker once; then fit."""
    if not Path(mark).exists():
        Path(mark).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return el.fit(env, lights=1)


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="Windows has no SIGKILL")
def test_a_killed_worker_of_a_pool_is_a_refusal_and_the_batch_goes_on(tmp_path):
    good = write_maps(tmp_path / "maps", 9)
    out, mark = tmp_path / "out", str(tmp_path / "mark")
    arguments = {"what": kill_itself, "mark": mark, "jobs": 2, "executor": "process"}
    with pytest.raises(el.EnvLightsError, match="a worker process was killed"):
        el.batch(tmp_path / "maps", out, **arguments)
    check_whole(el.batch(tmp_path / "maps", out, **arguments), out, good)


@pytest.mark.slow
def test_a_killed_worker_of_dask_costs_nothing(tmp_path):
    distributed = pytest.importorskip("distributed")
    good = write_maps(tmp_path / "maps", 40)
    out, mark = tmp_path / "out", str(tmp_path / "mark")
    with (
        distributed.LocalCluster(2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        result = el.batch(tmp_path / "maps", out, what=kill_itself, mark=mark, executor=client)
    check_whole(result, out, good)
    assert result.unchanged == 0
    assert len(result.failures) == len(BROKEN)
