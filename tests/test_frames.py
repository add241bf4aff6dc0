"""Results as data frames."""

import sys

import numpy as np
import pytest

import envlights as el

HALL = el.synthetic.hall(64).radiance


@pytest.fixture(scope="module")
def rigs():
    pytest.importorskip("pandas")
    return {"two": el.fit(HALL, 2), "harmonics": el.fit(HALL, 1, ambient="sh2")}


def test_a_rig_is_the_frame_of_its_lights_with_the_rest_in_attrs(rigs):
    frame = rigs["two"].to_frame()
    assert frame.equals(rigs["two"].lights.to_frame())
    assert frame.attrs["error"] == rigs["two"].error
    assert frame.attrs["ambient"] == rigs["two"].ambient.tolist()


def test_a_report_is_one_row(rigs):
    frame = rigs["two"].report.to_frame()
    assert frame.shape[0] == 1
    assert frame["shadow_error"][0] == rigs["two"].report.shadow_error
    assert np.isnan(el.FitReport().to_frame()["shadow_error"][0])


def test_rigs_are_a_row_each_with_their_names(rigs):
    frame = el.rigs_to_frame(rigs)
    assert list(frame.index) == ["two", "harmonics"]
    assert list(frame["lights"]) == [2, 1]
    assert list(frame["error"]) == [rig.error for rig in rigs.values()]
    # The mean radiance of harmonics is that of a drawn sky.
    sky = el.Rig(rigs["harmonics"].ambient, el.Lights(np.zeros((0, 3)), np.zeros((0, 3))), 0.0)
    drawn = sky.to_map(64).harmonics(0)[0] @ kernels_luminance() / np.sqrt(4 * np.pi)
    assert frame["ambient_luminance"]["harmonics"] == pytest.approx(drawn, rel=1e-3)
    assert list(el.rigs_to_frame(iter(rigs.values())).index) == [0, 1]
    assert len(el.rigs_to_frame([])) == 0


def kernels_luminance():
    from envlights.kernels.image import LUMINANCE

    return LUMINANCE


def test_a_frame_of_something_else_is_refused():
    with pytest.raises(el.EnvLightsError, match="rigs must hold rigs of `fit`; got 3"):
        el.rigs_to_frame([3])


def test_without_pandas_the_refusal_names_the_extra_and_to_dict(rigs, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    for call in (rigs["two"].to_frame, rigs["two"].report.to_frame):
        with pytest.raises(el.EnvLightsError, match=r"envlights\[frame\].*`to_dict`"):
            call()
