"""Errors and peers of the benchmarks."""

import importlib
import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import envlights as el
from tests.helpers import angle_deg, flux

ROOT = Path(__file__).parents[1]
MACHINE = {"processor": "none", "cores": 1, "threads": 1, "quick": True, "date": "x"}
MACHINE |= {"processes": 1}


@pytest.fixture(scope="module")
def curves():
    """The modules of `benchmarks/curves`, which find each other by the folder above them."""
    sys.path.insert(0, str(ROOT / "benchmarks"))
    try:
        import stopwatch
        from curves import errors_of_rigs, page, peers_of_lights, peers_refitted, results, scale
        from tables import second_run

        found = {
            "errors": errors_of_rigs,
            "page": page,
            "peers": peers_of_lights,
            "refitted": peers_refitted,
            "stopwatch": stopwatch,
        }
        yield found | {"results": results, "scale": scale, "second_run": second_run}
    finally:
        sys.path.remove(str(ROOT / "benchmarks"))


@pytest.fixture(scope="module")
def env():
    return el.EnvMap(el.synthetic.hall(64).radiance)


def test_the_judge_agrees_with_the_closed_forms_of_a_report(curves, env):
    evaluation = curves["errors"].Evaluation(env)
    for sizes in (True, False):
        rig = el.fit(env, lights=3, sizes=sizes)
        assert evaluation.probe_error(rig) == pytest.approx(rig.error, rel=0.02)
        assert evaluation.shadow_error(rig) == pytest.approx(rig.report.shadow_error, rel=0.02)


@pytest.mark.parametrize("name", ["median_cut", "variance_cuts", "k_means"])
def test_peers_keep_all_flux(curves, env, name):
    found = getattr(curves["peers"], name)(env.radiance, 16)
    assert len(found.lights) == 16
    np.testing.assert_allclose(found.lights.irradiance.sum(axis=0), flux(env.radiance), rtol=1e-5)


@pytest.mark.parametrize("name", ["median_cut", "variance_cuts", "k_means", "importance_samples"])
def test_more_lights_of_a_peer_have_less_error(curves, env, name):
    evaluation, find = curves["errors"].Evaluation(env), getattr(curves["peers"], name)
    few, many = (evaluation.probe_error(find(env.radiance, count)) for count in (4, 256))
    assert many < few / 4


def test_projected_harmonics_are_those_of_the_package(curves, env):
    """The third order of the clamped cosine is zero, so that orders 2 and 3 are one."""
    normals, _ = el.kernels.icosphere(320)
    ambient = curves["peers"].projected_harmonics(env.radiance, 2).ambient
    directions = el.kernels.pixel_directions(64, 128).reshape(-1, 3)
    areas = el.kernels.pixel_solid_angles(64, 128).reshape(-1, 1)
    ours = el.kernels.harmonic_radiance(directions).T @ (env.radiance.reshape(-1, 3) * areas)
    wanted = el.kernels.harmonic_irradiance(normals) @ ours
    np.testing.assert_allclose(ambient.irradiance(normals), wanted, rtol=1e-9)


@pytest.mark.parametrize("sharpness", [0.5, 20.0, 500.0])
def test_the_irradiance_of_a_spherical_gaussian_is_the_sum_over_its_pixels(curves, sharpness):
    normals, _ = el.kernels.icosphere(80)
    axis = np.array([[0.6, 0.8, 0.0]])
    seen = curves["refitted"]._lobe_columns(normals, axis, np.array([sharpness]))[:, 1]
    directions = el.kernels.pixel_directions(256, 512).reshape(-1, 3)
    lobe = np.exp(sharpness * (directions @ axis[0] - 1))
    flux = lobe * el.kernels.pixel_solid_angles(256, 512).ravel()
    wanted = np.maximum(normals @ directions.T, 0) @ flux
    np.testing.assert_allclose(seen, wanted, atol=1e-3 * wanted.max())


