"""The package as a whole: the names and the imports of `import envlights`."""

import ast
import importlib.metadata
import re
import subprocess
import sys
from operator import attrgetter
from pathlib import Path

import numpy as np
import pytest

import envlights as el
from envlights.io import Layout
from tests import release_notes

FOLDER = Path(el.__file__).parent
MODULES = sorted(FOLDER.rglob("*.py"))
SUBPACKAGES = (
    "comparison",
    "export",
    "io",
    "kernels",
    "plot",
    "scene",
    "synthetic",
    "transfer",
)


def run(code):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)


@pytest.mark.parametrize("name", SUBPACKAGES)
def test_a_subpackage_is_reachable_and_completed(name):
    code = f"import envlights as el; assert {name!r} in dir(el); print(el.{name}.__name__)"
    assert run(code).stdout.strip() == f"envlights.{name}"


@pytest.mark.parametrize(
    "name", ["export", "frames", "io", "kernels", "plot", "scene", "synthetic", "transfer"]
)
def test_a_subpackage_lists_what_is_meant_to_be_used(name):
    module = getattr(el, name)
    assert dir(module) == sorted(module.__all__)
    assert all(hasattr(module, each) for each in module.__all__)


def test_public_names_are_completed():
    assert set(el.__all__) <= set(dir(el))
    assert {name for name in dir(el) if not hasattr(el, name)} == set()


def test_the_import_does_not_wait_for_what_is_used_later():
    slow = {"matplotlib", "click", "tqdm", "mitsuba", "dask", "OpenImageIO", "pandas"}
    slow |= {"envlights.export.scene", "envlights.transfer", "envlights.papers.madsen", "json"}
    assert run(f"import sys, envlights; print({slow} & set(sys.modules))").stdout.strip() == "set()"
    assert run("import envlights; print(envlights.__version__)").stdout.strip()


def test_a_first_fit_loads_no_module():
    """NumPy's median loads `numpy.ma`, which takes 11 ms."""
    image = "np.random.default_rng(0).random((64, 128, 3), dtype=np.float32)"
    work = f"image = {image}; before = set(sys.modules); el.fit(image, 2); el.detect(image)"
    code = f"import sys, numpy as np, envlights as el; {work}; print({{*sys.modules}} - before)"
    assert run(code).stdout.strip() == "set()"


def test_other_names_are_missing_as_in_any_module():
    with pytest.raises(AttributeError, match="'envlights' has no attribute 'lamp'"):
        _ = el.lamp


