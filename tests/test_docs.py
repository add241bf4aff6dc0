"""Pages of the documentation: their code runs, their links hold, and no public name is missing."""

import inspect
import re
import runpy
import sys
from functools import cache
from pathlib import Path
from types import ModuleType

import pytest
from matplotlib.figure import Figure

import envlights as el
from envlights.cli.demonstration import demo_transfer

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
PROGRAMS = sorted(DOCS.glob("programs/*.md"))
GUIDE = [path for path in sorted(DOCS.glob("*.md")) if path.stem != "index"]
PAGES = sorted([*DOCS.glob("*.md"), *DOCS.glob("*/*.md")])
#: Languages of code that is not run.
OTHER_CODE = {"sh", "text"}
#: Packages that the code of a page needs.
NEEDS = {"view.md": ("trimesh", "anywidget"), "training.md": ("jax", "array_api_compat")}
#: The tests of tests/fitting run this page, because its blocks are alternatives.
ELSEWHERE = {"method.md"}

sys.path.insert(0, str(DOCS / "extensions"))
import guide_links  # noqa: E402
import reference_pages  # noqa: E402

sys.path.remove(str(DOCS / "extensions"))


def text_of(path):
    return path.read_text(encoding="utf-8")


def code_of(path):
    return re.findall(r"^```python\n(.*?)^```", text_of(path), re.M | re.S)


def name_of(path):
    return path.relative_to(DOCS).as_posix()


WITH_CODE = [path for path in PAGES if code_of(path) and path.name not in ELSEWHERE]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a map and a model, in which the code of a page runs."""
    monkeypatch.chdir(tmp_path)
    el.EnvMap(el.synthetic.hall(32).radiance).save("hall.exr")
    Path("chair.obj").write_text(
        "v 0 0 0\nv 90 0 0\nv 0 90 0\nv 0 0 90\nf 1 3 2\nf 1 2 4\nf 1 4 3\n"
    )
    return tmp_path


@pytest.mark.parametrize("page", WITH_CODE, ids=name_of)
def test_a_page_runs_as_pasted(page, folder):
    """Every block of Python runs, from the top down."""
    for package in NEEDS.get(page.name, ()):
        pytest.importorskip(package)
    if "room_direct.exr" in text_of(page):
        demo_transfer(folder)
    names = {}
    for block in code_of(page):
        exec(compile(block, page.name, "exec"), names)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_each_block_of_code_names_its_language(page):
    openings = re.findall(r"^```(.*)$", text_of(page), re.M)[::2]
    languages = {each for each in openings if not each.startswith("{")}
    assert languages <= {"python", *OTHER_CODE}


@pytest.mark.parametrize("path", sorted(DOCS.glob("examples/*.py")), ids=lambda path: path.stem)
def test_an_example_draws_one_figure_in_about_twenty_lines(path, folder):
    figure = runpy.run_path(str(path))["figure"]
    assert isinstance(figure, Figure)
    assert figure.axes
    code = text_of(path).split('"""')[2]
    assert len([line for line in code.splitlines() if line.strip()]) <= 22


def links_of(path):
    prose = re.sub(r"^```.*?^```|`[^`\n]*`", "", text_of(path), flags=re.M | re.S)
    targets = re.findall(r"\]\(([^)\s]+)\)", prose)
    return [each for each in targets if not re.match(r"https?:|#", each)]


@pytest.mark.parametrize(
    "page", [*PAGES, *ROOT.glob("*.md")], ids=lambda path: path.relative_to(ROOT).as_posix()
)
def test_relative_links_name_files(page):
    for link in links_of(page):
        assert (page.parent / link.partition("#")[0]).exists(), link


def test_the_guide_is_short():
    """Fourteen pages with that of the programs, and at most 14 000 words."""
    assert len(GUIDE) + 1 <= 14
    pages = [*GUIDE, *PROGRAMS]
    prose = [re.sub(r"^```.*?^```", "", text_of(path), flags=re.M | re.S) for path in pages]
    words = [word for word in " ".join(prose).split() if re.search(r"\w", word)]
    assert len(words) <= 14_000


def test_every_program_has_a_page_with_its_table():
    shown = {target.name for target in el.export.TARGETS} - {"json", "csv"}
    pages = {path.stem for path in PROGRAMS} - {"index", "engines", "simulators"}
    assert pages == shown
    for page in pages:
        assert f"{{program-facts}} {page}\n" in text_of(DOCS / "programs" / f"{page}.md")


@cache
def reference():
    """Text of each page of the reference."""
    return reference_pages.texts()


PUBLIC = [("", name) for name in el.__all__] + [
    (package, name) for package in reference_pages.PACKAGES for name in getattr(el, package).__all__
]


@pytest.mark.parametrize(("package", "name"), PUBLIC, ids=lambda each: each or "el")
def test_every_public_name_is_in_the_reference(package, name):
    owner = getattr(el, package) if package else el
    value, full = getattr(owner, name), f"{owner.__name__}.{name}"
    if isinstance(value, ModuleType):
        entry = rf"^.. (auto)?module:: {full}$"
    elif package and name in el.__all__ and value is getattr(el, name):
        entry = rf"`envlights\.{name}`"
    else:
        entry = rf"^   ~{full}$|^.. py:data:: {full}$"
    assert re.search(entry, "\n".join(reference().values()), re.M)


def test_parameters_that_decide_something_link_to_the_guide():
    """Every parameter of the table belongs to a public function, and its page exists."""
    lines = ["    **target** : str, optional", "        Names of targets.", "    **other** : int"]
    assert guide_links.with_links(lines) == [
        f"{lines[0]} (:doc:`guide </docs/programs/index>`)",
        *lines[1:],
    ]
    assert all((DOCS / f"{page}.md").exists() for page in guide_links.PAGES)
    functions = [el.EnvMap.open, el.EnvMap.calibrated, el.EnvMap.repaired, el.EnvMap.rotated]
    functions += [el.TransferModel.fit, el.follow, el.fit, el.split, el.batch, el.view, el.vary]
    functions += [el.compare, el.place, el.scene.ShadowOverlay.save, el.export.save_usd]
    known = {name for each in functions for name in inspect.signature(each).parameters}
    assert set(guide_links.PAGE_OF) <= known


def test_the_help_of_every_command_is_in_the_reference():
    page = reference()["commands"]
    for command in ("fit", "detect", "export", "transfer fit", "view"):
        assert re.search(rf"^   Usage: envlights {command} ", page, re.M), command


def test_every_public_package_has_a_page():
    """Packages with `__all__` that `import envlights` gives."""
    modules = {
        name: getattr(el, name) for name in dir(el) if isinstance(getattr(el, name), ModuleType)
    }
    listed = {name for name, module in modules.items() if hasattr(module, "__all__")}
    assert listed <= {*reference_pages.PACKAGES}


def test_the_readme_is_one_screen_with_its_two_commands():
    lines = text_of(ROOT / "README.md").splitlines()
    assert len(lines) <= 60
    for mark in ("<!-- first-run -->", "<!-- tests -->"):
        assert lines[lines.index(mark) + 1] == "```sh"


def test_docs_need_no_network():
    """Settings and style sheets name no address."""
    for path in [DOCS / "conf.py", *DOCS.glob("static/*")]:
        assert not re.search(r"https?://", text_of(path)), path