@pytest.mark.parametrize("name", ["k_means", "median_cut"])
def test_refitted_radiances_have_less_error(curves, env, name):
    evaluation = curves["errors"].Evaluation(env)
    as_found = getattr(curves["peers"], name)(env.radiance, 4)
    refitted = getattr(curves["refitted"], f"{name}_refitted")(env.radiance, 4)
    assert evaluation.probe_error(refitted) < evaluation.probe_error(as_found)
    assert min(refitted.lights.irradiance.min(), refitted.ambient.min()) >= 0


def test_discs_by_scipy_find_the_disc_of_a_map(curves):
    direction = np.array([[0.48, 0.6, 0.64]])
    radiance = el.kernels.pixel_directions(128, 256) @ direction[0] > np.cos(0.3)
    radiance = (0.1 + 5.0 * radiance[..., None] * np.ones(3)).astype(np.float32)
    rig = curves["refitted"].discs_by_scipy(radiance, 1)
    assert angle_deg(rig.lights.direction[0], direction[0]) < 0.2
    # The border of the disc is that of pixels, 0.012 radians wide.
    assert rig.lights.angular_radius[0] == pytest.approx(0.3, abs=0.01)
    np.testing.assert_allclose(rig.ambient, 0.1, rtol=0.02)


def test_squares_instead_of_bounds_end_at_the_bounded_minimum(curves, env):
    """For two lights; a single one stays at a radiance of zero, where squares have no gradient."""
    pytest.importorskip("jaxopt")
    evaluation = curves["errors"].Evaluation(env)
    errors = [
        evaluation.probe_error(getattr(curves["refitted"], name)(env.radiance, 2))
        for name in ("points_by_scipy", "points_by_jaxopt")
    ]
    assert errors[0] == pytest.approx(errors[1], rel=1e-3)


def test_results_come_back_from_their_file(curves, tmp_path):
    results = curves["results"]
    points = [results.point("probe", "hall", "exact", 0, {"probe": 1e-7}, call=[[0.01], [0.02]])]
    results.write(tmp_path / "results.jsonl", {"cores": 2}, points)
    assert results.read(tmp_path / "results.jsonl") == ({"cores": 2}, points)


