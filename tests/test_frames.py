"""Results as data frames."""

import sys

import numpy as np
import pytest

import envlights as el
from envlights.kernels.image import LUMINANCE

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
    assert np.isnan(el.rigs.FitReport().to_frame()["shadow_error"][0])


def test_rigs_are_a_row_each_with_their_names(rigs):
    frame = el.rigs.rigs_to_frame(rigs)
    assert list(frame.index) == ["two", "harmonics"]
    assert list(frame["lights"]) == [2, 1]
    assert list(frame["error"]) == [rig.error for rig in rigs.values()]
    assert list(el.rigs.rigs_to_frame(iter(rigs.values())).index) == [0, 1]
    assert len(el.rigs.rigs_to_frame([])) == 0


def test_the_luminance_of_harmonics_is_the_mean_of_their_sky():
    pytest.importorskip("pandas")
    sky = np.zeros((9, 3))
    sky[0], sky[3] = (1.0, 0.8, 0.6), (0.2, 0.1, 0.3)
    rig = el.Rig(sky, el.Lights(np.zeros((0, 3)), np.zeros((0, 3))), 0.0)
    drawn = rig.to_map(64).harmonics(0)[0] @ LUMINANCE / np.sqrt(4 * np.pi)
    assert el.rigs.rigs_to_frame([rig])["ambient_luminance"][0] == pytest.approx(drawn, rel=1e-6)


def test_a_frame_of_something_else_is_refused():
    with pytest.raises(el.EnvLightsError, match="rigs must hold rigs of `fit`; got 3"):
        el.rigs.rigs_to_frame([3])
    for bad in (None, "rig.json", 3):
        with pytest.raises(el.EnvLightsError, match="rigs must be a sequence or a mapping"):
            el.rigs.rigs_to_frame(bad)


def test_without_pandas_the_refusal_names_the_extra_and_to_dict(rigs, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    for call in (rigs["two"].to_frame, rigs["two"].report.to_frame):
        with pytest.raises(el.EnvLightsError, match=r"envlights\[frame\].*`to_dict`"):
            call()
