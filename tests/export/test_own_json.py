"""Our own file of a rig: JSON."""

import json

import numpy as np

import envlights as el
from tests.export.rigs import DISCS, rigs
from tests.helpers import NORMALS


def irradiance_of_file(path):
    """Irradiance at `NORMALS` of the numbers in a file."""
    data = json.loads(path.read_text())
    lights = data["lights"]
    points = el.Lights(lights["direction"], lights["irradiance"], lights["angular_radius"])
    return el.Rig(data["ambient"], points, 0.0, floor=data["floor"]).probe(NORMALS)


def test_the_numbers_of_a_file_are_those_of_the_rig(tmp_path):
    for rig in rigs(DISCS).values():
        rig.save(tmp_path / "rig.json")
        np.testing.assert_array_equal(irradiance_of_file(tmp_path / "rig.json"), rig.probe(NORMALS))
