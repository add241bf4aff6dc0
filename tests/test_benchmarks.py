"""What the benchmarks judge by, and the peers that they compare with."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import envlights as el
from tests.helpers import flux

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def curves():
    """The modules of `benchmarks/curves`, which find each other by the folder above them."""
    sys.path.insert(0, str(ROOT / "benchmarks"))
    try:
        from curves import judge, page, peers_of_lights, results

        yield {"judge": judge, "page": page, "peers": peers_of_lights, "results": results}
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
    assert "unknown part nonsense; there are lights, probe, detection, scale" in done.stderr
