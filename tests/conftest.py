"""What several tests need."""

import os
from pathlib import Path

# Before NumPy is imported: threads of BLAS fight over the small matrices of the peers.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import hypothesis
import pytest

hypothesis.settings.register_profile("project", deadline=None, derandomize=True)
hypothesis.settings.load_profile("project")

_FOLDER = os.environ.get("ENVLIGHTS_MAPS")


def paths_of_real_maps(*patterns):
    """Those that match in the folder that `ENVLIGHTS_MAPS` names; none without it."""
    if not _FOLDER:
        return []
    return sorted(path for pattern in patterns for path in Path(_FOLDER).glob(pattern))


def real_maps(*patterns):
    """Parametrise over the real maps that match, where `ENVLIGHTS_MAPS` names their folder."""
    found = paths_of_real_maps(*patterns)
    if not _FOLDER:
        reason = "set ENVLIGHTS_MAPS to a folder of maps to try them as well"
        return pytest.mark.parametrize("path", [pytest.param(None, marks=pytest.mark.skip(reason))])
    assert found, f"ENVLIGHTS_MAPS={_FOLDER} holds nothing that matches {patterns}"
    return pytest.mark.parametrize("path", [pytest.param(path, id=path.name) for path in found])


EQUIRECTANGULAR = ("hdr/*.hdr", "exr/*.exr", "openexr_envmaps/*LatLong.exr", "ldr/*.png")
