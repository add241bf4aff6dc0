"""What the benchmarks judge by, and the peers that they compare with."""

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
MACHINE = {"processor": "none", "cores": 1, "threads": 1, "maps": 0, "quick": True, "date": "x"}


@pytest.fixture(scope="module")
def curves():
    """The modules of `benchmarks/curves`, which find each other by the folder above them."""
    sys.path.insert(0, str(ROOT / "benchmarks"))
    try:
        from curves import judge, page, peers_of_lights, results, scale

        found = {"judge": judge, "page": page, "peers": peers_of_lights}
        yield found | {"results": results, "scale": scale}
    finally:
        sys.path.remove(str(ROOT / "benchmarks"))


@pytest.fixture(scope="module")
def env():
    return el.EnvMap(el.synthetic.hall(64).radiance)


def test_the_judge_agrees_with_the_closed_forms_of_a_report(curves, env):
    judge = curves["judge"].Judge(env)
    for sizes in (True, False):
        rig = el.fit(env, lights=3, sizes=sizes)
        assert judge.probe_error(rig) == pytest.approx(rig.error, rel=0.02)
        assert judge.shadow_error(rig) == pytest.approx(rig.report.shadow_error, rel=0.02)


@pytest.mark.parametrize("name", ["median_cut", "variance_cuts", "k_means"])
def test_peers_keep_all_flux(curves, env, name):
    found = getattr(curves["peers"], name)(env.radiance, 16)
    assert len(found.lights) == 16
    np.testing.assert_allclose(found.lights.irradiance.sum(axis=0), flux(env.radiance), rtol=1e-5)


@pytest.mark.parametrize("name", ["median_cut", "variance_cuts", "k_means", "importance_samples"])
def test_more_lights_of_a_peer_have_less_error(curves, env, name):
    judge, find = curves["judge"].Judge(env), getattr(curves["peers"], name)
    few, many = (judge.probe_error(find(env.radiance, count)) for count in (4, 256))
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


def test_results_come_back_from_their_file(curves, tmp_path):
    results = curves["results"]
    points = [results.Point("probe", "hall", "exact", 0, 0.01, 0.1, {"probe": 1e-7})]
    results.write(tmp_path / "results.jsonl", {"cores": 2}, points)
    assert results.read(tmp_path / "results.jsonl") == ({"cores": 2}, points)


def test_the_command_names_its_parts():
    command = [sys.executable, "-m", "benchmarks", "nonsense"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 2
    assert "unknown part nonsense; there are lights, probe, detection, transfer" in done.stderr


def test_each_part_is_measured_alone_and_stays_on_the_page(tmp_path):
    """What an earlier run left is shown again: a long run can be taken up part by part."""
    parts = tmp_path / "benchmarks"
    parts.mkdir()
    row = {"part": "probe", "case": "a", "method": "exact", "setting": 0.0, "seconds": 0.1}
    left = [MACHINE, row | {"spread": 0.0, "errors": {"probe": 1e-7}}]
    (parts / "probe.jsonl").write_text("".join(json.dumps(line) + "\n" for line in left))
    command = [sys.executable, "-m", "benchmarks", "stress", "--quick", "--out", str(tmp_path)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    page = (tmp_path / "benchmarks.md").read_text()
    assert "| exact | 0 | 100 ms | 0 % | 1e-07 |" in page
    assert "a sun of one pixel at the upper pole" in page
    assert " NO " not in page


def test_what_is_better_in_both_is_told(curves):
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
        results.Point("p", "a", name, 1, seconds, 0.0, {"probe": error})
        for name, seconds, error in rows
    ]
    text = page.page([("p", part, MACHINE, points)])
    assert "more accurate than ours, error: wins (1) against ours (1) on 1 of 1." in text
    assert "matches in less time, error: fast (1) on 1 of 1; wins (1) on 1 of 1." in text


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


def two_runs(tmp_path, times, errors):
    """What two runs wrote: ours beside a peer of 2 s, all with spreads of 5 %."""
    for name, time, error in zip(("first", "second"), times, errors, strict=True):
        rows = [
            {"method": method, "seconds": seconds, "spread": 0.05, "errors": {"probe": error}}
            for method, seconds in (("exact", time), ("Monte Carlo", 2.0))
        ]
        parts = tmp_path / name / "benchmarks"
        parts.mkdir(parents=True)
        lines = [MACHINE, *({"part": "probe", "case": "a", "setting": None} | row for row in rows)]
        text = "".join(json.dumps(line) + "\n" for line in lines)
        (parts / "probe.jsonl").write_text(text)
    command = [sys.executable, "-m", "benchmarks", "--against", str(tmp_path / "second")]
    command += ["--out", str(tmp_path / "first")]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    return done, (tmp_path / "first/benchmarks.md").read_text()


def test_a_second_run_agrees_within_the_spreads(tmp_path):
    """Four spreads and a tenth allow a ratio to change by exp(0.3) = 1.35."""
    done, page = two_runs(tmp_path, (1.0, 1.3), (1e-3, 1e-3))
    assert done.returncode == 0, done.stderr
    assert "| The probe of a map | 1 | 1 | 30 % | 30 % | 30 % | 2 | 2 |" in page


def test_a_ratio_and_errors_that_changed_are_named(tmp_path):
    done, page = two_runs(tmp_path, (1.0, 1.4), (1e-3, 1.1e-3))
    assert done.returncode == 1
    assert "exact over Monte Carlo on a: 40 %, allowed 35 %" in done.stderr
    assert "probe of exact on a: 10 %" in done.stderr
    assert "| The probe of a map | 1 | 0 | 40 % | 40 % | 40 % | 2 | 0 |" in page


@pytest.mark.skipif(sys.platform != "linux", reason="memory is read from /proc")
def test_the_peak_memory_of_a_copy_is_that_of_the_copy(curves):
    megabytes = curves["scale"].peak("array.copy()", 2 * 1024**2)
    assert megabytes == pytest.approx(24, rel=0.05)
