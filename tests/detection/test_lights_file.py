"""Detected lights on disk."""

import copy
import json
import pickle

import numpy as np
import pytest

import envlights as el
from envlights.detection.members import Members

HALL = el.synthetic.hall(128).radiance
FOUND = {
    "tree": el.detect(HALL),
    "article": el.papers.loghin.detect(HALL),
    "clipped": el.detect((255 * np.clip(HALL / HALL.mean() / 4, 0, 1)).astype(np.uint8)),
    "none": el.detect(np.ones((32, 64, 3))),
}


@pytest.mark.parametrize("name", FOUND)
def test_all_but_the_times_comes_back(name, tmp_path):
    lights = FOUND[name]
    lights.save(tmp_path / "lights.json")
    again = el.detection.DetectedLights.load(tmp_path / "lights.json")
    assert len(again) == len(lights)
    assert again.to_dict() == lights.to_dict()
    for attribute in ("pixel", "light"):
        seen, wanted = (getattr(each.members, attribute) for each in (again, lights))
        np.testing.assert_array_equal(seen, wanted)
        assert seen.dtype == wanted.dtype
    for attribute in (
        "direction",
        "irradiance",
        "flux",
        "angular_radius",
        "is_clipped",
        "orientation",
    ):
        seen, wanted = getattr(again, attribute), getattr(lights, attribute)
        np.testing.assert_array_equal(seen, wanted)
        assert seen.dtype == wanted.dtype
    assert (again.weight is None) == (lights.weight is None) == (name != "clipped")
    assert str(again) == str(lights)


def test_the_file_says_what_it_is(tmp_path):
    FOUND["tree"].save(tmp_path / "lights.json")
    data = json.loads((tmp_path / "lights.json").read_text())
    assert (data["format"], data["version"]) == ("envlights detected lights", 3)
    assert "+y up" in data["frame"]
    assert "flux" in data["units"]


def test_runs_keep_members_in_any_order():
    rng = np.random.default_rng(4)
    pixel = np.stack([rng.integers(0, 3, 200), rng.integers(0, 4, 200)], axis=1)
    members = Members(pixel, rng.integers(0, 2, 200))
    again = Members.from_runs(members.to_runs(), 2, (3, 4))
    np.testing.assert_array_equal(again.pixel, members.pixel)
    np.testing.assert_array_equal(again.light, members.light)


def test_other_formats_hold_the_lights_as_discs(tmp_path):
    lights = FOUND["tree"]
    lights.save(tmp_path / "lights.csv")
    again = el.Lights.load(tmp_path / "lights.csv")
    np.testing.assert_array_equal(again.irradiance, lights.discs().irradiance)


def change_file(change):
    def write(path):
        data = FOUND["tree"].to_dict()
        change(data)
        path.write_text(json.dumps(data))

    return write


