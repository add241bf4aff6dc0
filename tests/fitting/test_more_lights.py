"""One light more, and the error that the fit minimises."""

import numpy as np
import pytest

import envlights as el
from envlights.fitting import error_curve as curves

OBJECTIVES = ({"sizes": False}, *({"objective": name} for name in ("probe", "shadows", "mixed")))


def name_of(options):
    return options.get("objective", "points")


def discs(seed, count=12):
    """A map of discs of 0.5 to 12 degrees."""
    rng = np.random.default_rng(seed)
    shapes = [
        el.synthetic.Disc(
            tuple(towards / np.linalg.norm(towards)),
            float(rng.uniform(0.5, 12)),
            tuple(10 ** rng.uniform(0.5, 3.5) * rng.uniform(0.4, 1, 3)),
        )
        for towards in rng.normal(size=(count, 3))
    ]
    return el.EnvMap(el.synthetic.scene(64, background=[0.1, 0.2, 0.3], shapes=shapes).radiance)


def test_one_more_light_lowers_the_error_of_shadows():
    """The descent from points alone ended at 0.43 % with 9 lights and at 0.81 % with 10."""
    env = discs(1)
    errors = [el.fit(env, k, objective="shadows").report.shadow_error for k in range(1, 17)]
    least = np.minimum.accumulate(errors)
    assert (errors[1:] <= np.maximum(1.1 * least[:-1], 1e-3)).all(), errors


@pytest.mark.parametrize("seed", range(3))
def test_one_more_point_never_raises_the_error(seed):
    errors = [el.fit(discs(seed), k, sizes=False).error for k in range(9)]
    assert (np.diff(errors) <= 1e-3 * np.array(errors[:-1])).all(), errors


@pytest.mark.parametrize("options", OBJECTIVES, ids=name_of)
def test_an_error_curve_never_rises(options):
    curve = el.error_curve(discs(1), range(7), **options)
    assert (np.diff(curve.objective) <= 0).all(), curve
    assert all(used <= lights for used, lights in zip(curve.used, curve.lights, strict=True))


def test_the_rigs_of_an_error_curve_are_those_of_fits_on_their_own(tmp_path):
    """The map is read and reduced once, in memory or from a file."""
    discs(1).resized(512).save(tmp_path / "map.exr")
    for env in (discs(1), tmp_path / "map.exr"):
        for options in ({"ambient": "auto"}, {"floor": True, "max_radius": 0.2}):
            curve = el.error_curve(env, [3, 1], **options)
            alone = [el.fit(env, lights, **options) for lights in (3, 1)]
            assert curve.rigs == tuple(alone)


def test_a_row_holds_a_rig_of_fewer_lights_if_that_is_better(monkeypatch):
    """Three lights are fixed in wrong directions."""
    rigs = {count: el.fit(discs(1), count) for count in range(5)}
    rigs[3] = el.fit(discs(1), 3, fixed=np.eye(3))
    assert rigs[3].report.objective_error > rigs[2].report.objective_error
    by_count = lambda *given: [rigs[count] for count in given[-1]]  # noqa: E731
    monkeypatch.setattr(curves, "fit_map_by_count", by_count)
    curve = el.error_curve(discs(1), [4, 3, 2, 0])
    assert curve.used == (4, 2, 2, 0)
    assert curve.objective[1] == curve.objective[2] == rigs[2].report.objective_error
    assert curve.probe[1] == rigs[2].error


def test_the_error_that_a_fit_minimises_is_that_of_its_objective():
    env = discs(2)
    reports = {name: el.fit(env, 3, objective=name) for name in ("probe", "shadows", "mixed")}
    shadows = reports["shadows"].report
    assert shadows.objective_error == pytest.approx(shadows.shadow_error, rel=1e-12)
    probe = reports["probe"]
    assert probe.report.objective_error == pytest.approx(probe.error, rel=0.01)
    mixed = reports["mixed"]
    # Its square is a weighted mean of both squares.
    assert mixed.error < mixed.report.objective_error < mixed.report.shadow_error
    points = el.fit(env, 3, sizes=False)
    assert points.report.objective_error == points.error
    again = el.rigs.FitReport.from_dict(points.report.to_dict())
    assert again.objective_error == points.error


def test_a_curve_says_where_more_lights_raise_the_error_of_shadows():
    """The rows are in the order of the request; a change that is not printed is no rise."""
    shadows = (0.02, 0.03, 0.01, 0.0100001)
    rest = (0.0,) * 4
    curve = el.fitting.ErrorCurve((3, 4, 5, 6), (3, 4, 5, 6), rest, rest, shadows, rest, 0.33, 1.0)
    note = "note: more lights raise the error with shadows: 2 % with 3 to 3 % with 4"
    assert str(curve).splitlines()[-1] == note
    assert note in curve._repr_html_()
    falling = el.fitting.ErrorCurve((1, 2), (1, 2), (0, 0), (0, 0), (0.2, 0.1), (0, 0), 0.33, 1.0)
    assert "raise" not in str(falling)


def test_the_table_of_a_curve_is_that_of_its_fields():
    curve = el.error_curve(discs(0), (0, 2))
    header, *rows = (line.split(",") for line in curve.to_csv().splitlines())
    for name, cells in zip(header, zip(*rows, strict=True), strict=True):
        assert tuple(map(float, cells)) == tuple(map(float, getattr(curve, name)))
