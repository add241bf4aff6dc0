"""Pages of the reference, written from the names that the package makes public."""

import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import click

import envlights as el
from envlights.cli import main


class Page(NamedTuple):
    """One page: a title, a sentence, and the modules whose names of `envlights` it holds."""

    file: str
    title: str
    text: str
    modules: tuple[str, ...] = ()


#: Names of `envlights` by the module that defines them; the last page takes what is left.
PAGES = (
    Page(
        "maps",
        "Maps",
        "Open, calibrate and convert environment maps.",
        ("environment", "_common.errors"),
    ),
    Page(
        "fit",
        "Fit",
        "Fit lights to a map, and read what the fit says about its errors.",
        ("fitting", "rigs"),
    ),
    Page(
        "detect",
        "Detect and split",
        "Find lights, and take them out of a map.",
        ("detection", "splitting", "papers", "cards"),
    ),
    Page("place", "Lights in metres", "Give lights a position in a room.", ("placing",)),
    Page("sequence", "Sequences", "Fit rigs to a sequence of maps.", ("sequence",)),
    Page("sun", "Sun", "Find the sun of an 8-bit panorama.", ("sun",)),
    Page(
        "scene",
        "Objects in a map",
        "Show, shade and bake things that stand in a map.",
        ("viewer", "scene"),
    ),
    Page("compare", "Compare", "Compare maps, rigs and images.", ("comparison",)),
    Page("transfer", "Transfer", "Predict indirect light from direct light.", ("transfer",)),
    Page("other", "Other names", "Errors, and what concerns the whole package."),
)
INTRODUCTION = """Every public name has a page with its shapes, units, errors and sources.
``import envlights as el`` gives the names of the first pages, and the packages below as
``el.plot``, ``el.export`` and so on.

"""
#: Packages with names of their own.
PACKAGES = (
    *("rigs", "detection", "splitting", "cards", "sun", "fitting", "papers", "batches"),
    *("scene", "viewer", "comparison", "placing", "sequence", "transfer"),
    *("plot", "export", "frames", "io", "layers", "synthetic", "kernels"),
)
#: Pages of the guide on a package.
GUIDES = {
    "rigs": "choose",
    "fitting": "choose",
    "detection": "choose",
    "splitting": "lights",
    "cards": "lights",
    "sun": "lights",
    "papers": "method",
    "kernels": "method",
    "batches": "many",
    "sequence": "many",
    "scene": "view",
    "viewer": "view",
    "comparison": "compare",
    "placing": "metres",
    "transfer": "transfer",
    "layers": "training",
    "export": "programs/index",
    "frames": "axes",
    "io": "maps",
    "plot": "reference/figures",
}


def page_of(name: str) -> Page:
    """Page of a name of `envlights.__all__`."""
    module = getattr(getattr(el, name), "__module__", "").split(".")
    return next((page for page in PAGES if module[1:] and module[1] in page.modules), PAGES[-1])


def is_again(package: str, name: str) -> bool:
    """True for a name of a package that `envlights` has as well."""
    return name in el.__all__ and getattr(el, name) is getattr(getattr(el, package), name)


def names_of(package: str) -> Iterator[str]:
    """Names of a package that `envlights` itself does not have, in full."""
    for name in getattr(el, package).__all__:
        if not is_again(package, name):
            yield f"envlights.{package}.{name}"


def heading(title: str) -> str:
    """Title of a page."""
    return f"{title}\n{'=' * len(title)}\n\n"


def table(names: list[str]) -> str:
    """Table of names, each with a page of its own."""
    listed = "".join(f"   ~{name}\n" for name in names)
    return f".. autosummary::\n   :nosignatures:\n   :toctree: names\n\n{listed}\n"


