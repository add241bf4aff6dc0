"""Rigs: round trips, order, words."""

import contextlib
import copy
import json
import pickle
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import envlights as el

POSITIVE = st.floats(0, 1e30, allow_subnormal=False)
RGB = st.tuples(POSITIVE, POSITIVE, POSITIVE)
UNIT = st.tuples(st.floats(0, 1), st.floats(0, 1))


def a_rig():
    report = el.rigs.FitReport(
        search_errors={0: 0.5, 1: 0.3},
        sized_error=0.25,
        steps=7,
        stop_reason=el.rigs.StopReason.CONVERGED,
        seconds={"fit": 0.5},
        measured_on="5 normals",
        ambient="constant",
        ambients={"none": (3, 0.5), "constant": (2, 0.25)},
        channel_errors=(0.2, 0.25, 0.3),
        max_error=0.5,
        shadow_error=0.031,
        direction_tolerances=(np.deg2rad(1.2), np.pi),
        condition=np.inf,
        direction_errors=(0.01, 0.0),
        irradiance_errors=((0.1, 0.2, np.inf), (0.0, 0.0, 0.0)),
        fixed=(1,),
        skipped=("a",),
    )
    lights = el.Lights([[0, 1, 0], [1, 0, 0]], [[1, 1, 1], [5, 4, 3]], [0.0, 0.5])
    return el.Rig([0.1, 0.2, 0.3], lights, 0.25, report, ("alpha was ignored",), floor=True)


@given(RGB, st.lists(st.tuples(UNIT, RGB, st.floats(0, np.pi / 2)), max_size=4), st.booleans())
def test_saved_rigs_come_back_to_the_bit(tmp_path_factory, ambient, lights, floor):
    direction = el.kernels.uniform_sphere(np.reshape([uv for uv, *_ in lights], (-1, 2)))
    irradiance = np.reshape([rgb for _, rgb, _ in lights], (-1, 3))
    radius = [radius for *_, radius in lights]
    rig = el.Rig(ambient, el.Lights(direction, irradiance, radius), error=0.125, floor=floor)
    path = tmp_path_factory.mktemp("rig") / "rig.json"
    rig.save(path)
    again = el.Rig.load(path)
    np.testing.assert_array_equal(again.ambient, rig.ambient)
    np.testing.assert_array_equal(again.lights.direction, rig.lights.direction)
    np.testing.assert_array_equal(again.lights.irradiance, rig.lights.irradiance)
    np.testing.assert_array_equal(again.lights.angular_radius, rig.lights.angular_radius)
    assert again.floor is floor
    assert again.to_dict() == rig.to_dict()


def test_notes_may_be_one_text():
    rig = el.Rig([1, 1, 1], el.Lights([[0, 1, 0]], [[1, 1, 1]]), notes="mine")
    assert rig.notes == ("mine",)
    with pytest.raises(el.EnvLightsError, match="notes must be text; got 5"):
        el.Rig(rig.ambient, rig.lights, notes=5)


def test_reports_and_notes_are_saved(tmp_path):
    a_rig().save(tmp_path / "rig.json")
    again = el.Rig.load(tmp_path / "rig.json")
    assert again.report == a_rig().report
    assert again.notes == a_rig().notes


#: As the package wrote it before a report had tolerances and a choice of the ambient term, and
#: before lights had sizes.
OLDER = """{
  "format": "envlights rig", "version": 2, "frame": "", "units": "", "ambient": [0.1, 0.2, 0.3],
  "lights": {"direction": [[0.0, 1.0, 0.0]], "irradiance": [[3.0, 2.0, 1.0]]}, "error": 0.01,
  "report": {"errors": {"0": 0.5, "1": 0.01}, "steps": 7, "stop_reason": "CONVERGED",
    "seconds": {"fit": 0.5}, "measured_on": "5120 normals that were not fitted",
    "channel_errors": [0.01, 0.01, 0.01], "max_error": 0.02, "condition": "infinite",
    "direction_errors": [0.001], "irradiance_errors": [[0.1, "infinite", 0.0]],
    "skipped": []}, "notes": []}"""


def test_files_of_older_reports_are_read(tmp_path):
    (tmp_path / "rig.json").write_text(OLDER)
    rig = el.Rig.load(tmp_path / "rig.json")
    assert rig.report.condition == np.inf
    assert rig.report.direction_errors == (0.001,)
    assert rig.report.direction_tolerances == ()
    assert (rig.report.ambient, rig.report.ambients) == ("", {})
    assert rig.report.shadow_error is None
    assert rig.lights.angular_radius.tolist() == [0.0]
    assert rig.floor is False
    rig.save(tmp_path / "again.json")
    assert el.Rig.load(tmp_path / "again.json").report == rig.report


