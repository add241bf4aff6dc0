"""Detected lights on disk."""

import json

import numpy as np
import pytest

import envlights as el
from envlights.detection.members import Members

HALL = el.synthetic.hall(128).radiance
FOUND = {
    "tree": el.detect(HALL),
    "article": el.detect(HALL, method="article"),
    "clipped": el.detect((255 * np.clip(HALL / HALL.mean() / 4, 0, 1)).astype(np.uint8)),
    "none": el.detect(np.ones((32, 64, 3))),
}


@pytest.mark.parametrize("name", FOUND)
def test_all_but_the_times_comes_back(name, tmp_path):
    lights = FOUND[name]
    lights.save(tmp_path / "lights.json")
    again = el.DetectedLights.load(tmp_path / "lights.json")
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
        (change_file(lambda d: d.update(version=9)), "of version 9; this package reads 2"),
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
    ],
)
def test_broken_and_foreign_files_are_refused_in_one_sentence(write, sentence, tmp_path):
    write(tmp_path / "lights.json")
    with pytest.raises(el.EnvLightsError, match=sentence) as refusal:
        el.DetectedLights.load(tmp_path / "lights.json")
    assert "\n" not in str(refusal.value)


def test_lights_alone_and_rigs_come_back_too(tmp_path):
    lights = FOUND["tree"].discs()
    rig = el.Rig([0.1, 0.2, 0.3], lights, 0.01, floor=True)
    for suffix in ("json", "csv"):
        lights.save(tmp_path / f"lights.{suffix}")
        assert el.Lights.load(tmp_path / f"lights.{suffix}").to_dict() == lights.to_dict()
        rig.save(tmp_path / f"rig.{suffix}")
        again = el.Rig.load(tmp_path / f"rig.{suffix}")
        assert (again.error, again.floor, again.lights.to_dict()) == (0.01, True, lights.to_dict())
    with pytest.raises(
        el.EnvLightsError, match=r"holds lights without an ambient term; use `Lights\.load`"
    ):
        el.Rig.load(tmp_path / "lights.csv")
    with pytest.raises(el.EnvLightsError, match="is not a list of lights"):
        el.Lights.load(tmp_path / "rig.json")
