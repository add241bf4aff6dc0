"""Marks and settings that several tests need."""

import importlib.util
import os

# Before NumPy is imported: threads of BLAS fight over the small matrices of the peers.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import hypothesis
import pytest

from tests.helpers import paths_of_real_maps

hypothesis.settings.register_profile("project", deadline=None, derandomize=True)
hypothesis.settings.load_profile("project")


#: Tests that fill a disk: they limit the size of files.
fills_a_disk = pytest.mark.skipif(
    importlib.util.find_spec("resource") is None,
    reason="sizes of files cannot be limited here",
)


def real_maps(*patterns):
    """Parametrise over the real maps that match, where `ENVLIGHTS_MAPS` names their folder."""
    if not os.environ.get("ENVLIGHTS_MAPS"):
        reason = "set ENVLIGHTS_MAPS to a folder of maps to try them as well"
        return pytest.mark.parametrize("path", [pytest.param(None, marks=pytest.mark.skip(reason))])
    found = paths_of_real_maps(*patterns)
    assert found, f"the folder ENVLIGHTS_MAPS holds nothing that matches {patterns}"
    return pytest.mark.parametrize("path", [pytest.param(path, id=path.name) for path in found])