def test_times_are_read_from_older_files_and_not_written(tmp_path):
    (tmp_path / "rig.json").write_text(OLDER)
    rig = el.Rig.load(tmp_path / "rig.json")
    assert rig.report.seconds == {"fit": 0.5}
    assert "fit: 500.0 ms" in rig.verbose()
    assert "seconds" not in rig.to_dict()["report"]


@pytest.mark.parametrize("value", [[np.inf, 1, 1], [1e39, 1, 1], [-1, 1, 1]])
def test_light_beyond_single_precision_is_refused(value):
    with pytest.raises(el.EnvLightsError, match="irradiance must be finite, not negative, and at"):
        el.Lights([[0, 1, 0]], [value])
    with pytest.raises(el.EnvLightsError, match="ambient must"):
        el.Rig(value, el.Lights([[0, 1, 0]], [[1, 1, 1]]), 0.0)


def test_the_largest_light_is_exact_or_refused_by_each_target(tmp_path):
    """The radiance of a small disc may not fit into single precision even if its light does."""
    lights = el.Lights([[0, 1, 0]], [[3.4e38, 1, 1]], [0.001])
    assert np.isfinite(lights.spherical_gaussians().amplitude).all()
    with pytest.raises(el.EnvLightsError, match="too bright for a map of single precision"):
        lights.to_map(64)
    with pytest.raises(el.EnvLightsError, match="Radiance has single precision"):
        lights.save(tmp_path / "rig.rad")
    for target in el.export.TARGETS:
        path = tmp_path / f"rig{target.suffixes[0]}"
        with contextlib.suppress(el.EnvLightsError):
            lights.save(path)
            assert not re.search(r"\b(inf|nan)", path.read_text(), re.IGNORECASE)
    assert len(list(tmp_path.iterdir())) >= 8


def test_lights_are_sorted_and_sliced():
    lights = a_rig().lights
    np.testing.assert_array_equal(lights.direction[0], [1, 0, 0])
    assert len(lights[:1]) == 1
    assert lights[1:].to_dict() == {
        "direction": [[0, 1, 0]],
        "irradiance": [[1, 1, 1]],
        "angular_radius": [0],
        "scale": "the map's own scale",
        "origin": [1],
    }
    with pytest.raises(ValueError, match="read-only"):
        lights.direction[0] = 0


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
def test_copies_are_whole_and_as_closed_as_the_first(copied):
    again = copied(a_rig())
    assert again.to_dict() == a_rig().to_dict()
    for array in (again.ambient, again.lights.direction, again.lights.irradiance):
        assert not array.flags.writeable


def test_a_rig_is_a_line_in_a_list_and_a_table_in_a_notebook():
    formatters = pytest.importorskip("IPython.core.formatters")
    assert repr(a_rig()) == "<Rig: ambient + 2 lights, error 25 %>"
    assert repr(a_rig().lights[:1]) == "<Lights: 1 light>"
    for result in (a_rig(), a_rig().lights):
        assert formatters.PlainTextFormatter()(result) == str(result)


def test_what_nobody_measured_is_not_claimed():
    rig = el.Rig([0, 0, 0], a_rig().lights, error=0.0)
    assert "relative RMS error 0 %" in str(rig)
    assert str(rig.report) == "not fitted"
    assert not rig.report.stop_reason.is_success
    assert "note" not in str(rig)
    assert "shadows" not in str(rig)
    assert "floor" not in str(rig)