def is_module(name):
    return name == "_native" or (FOLDER / name).is_dir() or (FOLDER / f"{name}.py").is_file()


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(FOLDER)))
def test_a_module_imports_the_modules_that_it_uses_and_not_the_root(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            assert "envlights" not in [name.name for name in node.names]
        if isinstance(node, ast.ImportFrom) and node.module == "envlights":
            assert all(is_module(name.name) for name in node.names)


def test_the_constraints_of_the_lowest_versions_are_those_of_the_package():
    """`tests/installed.sh . --constraint tests/lowest.txt` tests the declared versions."""
    declared = {}
    for requirement in importlib.metadata.requires("envlights"):
        named, _, condition = requirement.partition(";")
        if condition.strip() in ("", 'extra == "plot"', "extra == 'plot'"):
            name, least = named.split(">=")
            declared[name.strip()] = least.strip()
    lines = Path(__file__).with_name("lowest.txt").read_text().splitlines()
    lowest = dict(line.split("==") for line in lines if line and not line.startswith("#"))
    assert lowest.keys() >= declared.keys()
    for name, least in declared.items():
        assert lowest[name].startswith(least)


def test_the_release_notes_are_the_newest_entry_of_the_changelog():
    entries = ("# Log", "## 0.3.0 (unreleased)", "- c", "## 0.2.0 - 2026-03-04", "- b")
    assert release_notes.newest("\n\n".join(entries)) == ("0.2.0", "- b")


@pytest.mark.parametrize(
    "name", [name for names in el._FORMER.values() for name in names.split()] + [*el._RENAMED]
)
def test_a_former_name_works_and_warns_with_the_present_one(name):
    with pytest.warns(DeprecationWarning, match=rf"el\.{name} is called el\.\S+ now") as warned:
        value = getattr(el, name)
    assert warned[0].filename == __file__
    path = str(warned[0].message).split()[-2].removeprefix("el.")
    assert value is attrgetter(path)(el)


def test_former_arguments_and_attributes_work_and_warn():
    radiance = np.full((8, 16, 3), 0.5)
    with pytest.warns(DeprecationWarning, match="white= of EnvMap.* is called clip_level= now"):
        env = el.EnvMap(radiance, white=2.0)
    with pytest.warns(DeprecationWarning, match=r"EnvMap\.white is called `clip_level` now"):
        assert env.white == 2.0
    with pytest.raises(TypeError, match="both white= and clip_level="):
        el.EnvMap(radiance, white=2.0, clip_level=2.0)
    with pytest.warns(DeprecationWarning, match="blur_px= of detect is called `blur_px` of its"):
        el.papers.loghin.detect(radiance, blur_px=0.0)


#: Former arguments of `EnvMap` and `EnvMap.open`, for a picture that takes them, and their layout.
FORMER_ARGUMENTS = [
    ((64, 64), {"projection": "octahedral"}, Layout.octahedral()),
    ((96, 16), {"faces": "opengl"}, Layout(faces="opengl")),
    ((32, 64), {"registration": "border-sampled"}, Layout(registration="border-sampled")),
    ((64, 64), {"mapping": "equisolid", "fov": 180}, Layout(mapping="equisolid", fov=180)),
    ((20, 30), {"projection": "planar", "fov": 65}, Layout.planar(fov=65)),
    (
        (20, 30),
        {"projection": "cylinder", "fov": 90, "horizon": 3},
        Layout.cylinder(fov=90, horizon=3),
    ),
    (
        (20, 30),
        {"projection": "mirror-ball", "circle": (15, 10, 9)},
        Layout.mirror_ball(circle=(15, 10, 9)),
    ),
    (
        (64, 64),
        {"projection": "angular", "forward": [1, 0, 0]},
        Layout.angular(forward=[1, 0, 0]),
    ),
    ((64, 64), {"eye": "right"}, Layout(eye="right")),
]


@pytest.mark.parametrize(("size", "arguments", "layout"), FORMER_ARGUMENTS, ids=str)
def test_former_arguments_of_a_layout_work_and_warn(tmp_path, size, arguments, layout):
    picture = np.random.default_rng(0).uniform(0.1, 0.9, (*size, 3)).astype(np.float32)
    el.io.write_exr(tmp_path / "a.exr", picture)
    form = re.escape(f"layout={layout!r}")
    for make, what in ((el.EnvMap, picture), (el.EnvMap.open, tmp_path / "a.exr")):
        with pytest.warns(DeprecationWarning, match=rf"{next(iter(arguments))}=.*{form}") as warned:
            env = make(what, **arguments)
        assert warned[0].filename == __file__
        assert env == make(what, layout=layout)
        assert env.source == make(what, layout=layout).source


def test_the_older_name_of_a_direction_works_and_warns():
    picture = np.ones((16, 16, 3))
    with pytest.warns(DeprecationWarning, match="EnvMap") as warned:
        env = el.EnvMap(picture, projection="angular", towards=[1, 0, 0])
    assert "towards= of EnvMap.__init__ is called forward= now" in str(warned[0].message)
    assert env == el.EnvMap(picture, layout=Layout.angular(forward=[1, 0, 0]))


#: Former arguments of `EnvMap.to`, and their layout.
FORMER_TARGETS = [
    ({"projection": "cube"}, "cube"),
    ({"projection": "source"}, "source"),
    ({"projection": "cube", "faces": "openexr"}, Layout.cube(faces="openexr")),
    ({"projection": "octahedral", "faces": "openexr"}, "octahedral"),
    (
        {"projection": "cube", "registration": "border-sampled"},
        Layout.cube(registration="border-sampled"),
    ),
    ({"projection": "fisheye", "mapping": "equisolid"}, Layout.fisheye(mapping="equisolid")),
    ({"projection": "cylinder", "fov": 90}, Layout.cylinder(fov=90)),
    ({"projection": "angular", "forward": [1, 0, 0]}, Layout.angular(forward=[1, 0, 0])),
]


@pytest.mark.parametrize(("arguments", "layout"), FORMER_TARGETS, ids=str)
def test_former_arguments_of_a_target_work_and_warn(arguments, layout):
    env = el.EnvMap(np.random.default_rng(0).uniform(size=(16, 32, 3)))
    wanted = env.to(layout)
    projection, *others = arguments
    calls = [lambda: env.to(**arguments)]
    if others:
        rest = {name: arguments[name] for name in others}
        calls.append(lambda: env.to(arguments[projection], **rest))
    for call in calls:
        with pytest.warns(DeprecationWarning, match=re.escape(f"layout={layout!r}")) as warned:
            picture = call()
        assert warned[0].filename == __file__
        assert picture.layout == wanted.layout
        assert np.array_equal(picture.array, wanted.array)