def constant(package: str, name: str) -> str:
    """Entry of a constant, with the comment before it in the source."""
    folder = Path(inspect.getfile(getattr(el, package))).parent
    comments = (
        re.search(rf"^((?:#: .*\n)+){name}\b", path.read_text(encoding="utf-8"), re.MULTILINE)
        for path in sorted(folder.glob("*.py"))
    )
    comment = next((found[1] for found in comments if found), "")
    text = " ".join(line[3:] for line in comment.splitlines())
    return f".. py:data:: envlights.{package}.{name}\n\n   {text}\n\n"


def is_constant(value: object) -> bool:
    """True for a value that has no text of its own."""
    return not (inspect.ismodule(value) or inspect.isclass(value) or inspect.isroutine(value))


def package_page(package: str) -> str:
    """Page of a package: its text, its names, and its names that `envlights` has too."""
    names = list(names_of(package))
    module = getattr(el, package)
    modules = [name for name in names if inspect.ismodule(getattr(module, name.split(".")[-1]))]
    # The rest of the text is for those who change the package.
    first = inspect.getdoc(module).split("\n\n")[0]
    text = f"{heading(module.__name__)}{first}\n\n"
    if package in GUIDES:
        text += f"More in :doc:`/docs/{GUIDES[package]}`.\n\n"
    constants = [name.split(".")[-1] for name in names]
    constants = [name for name in constants if is_constant(getattr(module, name))]
    apart = {*modules, *(f"{module.__name__}.{name}" for name in constants)}
    text += table([name for name in names if name not in apart])
    text += "".join(constant(package, name) for name in constants)
    text += f".. module:: {module.__name__}\n\n"
    for name in modules:
        text += f".. automodule:: {name}\n   :members:\n\n"
    again = [name for name in getattr(el, package).__all__ if is_again(package, name)]
    if again:
        text += "Also here: " + ", ".join(f":obj:`envlights.{name}`" for name in again) + ".\n"
    return text


def commands_page() -> str:
    """Help of each command."""
    text = (
        heading("Commands")
        + "``envlights --help`` and ``envlights COMMAND --help`` print this page.\n\n"
    )
    for context in contexts(click.Context(main, info_name="envlights", **main.context_settings)):
        title = context.command_path
        body = context.get_help().replace("\n", "\n   ")
        text += f"{title}\n{'-' * len(title)}\n\n.. code-block:: text\n\n   {body}\n\n"
    return text


def contexts(context: click.Context) -> Iterator[click.Context]:
    """Context of a command, and those of its subcommands, which inherit its settings."""
    yield context
    group = context.command
    if isinstance(group, click.Group):
        for name in group.list_commands(context):
            command = group.get_command(context, name)
            assert command is not None
            yield from contexts(click.Context(command, parent=context, info_name=name))


def texts() -> dict[str, str]:
    """Text of each page by its name."""
    found: dict[str, list[str]] = {}
    for name in el.__all__:
        if not isinstance(getattr(el, name), ModuleType):
            found.setdefault(page_of(name).file, []).append(f"envlights.{name}")
    pages = {
        page.file: heading(page.title) + page.text + "\n\n" + table(found[page.file])
        for page in PAGES
    }
    pages |= {f"package_{package}": package_page(package) for package in PACKAGES}
    pages["commands"] = commands_page()
    listed = "".join(f"   {name}\n" for name in pages)
    index = f"{INTRODUCTION}.. toctree::\n   :maxdepth: 1\n\n{listed}"
    return {**pages, "index": heading("Reference") + index}


def write_pages(app, config) -> None:
    """Write pages that have changed, and have all of them searched for names."""
    folder = Path(app.srcdir) / "docs" / "reference"
    folder.mkdir(exist_ok=True)
    pages = texts()
    config.autosummary_generate = [f"docs/reference/{name}.rst" for name in pages]
    for name, text in pages.items():
        path = folder / f"{name}.rst"
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def setup(app) -> dict[str, bool]:
    """Write the pages before Sphinx looks for files."""
    app.connect("config-inited", write_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