def test_the_table_says_where_each_light_is_and_how_wrong_the_rig_is():
    text = str(a_rig())
    assert "  90.0°      +0.0°    80.5 %" in text
    assert "relative RMS error 25 % over a floor, with shadows 3.1 %" in text
    assert "a floor hides ambient light from below the horizon" in text
    assert "note: alpha was ignored" in text
    report = a_rig().report.verbose()
    assert (
        "error in the search by number of lights, as points: 0: 50 %  1: 30 %; with sizes: 25 %"
        in report
    )
    assert "\nerror with shadows 3.1 %\n" in report
    assert "error in red, green, blue: 20 %  25 %  30 %; largest 50 %" in report
    assert (
        "ambient term 'constant' selected from  none: 3 lights, 50 %  constant: 2 lights, 25 %"
        in report
    )
    assert "direction tolerance (10 % more error): 1.2°  180°" in report
    wide = replace(a_rig().report, direction_tolerances=tuple(np.radians([99.4, 99.7, 100.6])))
    assert "(10 % more error): 99°  100°  101°" in wide.verbose()
    measured = replace(a_rig().report, direction_tolerances=()).verbose()
    assert "condition number inf" in measured
    assert "standard error of the directions: 0.57°  0°" in measured
    assert "no directional light" in str(
        el.Rig([1, 1, 1], el.Lights(np.zeros((0, 3)), np.zeros((0, 3))), 0)
    )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"format": "another"}, "is not a rig"),
        ({"version": 1}, "version 1; this package reads 2, 3, 4"),
        ({"version": 6}, "version 6; this package reads 2, 3, 4, 5"),
        ({"floor": 1}, "floor must be True or False; got 1"),
        (
            {"lights": {**a_rig().lights.to_dict(), "angular_radius": [0.1]}},
            r"a row for each light \(2\); got 1",
        ),
        ({"lights": {**a_rig().lights.to_dict(), "angular_radius": [0.1, 2]}}, "row 1 holds 2"),
        ({"ambient": [0, 0, -1]}, "ambient must"),
        ({"ambient": [0, 0, float("nan")]}, "ambient must be"),
        ({"lights": {"direction": [[0, 2, 0]], "irradiance": [[1, 1, 1]]}}, "unit vector"),
        ({"lights": {"direction": [[0, 1, 0]], "irradiance": [[1, 1, -1]]}}, "not negative"),
        (
            {"lights": {"direction": [[0, 1, 0]], "irradiance": []}},
            "irradiance must have the shape",
        ),
        (
            {"lights": {"direction": [[0, 1]], "irradiance": [[1, 1]]}},
            "is not a complete rig: a value",
        ),
        ({"lights": None}, "is not a complete rig: a value"),
        ({"lights": {"direction": []}}, "is not a complete rig: the key 'irradiance' is missing"),
        ({"error": "small"}, "holds an impossible rig"),
        ({"report": {**a_rig().to_dict()["report"], "stop_reason": "TIRED"}}, "got 'TIRED'"),
    ],
)
def test_impossible_files_are_refused(tmp_path, change, message):
    path = tmp_path / "rig.json"
    path.write_text(json.dumps({**a_rig().to_dict(), **change}))
    with pytest.raises(el.EnvLightsError, match=message):
        el.Rig.load(path)


@pytest.mark.parametrize(
    ("content", "message"), [("", "is not a JSON file"), ("[1]", "is not a rig")]
)
def test_files_of_another_kind_are_refused(tmp_path, content, message):
    (tmp_path / "rig.json").write_text(content)
    with pytest.raises(el.EnvLightsError, match=message):
        el.Rig.load(tmp_path / "rig.json")


def test_missing_files_and_other_suffixes_are_refused(tmp_path):
    with pytest.raises(el.EnvLightsError, match="cannot read"):
        el.Rig.load(tmp_path / "none.json")
    with pytest.raises(el.EnvLightsError, match=r"the suffix must be one of \.json, \.csv"):
        a_rig().save(tmp_path / "rig.yaml")


REPORT = a_rig().to_dict()["report"]


@pytest.mark.parametrize(
    "change",
    [
        {"error": float("nan")},
        {"error": -1},
        {"error": 10**400},
        {"error": True},
        {"report": {**REPORT, "search_errors": {"1": float("nan")}}},
        {"report": {**REPORT, "steps": "x"}},
        {"report": {**REPORT, "seconds": {"fit": -1}}},
        {"report": {**REPORT, "direction_tolerances": [-1]}},
        {"report": {**REPORT, "shadow_error": -0.1}},
        {"report": {**REPORT, "ambients": {"none": {"lights": 0.5, "error": 0}}}},
    ],
)
def test_files_with_impossible_numbers_are_refused(tmp_path, change):
    path = tmp_path / "rig.json"
    path.write_text(json.dumps({**a_rig().to_dict(), **change}))
    with pytest.raises(
        el.EnvLightsError,
        match=r"impossible rig: ((search_|shadow_)?error|steps|seconds|direction_tol|ambients)",
    ):
        el.Rig.load(path)


