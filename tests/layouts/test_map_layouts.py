"""Arguments and defaults of maps in other layouts."""

import re

import numpy as np
import pytest

import envlights as el
from envlights.environment import resample
from envlights.environment.layouts import picture_layout as layouts


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"projection": "cube", "forward": (1, 0, 0)}, "forward is no argument of a cube map"),
        (
            {"projection": "cube", "mapping": "equisolid", "fov": 90},
            "mapping is no argument of a cube map",
        ),
        (
            {"projection": "equirectangular", "registration": "border-sampled"},
            "`EnvMap.to` makes; it takes no arguments",
        ),
        ({"projection": "fisheye", "mapping": "stereographic", "fov": 360}, "to 355; got 360"),
        ({"projection": "planar"}, "needs fov=, its horizontal field of view in degrees"),
    ],
)
def test_options_of_other_projections_are_refused(options, sentence):
    with pytest.raises(el.EnvLightsError, match=sentence):
        el.EnvMap(np.ones((16, 32, 3))).to(el.io.Layout(**options))


@pytest.mark.parametrize("direction", ["front", [0, 0, 0], [1, 2]])
def test_a_view_names_its_own_argument(direction):
    with pytest.raises(el.EnvLightsError, match=r"^direction must"):
        el.EnvMap(np.ones((16, 32, 3))).view(direction)


def test_a_photograph_of_a_camera_makes_no_giant_map():
    layout = layouts.planar(4000, 6000, field_of_view=np.deg2rad(65))
    assert resample.default_width(layout) == 8192


def test_a_missing_folder_is_named(tmp_path):
    picture = el.EnvMap(np.ones((16, 32, 3))).to("cube", width=8)
    with pytest.raises(el.EnvLightsError, match="there is no such folder; make it first"):
        picture.save(tmp_path / "faces")


@pytest.mark.parametrize("distance", [8, 20, 50])
def test_a_note_states_the_error_of_a_mirror_ball_nearby(distance):
    """The note against the reflection of rays of a camera at some radii."""
    (note,) = [
        each
        for each in el.EnvMap(np.ones((32, 32, 3)), layout="mirror-ball").notes
        if "far away" in each
    ]
    degrees = float(re.search(r"are (\d+) / n degrees off", note)[1]) / distance
    rays = np.linspace(0, np.arcsin(1 / distance), 10**5, endpoint=False)
    towards = 2 * np.arcsin(distance * np.sin(rays)) - rays
    assumed = 2 * np.arcsin(np.tan(rays) / np.tan(np.arcsin(1 / distance)))
    off = np.interp(np.pi / 2, towards, assumed - towards)
    np.testing.assert_allclose(degrees, np.rad2deg(off), rtol=0.05)
