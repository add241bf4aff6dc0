"""Links from parameters of the reference to the pages of the guide that help to choose them."""

import re

#: Parameters by page of the guide.
PAGES = {
    "choose": "lights error shadow_error gloss_error sizes max_radius ambient floor objective",
    "maps": "layout colour clip_level fill reading",
    "axes": "frame camera lux nits ev100 shaded",
    "lights": "sun shapes irradiance ratio",
    "programs/index": "target up",
    "view": "blending truth model",
    "many": "executor steadiness mix drop jitter",
    "compare": "protocol",
    "transfer": "prior ridge rank nonnegative",
    "metres": "depth room",
}
PAGE_OF = {name: page for page, names in PAGES.items() for name in names.split()}


def with_links(lines: list[str]) -> list[str]:
    """Lines of an entry, with a link after each parameter that the guide explains."""
    return [_with_link(line, re.match(r"\s+\*\*(\w+)\*\* : ", line)) for line in lines]


def _with_link(line: str, parameter: re.Match[str] | None) -> str:
    page = parameter and PAGE_OF.get(parameter[1])
    return f"{line} (:doc:`guide </docs/{page}>`)" if page else line


def add_links(app, what, name, value, options, lines: list[str]) -> None:
    """Add the links to an entry of a function or a class, after numpydoc has written it."""
    lines[:] = with_links(lines)


def setup(app) -> dict[str, bool]:
    """Connect after numpydoc, whose priority is 500."""
    app.connect("autodoc-process-docstring", add_links, priority=600)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
