"""What several tests need."""

import os
from pathlib import Path

import hypothesis
import pytest

hypothesis.settings.register_profile("project", deadline=None, derandomize=True)
hypothesis.settings.load_profile("project")

_FOLDER = os.environ.get("ENVLIGHTS_MAPS")


def real_maps(*patterns):
    """Parametrise over the real maps that match, where `ENVLIGHTS_MAPS` names their folder."""
    found = sorted(path for pattern in patterns for path in Path(_FOLDER or "").glob(pattern))
    if not _FOLDER:
        reason = "set ENVLIGHTS_MAPS to a folder of maps to try them as well"
        return pytest.mark.parametrize("path", [pytest.param(None, marks=pytest.mark.skip(reason))])
    assert found, f"ENVLIGHTS_MAPS={_FOLDER} holds nothing that matches {patterns}"
    return pytest.mark.parametrize("path", [pytest.param(path, id=path.name) for path in found])


EQUIRECTANGULAR = ("hdr/*.hdr", "exr/*.exr", "openexr_envmaps/*LatLong.exr", "ldr/*.png")
