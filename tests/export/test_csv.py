"""The table of numbers."""

import numpy as np
import pytest

import envlights as el
from tests.helpers import NORMALS

LIGHTS = el.Lights([[0, 1, 0], [0.6, 0, 0.8]], [[1, 2, 1 / 3], [5e-9, 1e30, 0]], [0.1, 0.0])
RIGS = [
    el.Rig([0.1, 0.2, 1 / 3], LIGHTS, error=1 / 7),
    el.Rig([0.1, 0.2, 0.3], LIGHTS[:0], error=0.0, floor=True),
    el.Rig(np.linspace(-1, 1, 27).reshape(9, 3), LIGHTS, error=0.5),
]


def irradiance_of_file(path):
    """Irradiance at `NORMALS` of the numbers in a table."""
    table = el.export.read_csv(path)
    lights = el.Lights(table.direction, table.irradiance, table.angular_radius)
    return el.Rig(table.ambient, lights, table.error, floor=table.floor).probe(NORMALS)


@pytest.mark.parametrize("rig", RIGS, ids=["constant", "floor", "harmonics"])
def test_a_table_holds_all_of_a_rig_but_its_report(rig, tmp_path):
    rig.save(tmp_path / "rig.csv")
    table = el.export.read_csv(tmp_path / "rig.csv")
    np.testing.assert_array_equal(table.ambient, rig.ambient)
    for name in ("direction", "irradiance", "angular_radius"):
        np.testing.assert_array_equal(getattr(table, name), getattr(rig.lights, name))
    assert (table.error, table.floor) == (rig.error, rig.floor)


def test_a_table_of_lights_alone(tmp_path):
    LIGHTS.save(tmp_path / "lights.csv")
    table = el.export.read_csv(tmp_path / "lights.csv")
    np.testing.assert_array_equal(table.irradiance, LIGHTS.irradiance)
    assert (table.ambient, table.error) == (None, None)


def test_numpy_reads_it_too(tmp_path):
    LIGHTS.save(tmp_path / "lights.csv")
    table = tmp_path / "lights.csv"
    rows = np.genfromtxt(
        table, delimiter=",", names=True, dtype=None, skip_header=2, encoding="utf-8"
    )
    np.testing.assert_array_equal(rows["green"], LIGHTS.irradiance[:, 1])


WHOLE = el.export.csv(RIGS[0])


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("", "its first line is not"),
        ("a,b\n1,2\n", "its first line is not"),
        (WHOLE[:-9], "has 7 cells|could not convert"),
        (WHOLE.replace("kind", "what"), "the header must be"),
        (WHOLE.replace("1e+30", "many"), "could not convert string to float: 'many'"),
        (WHOLE.replace("ambient,", "sky,"), "must be lights, then one row of ambient"),
        (WHOLE.replace("# relative", "# absolute"), "ambient and error go together"),
        ("\x00\xff", "its first line is not"),
    ],
)
def test_a_damaged_table_is_refused_in_one_sentence(content, sentence, tmp_path):
    (tmp_path / "rig.csv").write_text(content, encoding="utf-8")
    with pytest.raises(el.EnvLightsError, match=sentence):
        el.export.read_csv(tmp_path / "rig.csv")


@pytest.mark.parametrize("path", ["a\0b", "\ud800"])
@pytest.mark.parametrize("use", [el.export.read_csv, el.Rig.load, el.detection.DetectedLights.load])
def test_what_can_be_no_name_is_refused(use, path):
    with pytest.raises(el.EnvLightsError, match="must be text that can name a file"):
        use(path)


def test_what_is_no_text_is_refused(tmp_path):
    (tmp_path / "rig.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(el.EnvLightsError, match="it is not text"):
        el.export.read_csv(tmp_path / "rig.csv")
