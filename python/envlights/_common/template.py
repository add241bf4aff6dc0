"""Templates of files: a text for each mark."""

from __future__ import annotations

import re


def fill_template(template: str, **parts: str) -> str:
    """Template with a text in place of each mark: `units` for ``@UNITS@``.

    The template is read once, so that a mark inside a text stays as it is.
    """
    return re.sub("@([A-Z_]+)@", lambda mark: parts[mark[1].lower()], template)
