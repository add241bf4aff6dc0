"""Files of photographs and of their lights."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import envlights as el
from envlights.cli import main
from envlights.environment.files.image_output import write_png

IMAGE = np.random.default_rng(3).random((90, 150, 3), dtype=np.float32) ** 12
FOUND = el.detect_photograph(IMAGE, 60)


def test_a_picture_of_a_view_states_its_field_of_view(tmp_path):
    view = el.EnvMap(np.ones((64, 128, 3))).view([1, 0.2, 0], fov=71.3, width=90)
    for suffix in (".exr", ".hdr", ".png", ".tif"):
        (path,) = view.save(tmp_path / f"a{suffix}")
        found = el.detect_photograph(path)
        assert found.field_of_view == pytest.approx(np.deg2rad(71.3), rel=1e-12)
        assert "71.3 degrees, from its layout attribute" in found.report.notes[-1]
        assert el.detect_photograph(path, 40).field_of_view == pytest.approx(np.deg2rad(40))
    (path,) = el.EnvMap(np.ones((64, 128, 3))).to("octahedral", width=20).save(path)
    with pytest.raises(el.EnvLightsError, match="of the projection octahedral, by its metadat"):
        el.detect_photograph(path)


@pytest.mark.parametrize("fov", [60, None])
def test_it_is_saved_and_loaded(fov, tmp_path):
    found = el.detect_photograph(IMAGE, fov)
    found.save(tmp_path / "a.json")
    again = el.papers.PhotographLights.load(tmp_path / "a.json")
    assert again == found
    assert (again.direction is None) == (fov is None)
    assert again.to_dict() == found.to_dict()
    assert str(again) == str(found)
    none = el.detect_photograph(np.ones((9, 9)), fov)
    none.save(tmp_path / "b.json")
    assert el.papers.PhotographLights.load(tmp_path / "b.json") == none


def test_a_table_has_lights_or_their_places(tmp_path):
    FOUND.save(tmp_path / "a.csv")
    assert el.Lights.load(tmp_path / "a.csv") == FOUND.discs()
    FOUND.save(tmp_path / "a.usda")
    without = el.detect_photograph(np.linspace(0, 1, 60 * 80).reshape(60, 80) ** 20)
    assert len(without) > 0
    without.save(tmp_path / "b.csv")
    with pytest.raises(el.EnvLightsError, match="accepts no environment map"):
        without.save(tmp_path / "c.csv", environment=np.ones((4, 8, 3)))
    with pytest.raises(el.EnvLightsError, match="up= changes nothing"):
        without.save(tmp_path / "c.csv", up="z")
    table = np.loadtxt(tmp_path / "b.csv", delimiter=",", skiprows=3, ndmin=2)
    np.testing.assert_array_equal(table[:, :2], without.position)
    np.testing.assert_array_equal(table[:, 2:5], without.pixel_flux)
    np.testing.assert_array_equal(table[:, 5], without.fraction)
    for call in (without.discs, lambda: without.save(tmp_path / "b.usda")):
        with pytest.raises(el.EnvLightsError, match=r"no directions.*give fov="):
            call()
    assert not (tmp_path / "b.usda").exists()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda data: data.pop("samples"), "the key 'samples' is missing"),
        (lambda data: data.update(format="envlights lights"), "it does not say 'format'"),
        (lambda data: data.update(version=9), "of version 9"),
        (lambda data: data["position"].pop(), "must have"),
        (lambda data: data["flux_fraction"].__setitem__(0, -1.0), "flux_fraction must have"),
        (lambda data: data["direction"].__setitem__(0, [0, 0, 2.0]), "impossible"),
        (lambda data: data["samples"]["light"].__setitem__(0, 10**6), "must be indices below"),
        (lambda data: data["samples"]["pixel"].pop(), "arrays of one length"),
        (lambda data: data.update(field_of_view=7.0), "field_of_view must be"),
        (lambda data: data.update(size=[1]), "another type or shape"),
    ],
)
def test_a_damaged_file_is_refused(change, words, tmp_path):
    data = FOUND.to_dict()
    change(data)
    (tmp_path / "a.json").write_text(json.dumps(data))
    with pytest.raises(el.EnvLightsError, match=words):
        el.papers.PhotographLights.load(tmp_path / "a.json")


def test_it_is_a_data_frame():
    pytest.importorskip("pandas")
    frame = FOUND.to_frame()
    assert len(frame) == len(FOUND)
    np.testing.assert_array_equal(frame[["x_px", "y_px"]], FOUND.position)
    np.testing.assert_array_equal(frame[["x", "y", "z"]], FOUND.direction)
    assert "z" not in el.detect_photograph(np.ones((9, 9))).to_frame()


def test_colour_and_part_are_those_of_a_map(tmp_path):
    image = np.full((60, 80, 3), 0.01, np.float32)
    image[18:24, 28:50] = 0.5
    write_png(tmp_path / "a.png", image)
    srgb = el.detect_photograph(tmp_path / "a.png")
    linear = el.detect_photograph(tmp_path / "a.png", colour="linear")
    assert linear.peak_luminance[0] == pytest.approx(0.7354, abs=0.001)
    assert srgb.peak_luminance[0] == pytest.approx(0.5, abs=0.001)
    with pytest.raises(el.EnvLightsError, match="part"):
        el.detect_photograph(tmp_path / "a.png", part="beauty")


def test_its_dictionary_is_json():
    data = json.loads(json.dumps(FOUND.to_dict()))
    assert len(data["position"]) == len(data["irradiance"]) == len(FOUND)
    assert data["frame"].startswith("of the photograph")
    assert (
        json.loads(json.dumps(el.detect_photograph(np.ones((9, 9))).to_dict()))["direction"] is None
    )


def test_the_command_writes_lights_and_reads_with_a_colour_space(tmp_path):
    image = np.full((60, 80, 3), 0.01, np.float32)
    image[18:24, 28:50] = 0.5
    write_png(tmp_path / "a.png", image)
    lights, table = str(tmp_path / "lights.json"), str(tmp_path / "lights.csv")
    options = ["--colour", "linear", "-o", lights, "-o", table]
    said = CliRunner().invoke(main, ["photograph", str(tmp_path / "a.png"), *options])
    assert said.exit_code == 0, said.output
    assert el.papers.PhotographLights.load(lights) == el.detect_photograph(
        tmp_path / "a.png", colour="linear"
    )
    assert "photograph" in (tmp_path / "lights.csv").read_text().splitlines()[0]
    refused = CliRunner().invoke(main, ["photograph", str(tmp_path / "a.png"), "-o", "a.usda"])
    assert refused.exit_code == 2
    assert "give --fov" in refused.output