def test_nested_brackets_without_end_are_refused(tmp_path):
    path = tmp_path / "rig.json"
    path.write_text("[" * 100_000)
    with pytest.raises(el.EnvLightsError, match="is not a JSON file"):
        el.Rig.load(path)


def test_an_error_that_is_no_number_is_refused_before_it_is_saved():
    with pytest.raises(el.EnvLightsError, match="error must be a finite number"):
        el.Rig([0, 0, 0], a_rig().lights, float("nan"))


CARDS = el.Cards(["rectangle"], [np.transpose([[-2, 0, 0], [0, -2, 0], [1, 1, 1]])], [[1, 1, 1]])


@pytest.mark.parametrize(
    ("lights", "words"),
    [
        ([[0, 1, 0]], r"such as el.Lights\(direction, irradiance\); got"),
        (None, "such as el.Lights.* got None"),
        (CARDS, "give its `lights`; got an object of the type Cards"),
        (a_rig(), "give its `lights`; got an object of the type Rig"),
    ],
)
def test_lights_of_another_type_are_refused_with_a_way_out(lights, words):
    for make in (el.Rig, el.Rig.of):
        with pytest.raises(el.EnvLightsError, match=f"lights must be el.Lights, {words}"):
            make([0, 0, 0], lights)


def test_detected_lights_and_those_of_cards_make_a_rig_and_another_report_does_not():
    detected = el.detect(el.synthetic.hall(32).radiance)
    for lights in (detected, CARDS.lights):
        assert el.Rig([0, 0, 0], lights).lights is lights
    with pytest.raises(el.EnvLightsError, match=r"report must be the report of a rig.* got 3"):
        el.Rig([0, 0, 0], CARDS.lights, report=3)


def test_a_black_light_has_a_row():
    assert " 0.0 %" in str(el.Rig([1, 1, 1], el.Lights([[0, 1, 0]], [[0, 0, 0]]), 0))


def test_harmonics_are_saved_and_shown(tmp_path):
    rows = np.arange(27.0).reshape(9, 3) - 2
    rig = el.Rig(rows, a_rig().lights, 0.25)
    rig.save(tmp_path / "rig.json")
    np.testing.assert_array_equal(el.Rig.load(tmp_path / "rig.json").ambient, rows)
    assert "3zz-1" in str(rig)


@pytest.mark.parametrize(
    "ambient", [[0, 0], [[0, 0, 0]], np.zeros((4, 3)), [0, -1, 0], [0, 0, np.nan]]
)
def test_impossible_ambient_terms_are_refused(ambient):
    with pytest.raises(el.EnvLightsError, match="ambient must"):
        el.Rig(ambient, a_rig().lights, 0)


NORMALS, _ = el.kernels.icosphere(1280)


def test_a_floor_hides_the_lower_half_of_the_ambient_term():
    """The probe of a map that is black below the horizon, beside a light that is not hidden."""
    lights = el.Lights([[0.6, 0.8, 0]], [[3, 2, 1]], [0.2])
    rig = el.Rig([0.1, 0.2, 0.3], lights, 0.0, floor=True)
    for height in (128, 129):
        drawn = rig.to_map(height)
        np.testing.assert_allclose(drawn.probe(NORMALS), rig.probe(NORMALS), atol=1e-3)
    assert not drawn.radiance[65:].any()
    without = replace(rig, floor=False)
    np.testing.assert_allclose(without.probe([[0, 1, 0]]), rig.probe([[0, 1, 0]]), rtol=1e-12)
    np.testing.assert_allclose(rig.probe([[0, -1, 0]]), 0, atol=1e-12)


def test_harmonics_over_a_floor_are_refused():
    with pytest.raises(el.EnvLightsError, match="one radiance where there is a floor"):
        el.Rig(np.zeros((9, 3)), a_rig().lights, 0.0, floor=True)
    with pytest.raises(el.EnvLightsError, match=r"shape \(3,\) where there is a floor"):
        el.kernels.rig_irradiance(NORMALS, np.zeros((9, 3)), [], [], floor=True)


def test_the_old_name_of_the_errors_in_the_search_works_with_a_warning():
    report = el.rigs.FitReport({0: 0.5})
    with pytest.warns(DeprecationWarning, match=r"search_errors.*el\.error_curve"):
        assert report.errors == report.search_errors == {0: 0.5}
    assert "errors" not in report.to_dict()
    assert el.rigs.FitReport.from_dict(report.to_dict()) == report
