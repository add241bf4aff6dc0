"""Pages that the table of contents does not name, so that a new page needs no line in it."""

import re
from pathlib import Path

MARK = "(other pages)"


def with_other_pages(index: str, pages: list[str]) -> str:
    """Table of contents with the pages that it does not name in place of the mark."""
    named = set(re.findall(r"^(?:.* <)?([\w/]+)>?$", index, re.MULTILINE))
    return index.replace(MARK, "\n".join(page for page in sorted(pages) if page not in named))


def read_index(app, name: str, content: list[str]) -> None:
    """Complete the table of contents when Sphinx reads it."""
    if name == app.config.root_doc:
        folder = Path(app.confdir)
        pages = [path.stem for path in folder.glob("*.md") if path.stem != Path(name).name]
        content[0] = with_other_pages(content[0], pages)


def setup(app) -> dict[str, bool]:
    """Connect to the reading of pages."""
    app.connect("source-read", read_index)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
