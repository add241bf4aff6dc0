"""Progress bar for long operations, in terminals and notebooks."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterable
from typing import TypeVar

_T = TypeVar("_T")

#: Seconds of work before a bar appears by default.
_DELAY = 1.0


def progress_bar(
    items: Iterable[_T], what: str, unit: str, progress: bool | None, total: int | None = None
) -> Iterable[_T]:
    """Iterate over the items, with a bar on stderr or in the notebook if `progress` is True.

    None: only in a terminal or a notebook, and only after a second. `total` is the number of items
    that have no length.
    """
    is_terminal = sys.stderr is not None and sys.stderr.isatty()  # pythonw has no stderr
    is_seen = is_terminal or _is_notebook()
    if not (is_seen if progress is None else progress):
        return items
    # Import tqdm only if a bar is shown.
    from tqdm import TqdmWarning

    # Suppress the warning of tqdm if ipywidgets are missing.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", TqdmWarning)
        from tqdm.auto import tqdm

    delay = _DELAY if progress is None else 0.0
    bar: Iterable[_T] = tqdm(items, desc=what, unit=unit, delay=delay, total=total)
    return bar


def _is_notebook() -> bool:
    """True in a Jupyter kernel."""
    kernel = sys.modules.get("ipykernel.zmqshell")
    interactive = sys.modules.get("IPython")
    shell = interactive.get_ipython() if kernel and interactive else None
    return shell is not None and isinstance(shell, kernel.ZMQInteractiveShell)  # type: ignore[union-attr]