@pytest.mark.parametrize(
    ("write", "sentence"),
    [
        (lambda path: None, "cannot read"),
        (lambda path: path.write_text("{"), "is not a JSON file"),
        (lambda path: path.write_text("[]"), "is not a list of detected lights: it does not say"),
        (
            lambda path: el.Rig([0, 0, 0], FOUND["tree"].discs(), 0.0).save(path),
            "is not a list of detected lights: it does not say 'format': 'envlights detected",
        ),
        (change_file(lambda d: d.update(version=9)), "of version 9; this package reads 2, 3"),
        (change_file(lambda d: d.pop("elongation")), "the key 'elongation' is missing"),
        (
            change_file(lambda d: d["elongation"].pop()),
            "impossible detected lights: elongation must",
        ),
        (change_file(lambda d: d["members"].append([99, 0, 0, 1])), "members must lie in the"),
        (change_file(lambda d: d["members"].append([0, 0, 0, 10**8])), "members must lie in the"),
        (change_file(lambda d: d["members"].append([0, 0, 0, 2**40])), "members must be 536870912"),
        (change_file(lambda d: d["members"].append([0, 0])), "a value has another type or shape"),
        (change_file(lambda d: d["report"].update(notes=3)), "notes must be text; got 3"),
        (change_file(lambda d: d["report"].update(working_size=[4])), "another type or shape"),
        (
            change_file(lambda d: d.update(is_clipped=["no"] * len(d["is_clipped"]))),
            "is_clipped must be",
        ),
        (change_file(lambda d: d.update(direction="up")), "another type or shape"),
        (change_file(lambda d: d["irradiance"][0].__setitem__(0, -1)), "irradiance must be finite"),
        *(
            (change_file(lambda d, n=name, v=value: d[n].__setitem__(0, v)), f"{name} must be")
            for name, values in {
                "solid_angle": (np.nan, -1, 13),
                "elongation": (np.nan, -1),
                "peak_luminance": (np.inf, -1, 1e39),
                "flux_fraction": (-5, np.nan),
                "flux": ([np.nan, 0, 0], [0, -1, 0], [1e39, 0, 0]),
                "irradiance": ([1e39, 0, 0],),
                "peak_direction": ([9, 0, 0], [np.nan, 0, 0]),
                "orientation": ([0.5, 0, 0], [np.inf, 0, 0]),
            }.items()
            for value in values
        ),
    ],
)
def test_broken_and_foreign_files_are_refused_in_one_sentence(write, sentence, tmp_path):
    write(tmp_path / "lights.json")
    with pytest.raises(el.EnvLightsError, match=sentence) as refusal:
        el.detection.DetectedLights.load(tmp_path / "lights.json")
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(("name", "value"), [("weight", -1), ("direction_uncertainty", 4)])
def test_impossible_numbers_of_clipped_maps_are_refused(name, value, tmp_path):
    data = FOUND["clipped"].to_dict()
    data[name][0] = value
    (tmp_path / "lights.json").write_text(json.dumps(data))
    with pytest.raises(el.EnvLightsError, match=f"impossible detected lights: {name} must be"):
        el.detection.DetectedLights.load(tmp_path / "lights.json")


def test_a_pickle_leaves_the_pixels_out(tmp_path):
    lights = FOUND["tree"]
    assert len(lights.members.pixel) > 100
    assert len(pickle.dumps(lights)) < 5000
    again = pickle.loads(pickle.dumps(lights))
    assert again == lights
    assert repr(again.members) == "<LeftOut: left out>"
    with pytest.raises(el.EnvLightsError, match=r"were left out.*detect the lights again, or save"):
        again.members.pixel  # noqa: B018
    # All that needs no pixels goes on, also after a file and another pickle.
    assert again[:1] == lights[:1]
    turn = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]
    again.rotated(turn).save(tmp_path / "lights.json")
    loaded = el.detection.DetectedLights.load(tmp_path / "lights.json")
    assert pickle.loads(pickle.dumps(loaded)) == lights.rotated(turn)


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy])
def test_a_copy_keeps_the_pixels(copied):
    lights = el.split(HALL).lights
    again = copied(lights)
    assert again == lights
    assert again.members == lights.members


def test_files_of_older_versions_are_read(tmp_path):
    data = FOUND["tree"].to_dict() | {"version": 2}
    del data["is_cut"]
    (tmp_path / "lights.json").write_text(json.dumps(data))
    assert el.detection.DetectedLights.load(tmp_path / "lights.json") == FOUND["tree"]


def test_lights_alone_and_rigs_come_back_too(tmp_path):
    lights = FOUND["tree"].discs()
    rig = el.Rig([0.1, 0.2, 0.3], lights, 0.01, floor=True)
    for suffix in ("json", "csv"):
        expected = lights.to_dict()
        if suffix == "csv":
            del expected["origin"]  # a table has no place for it
        lights.save(tmp_path / f"lights.{suffix}")
        assert el.Lights.load(tmp_path / f"lights.{suffix}").to_dict() == expected
        rig.save(tmp_path / f"rig.{suffix}")
        again = el.Rig.load(tmp_path / f"rig.{suffix}")
        assert (again.error, again.floor, again.lights.to_dict()) == (0.01, True, expected)
    with pytest.raises(
        el.EnvLightsError, match=r"holds lights without an ambient term; use `Lights\.load`"
    ):
        el.Rig.load(tmp_path / "lights.csv")
    with pytest.raises(el.EnvLightsError, match="is not a list of lights"):
        el.Lights.load(tmp_path / "rig.json")
