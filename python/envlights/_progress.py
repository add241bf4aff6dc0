"""A progress bar for long work, in a terminal and in a notebook."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Collection, Iterable
from typing import TypeVar

_T = TypeVar("_T")

#: Seconds of work before a bar appears that nobody asked for.
_DELAY = 1.0


def progress_bar(
    items: Collection[_T], what: str, unit: str, progress: bool | None
) -> Iterable[_T]:
    """The items one by one, with a bar on stderr or in the notebook if `progress` is True.

    None: only where somebody may look, in a terminal or a notebook, and only after a second.
    """
    is_seen = sys.stderr.isatty() or _is_notebook()
    if not (is_seen if progress is None else progress):
        return items
    # Here, so that what shows no bar does not wait for it.
    from tqdm import TqdmWarning

    # Without ipywidgets the bar is text, which is no reason for a red warning in the notebook.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", TqdmWarning)
        from tqdm.auto import tqdm

    delay = _DELAY if progress is None else 0.0
    bar: Iterable[_T] = tqdm(items, desc=what, unit=unit, delay=delay)
    return bar


def _is_notebook() -> bool:
    """Whether a kernel of Jupyter runs this."""
    kernel = sys.modules.get("ipykernel.zmqshell")
    interactive = sys.modules.get("IPython")
    shell = interactive.get_ipython() if kernel and interactive else None
    return shell is not None and isinstance(shell, kernel.ZMQInteractiveShell)  # type: ignore[union-attr]
