"""Text of XML: comments, and whole documents."""

from __future__ import annotations

import re
from typing import Any
from xml.etree import ElementTree


def comment(text: str) -> Any:
    r"""A comment; two hyphens would end it, so the first becomes ``\x2d``, as in `printable`."""
    return ElementTree.Comment(re.sub("-(?=-)", r"\\x2d", text))


def document(root: ElementTree.Element) -> str:
    """Indented text of a document."""
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"
