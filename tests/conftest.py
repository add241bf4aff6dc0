"""Marks and settings that several tests need."""

import importlib.util
import os
from pathlib import Path

# Before NumPy is imported: threads of BLAS fight over the small matrices of the peers.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import hypothesis
import pytest
from _pytest.doctest import DoctestModule

from tests.helpers import paths_of_real_maps

TESTS = Path(__file__).parent

hypothesis.settings.register_profile("project", deadline=None, derandomize=True)
hypothesis.settings.load_profile("project")


#: Tests that fill a disk: they limit the size of files.
fills_a_disk = pytest.mark.skipif(
    importlib.util.find_spec("resource") is None,
    reason="sizes of files cannot be limited here",
)


#: Real maps of the quick part: a sun, a night, a studio, half floats, and a map that is clipped.
QUICK_MAPS = {
    "venice_sunset_1k.hdr",
    "dikhololo_night_1k.hdr",
    "studio_small_03_1k.hdr",
    "pmndrs_park_512.exr",
    "env_color_room.png",
}


def real_maps(*patterns, all_quick=False):
    """Parametrise over the real maps that match, where `ENVLIGHTS_MAPS` names their folder.

    Maps outside `QUICK_MAPS` are marked as slow, unless the test is quick with every map.
    """
    if not os.environ.get("ENVLIGHTS_MAPS"):
        reason = "set ENVLIGHTS_MAPS to a folder of maps to try them as well"
        return pytest.mark.parametrize("path", [pytest.param(None, marks=pytest.mark.skip(reason))])
    found = paths_of_real_maps(*patterns)
    assert found, f"the folder ENVLIGHTS_MAPS holds nothing that matches {patterns}"
    slow = [path for path in found if not (all_quick or path.name in QUICK_MAPS)]
    params = [
        pytest.param(path, id=path.name, marks=[pytest.mark.slow] if path in slow else [])
        for path in found
    ]
    return pytest.mark.parametrize("path", params)


#: Files whose tests and doctests render with Mitsuba in the process of the tests.
RENDERING_FILES = (
    "test_mitsuba.py",
    "test_bake.py",
    "plot/test_scene.py",
    "test_benchmarks.py",
    "test_blender.py",
    "scene/bake.py",
)


#: Files whose tests take longest, the longest first: a worker that got one last would end last.
LONG_FILES = (
    "fitting/test_fit_peers.py",
    "export/test_hostile_text.py",
    "test_notebooks.py",
    "export/test_names.py",
    "export/test_radiance.py",
    "fitting/test_fit.py",
    "plot/test_arguments.py",
    "fitting/test_fit_sizes.py",
    "test_docs.py",
    "sun/test_find_sun.py",
    "test_saves.py",
    "fitting/test_reported_error.py",
    "cli/test_transfer.py",
    "detection/test_loghin.py",
    "detection/test_component_tree.py",
    "test_calls.py",
    "placing/test_place.py",
    "batches/test_kills.py",
    "test_interrupt.py",
    "test_fuzz.py",
    "test_memory.py",
)


def pytest_collection_modifyitems(items):
    """Mark what renders, and start with the files that take longest.

    Mitsuba once waited for ever in a worker of pytest-xdist.
    """
    for item in items:
        if item.path.as_posix().endswith(RENDERING_FILES):
            item.add_marker(pytest.mark.mitsuba)
    missing = [name for name in LONG_FILES if not (TESTS / name).exists()]
    assert not missing, f"LONG_FILES of conftest.py names files that do not exist: {missing}"
    place = {str(TESTS / name): number for number, name in enumerate(LONG_FILES)}
    items.sort(key=lambda item: place.get(str(item.path), len(place)))


@pytest.hookimpl(wrapper=True)
def pytest_collect_file():
    """Look for no doctests in files of tests."""
    collectors = yield
    return [each for each in collectors if not isinstance(each, DoctestModule)]


def pytest_ignore_collect(collection_path):
    """Look for doctests in the package alone: what helps tests is imported by the tests."""
    is_helper = collection_path.suffix == ".py" and not collection_path.name.startswith("test_")
    return True if is_helper and collection_path.is_relative_to(TESTS) else None
