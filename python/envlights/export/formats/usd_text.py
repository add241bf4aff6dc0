"""Text of OpenUSD: prims, colours, and paths of files."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights.export.files import CONTROLS, check_link

_ESCAPES = str.maketrans({"\\": r"\\", '"': r"\""})


def string(text: str) -> str:
    """One line of text as a literal."""
    return f'"{text.translate(_ESCAPES)}"'


def asset(texture: str) -> str:
    """A path as a literal, which OpenUSD looks up beside the stage, not in its search paths.

    <UDIM> would stand for the numbers of many files, and a backslash for a slash.
    """
    check_link(texture, "OpenUSD", ["<UDIM>", "\\", *CONTROLS])
    path = texture if texture.startswith("../") else f"./{texture}"
    if "@" not in path:
        return f"@{path}@"
    return "@@@" + path.replace("@@@", r"\@@@") + "@@@"


def colour(values: NDArray[np.float64]) -> list[str]:
    """Colour and intensity with the product `values`."""
    most = float(values.max())
    tint = values / most if most > 0 else values
    return [
        f"color3f inputs:color = {tuple(tint.tolist())!r}",
        f"float inputs:intensity = {most!r}",
    ]


def prim(kind: str, name: str, lines: list[str], schemas: str = "") -> str:
    """A prim inside of the rig, with the names of applied schemas if there are some."""
    body = "".join(f"        {line}\n" for line in lines)
    applied = f" (\n        prepend apiSchemas = [{schemas}]\n    )" if schemas else ""
    return f'    def {kind} "{name}"{applied}\n    {{\n{body}    }}\n'
