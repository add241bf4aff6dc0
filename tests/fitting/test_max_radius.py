"""Lights with a largest radius."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import envlights as el
from envlights.cli import main

HALL = el.synthetic.hall(64).radiance

OPTIONS = {
    "lights": {"lights": 4},
    "floor": {"lights": 4, "floor": True},
    "probe": {"lights": 3, "objective": "probe"},
    "shadows": {"lights": 6, "objective": "shadows"},
    "harmonics": {"lights": 2, "ambient": "sh2"},
    "error": {"error": 0.05},
    "fixed": {"lights": 2, "fixed": [[0, 1, 0]]},
    "target": {"lights": 3, "target": "blender"},
}


@pytest.mark.parametrize("degrees", [1e-4, 3, 20])
@pytest.mark.parametrize("options", OPTIONS.values(), ids=OPTIONS)
def test_no_light_is_wider(options, degrees):
    rig = el.fit(HALL, **options, max_radius=np.deg2rad(degrees))
    assert (rig.lights.angular_radius <= np.deg2rad(degrees)).all()


def test_the_error_is_the_least_within_the_bound():
    """A rig whose radii are cut afterwards has a larger error."""
    free, bounded = el.fit(HALL, 4), el.fit(HALL, 4, max_radius=0.1)
    assert free.lights.angular_radius.max() > 0.1
    normals = el.kernels.icosphere(1280)[0]
    expected = el.EnvMap(HALL).probe(normals)
    lights = free.lights
    cut = el.Rig(
        free.ambient,
        el.Lights(lights.direction, lights.irradiance, np.minimum(lights.angular_radius, 0.1)),
        error=0.0,
    )
    errors = [np.linalg.norm(rig.probe(normals) - expected) for rig in (bounded, cut)]
    assert errors[0] < errors[1]


def test_a_bound_that_no_light_reaches_changes_nothing():
    sun = el.synthetic.scene(
        128, background=[0.5] * 3, shapes=[el.synthetic.Disc((0, 1, 0), 5, (90, 90, 90))]
    ).radiance
    free, bounded = el.fit(sun, 1), el.fit(sun, 1, max_radius=0.35)
    np.testing.assert_array_equal(free.lights.angular_radius, bounded.lights.angular_radius)
    assert bounded.report.at_max_radius == ()


def test_the_report_names_the_lights_at_the_bound():
    disc = el.synthetic.Disc((0, 1, 0), 30, (9, 9, 9))
    small = el.synthetic.Disc((0, -1, 0), 4, (900, 900, 900))
    world = el.synthetic.scene(128, background=[0.5] * 3, shapes=[disc, small]).radiance
    rig = el.fit(world, 2, max_radius=np.deg2rad(20))
    row = int(rig.lights.direction[:, 1].argmax())
    assert rig.report.at_max_radius == (row,)
    assert f"largest radius reached by light {row + 1}" in str(rig.report)
    assert el.rigs.FitReport.from_dict(rig.report.to_dict()).at_max_radius == (row,)
    assert el.fit(world, 2).report.at_max_radius == ()


@pytest.mark.parametrize("bad", [0, -0.1, 1.6, np.nan, "wide"])
def test_an_impossible_radius_is_refused(bad):
    with pytest.raises(el.EnvLightsError, match="max_radius must be"):
        el.fit(HALL, max_radius=bad)


def test_a_radius_of_points_is_refused():
    with pytest.raises(el.EnvLightsError, match="max_radius must not be set for points"):
        el.fit(HALL, max_radius=0.3, sizes=False)


def test_the_command_takes_degrees(tmp_path):
    path = tmp_path / "hall.hdr"
    el.EnvMap(HALL).save(path)
    run = CliRunner().invoke(main, ["fit", str(path), "--max-radius", "20", "--json"])
    assert run.exit_code == 0, run.output
    rig = el.fit(path, max_radius=np.deg2rad(20))
    radii = json.loads(run.stdout)["lights"]["angular_radius"]
    np.testing.assert_allclose(radii, rig.lights.angular_radius)