def test_the_command_names_its_parts():
    command = [sys.executable, "-m", "benchmarks", "nonsense"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 2
    assert (
        "unknown part nonsense; there are lights, refitted, probe, detection, transfer"
        in done.stderr
    )


@pytest.mark.slow
def test_each_part_is_measured_alone_and_stays_on_the_page(tmp_path):
    """Parts of an earlier run stay on the page, so a long run can be resumed."""
    parts = tmp_path / "benchmarks"
    parts.mkdir()
    row = {"part": "probe", "case": "a", "method": "exact", "setting": 0.0, "seconds": 0.1}
    times = {"spread": 0.0, "rounds": {"call": [[0.1]]}}
    left = [MACHINE, row | times | {"errors": {"probe": 1e-7}}]
    (parts / "probe.jsonl").write_text("".join(json.dumps(line) + "\n" for line in left))
    command = [sys.executable, "-m", "benchmarks", "stress", "--quick", "--out", str(tmp_path)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    page = (tmp_path / "benchmarks.md").read_text()
    assert "| exact | 0 | 100 ms | 0 % | 1e-07 |" in page
    assert "a sun of one pixel at the upper pole" in page
    assert " NO " not in page


def test_a_peer_that_is_better_in_both_is_reported(curves):
    """A peer that wins, one that nothing of ours beats, and one that loses."""
    results, page = curves["results"], curves["page"]
    part = SimpleNamespace(
        __doc__="Doc.",
        points=None,
        TITLE="T",
        ERRORS={"probe": "error"},
        OURS=("ours",),
        are_comparable=lambda our, their: True,
    )
    rows = [("ours", 1.0, 0.1), ("wins", 0.5, 0.05), ("fast", 0.5, 0.2), ("loses", 2.0, 0.2)]
    points = [
        results.point("p", "a", name, 1, {"probe": error}, call=[[seconds]])
        for name, seconds, error in rows
    ]
    text = page.page([("p", part, MACHINE, points)])
    cases = "(number of cases):"
    assert f"with a smaller error {cases} wins (1) against ours (1) on 1 of 1." in text
    assert f"both time and error {cases} fast (1) on 1 of 1; wins (1) on 1 of 1." in text


def test_mksource_finds_a_sun(curves):
    pytest.importorskip("pyradiance")
    radiance = np.full((64, 128, 3), 0.1, np.float32)
    radiance[20:22, 30:32] = 500, 400, 300
    found = curves["peers"].by_mksource(radiance, 2.0)
    towards = el.kernels.pixel_directions(64, 128)[20:22, 30:32].mean(axis=(0, 1))
    assert angle_deg(found.lights.direction[0], towards / np.linalg.norm(towards)) < 3
    whole = found.lights.irradiance.sum(axis=0) + 4 * np.pi * found.ambient
    np.testing.assert_allclose(whole, flux(radiance), rtol=1e-3)


def test_a_probe_of_mitsuba_tends_to_ours(curves, env):
    pytest.importorskip("mitsuba")
    from curves.mitsuba_probe import Probe

    normals, _ = el.kernels.icosphere(20)
    probe, wanted = Probe(env.radiance, normals, 1), env.probe(normals)
    few, many = (np.linalg.norm(probe.render(n) - wanted) for n in (64, 4096))
    assert many < min(few / 3, 0.03 * np.linalg.norm(wanted))


def test_processes_become_one_point(curves):
    """Medians over the rounds, then over the processes; an error that is a run time likewise."""
    results = curves["results"]
    calls, fits = ([1.0, 9.0, 2.0], [3.0], [4.0, 4.0]), ([5.0], [6.0], [8.0])
    passes = [
        [results.point("t", "room", "ours", 4, errors, call=[call], fit=[fit])]
        for errors, call, fit in zip(({"unseen": 0.1}, {}, {}), calls, fits, strict=True)
    ]
    (found,) = results.merge(passes)
    assert found.seconds == 3.0
    assert found.errors == {"unseen": 0.1, "fit": 6.0}
    assert found.rounds == {"call": list(calls), "fit": list(fits)}


def test_a_round_that_is_slow_for_both_changes_no_ratio(curves):
    results = curves["results"]
    ours, theirs = [[1.0, 7.0, 1.0], [2.0, 2.0]], [[2.0, 14.0, 2.0, 5.0], [4.0, 4.0]]
    np.testing.assert_allclose(results.logarithms(ours, theirs), np.log(0.5))


def test_the_interval_holds_the_mean_as_often_as_is_said(curves):
    results = curves["results"]
    draws = np.random.default_rng(0).normal(3, 0.1, (4000, 9))
    found = np.array([results.interval(draw) for draw in draws])
    share = np.mean(np.abs(found[:, 0] - 3) <= found[:, 1])
    # The standard deviation of the fraction of 4000 is 0.0005.
    assert share == pytest.approx(results.CONFIDENCE, abs=0.002)
    assert results.interval([1.0])[1] == np.inf


def test_a_short_piece_of_work_is_repeated(curves):
    """The clock goes on by what each piece takes."""
    now, calls = [0.0], {"short": 0, "long": 0}

    def piece(name, seconds):
        calls[name] += 1
        now[0] += seconds

    work = {"short": lambda: piece("short", 0.25), "long": lambda: piece("long", 8.0)}
    found = curves["stopwatch"].all_seconds(
        work, 3, patience=10.0, clock=lambda: now[0], fewest=1, shortest=1.0
    )
    assert found == {"short": [0.25, 0.25, 0.25], "long": [8.0]}
    assert calls == {"short": 12, "long": 1}


#: Of nine processes, with a standard deviation of 1.94 %: half the interval of 99.9 % is 3.3 %.
PROCESSES = (1.0, 1.03, 0.97, 1.02, 0.98, 1.01, 0.99, 1.01, 0.99)


def two_runs(tmp_path, times, errors, processes=PROCESSES):
    """Results of two runs: ours, with different processes, and a peer of 2 s."""
    for name, time, error in zip(("first", "second"), times, errors, strict=True):
        ours = [[time * factor] for factor in processes]
        rows = [
            {"method": method, "seconds": 1.0, "spread": 0.05, "rounds": {"call": seconds}}
            for method, seconds in (("exact", ours), ("Monte Carlo", [[2.0]] * len(ours)))
        ]
        parts = tmp_path / name / "benchmarks"
        parts.mkdir(parents=True)
        same = {"part": "probe", "case": "a", "setting": None, "errors": {"probe": error}}
        lines = [MACHINE | {"processes": len(ours)}, *(same | row for row in rows)]
        text = "".join(json.dumps(line) + "\n" for line in lines)
        (parts / "probe.jsonl").write_text(text)
    command = [sys.executable, "-m", "benchmarks", "--against", str(tmp_path / "second")]
    command += ["--out", str(tmp_path / "first")]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    page = tmp_path / "first/benchmarks.md"
    return done, page.read_text() if page.exists() else ""


def test_the_page_is_what_its_data_say(curves):
    """A section written by hand would be lost when the page is measured again."""
    parts = importlib.import_module("benchmarks.__main__").parts_of(ROOT / "docs/lab")
    page = (ROOT / "docs/lab/benchmarks.md").read_text(encoding="utf-8")
    assert page == curves["page"].page(parts)


def test_a_second_run_agrees_where_the_intervals_overlap(tmp_path):
    """Two of 3.3 % allow a ratio to change by 6.7 %."""
    done, page = two_runs(tmp_path, (1.0, 1.06), (1e-3, 1e-3))
    assert done.returncode == 0, done.stderr
    assert "| The probe of a map | 1 | 1 | 3.3 % | 3.3 % | 6 % | 6 % | 6 % | 2 | 2 |" in page


def test_a_ratio_and_errors_that_changed_are_named(tmp_path):
    done, page = two_runs(tmp_path, (1.0, 1.08), (1e-3, 1.1e-3))
    assert done.returncode == 1
    assert "exact over Monte Carlo on a: 8 %, allowed 6.7 %" in done.stderr
    assert "probe of exact on a: 10 %" in done.stderr
    assert "| The probe of a map | 1 | 0 | 3.3 % | 3.3 % | 8 % | 8 % | 8 % | 2 | 0 |" in page


def test_runs_of_one_process_are_not_compared(tmp_path):
    done, page = two_runs(tmp_path, (1.0, 50.0), (1e-3, 1e-3), processes=(1.0,))
    assert done.returncode == 1
    assert "probe: a run of one process has no intervals" in done.stderr
    assert not page


@pytest.mark.parametrize(("again", "agrees"), [((25.0, 0.9), True), ((26.0, 0.0), False)])
def test_memory_agrees_to_a_fiftieth(curves, again, agrees):
    """A fiftieth of itself and of 50 MB, because the allocator reserves pages in advance."""
    results, second_run = curves["results"], curves["second_run"]
    runs = [
        [
            results.point("scale", "pixels", name, 1, {"memory": megabytes}, call=[[1.0]])
            for name, megabytes in zip(("array.copy()", "detect"), run, strict=True)
        ]
        for run in ((24.0, 0.2), again)
    ]
    _, errors = second_run.changes(curves["scale"], *runs)
    assert [each.agrees for each in errors] == [agrees, True]


@pytest.mark.skipif(sys.platform != "linux", reason="memory is read from /proc")
def test_the_peak_memory_of_a_copy_is_that_of_the_copy(curves):
    megabytes = curves["scale"].peak("array.copy()", 2 * 1024**2)
    assert megabytes == pytest.approx(24, rel=0.05)


def test_the_table_of_programs_names_what_a_program_does_not_show(curves):
    del curves  # it opens the folder
    programs = importlib.import_module("programs")
    wide = el.Rig([0, 0, 0], el.Lights([[0.48, 0.8, 0.36]], [[3, 2, 1]], [0.5]), 0.0)
    assert "points" not in programs.cell("a size", wide, "csv", "file", "")
    off, _, named = programs.cell("a size", wide, "unity", "file", "").partition(": ")
    assert float(off.split()[0]) > programs.NAMED
    loss, _, rest = named.partition(", ")
    assert loss == "lights as points"
    assert float(rest.split()[0]) < 1e-3
