"""Progress bars: their places, and results without a change."""

import subprocess
import sys

import pytest

from envlights._common.progress import progress_bar


class Terminal:
    """A stream that may be a terminal, and keeps its text."""

    def __init__(self, is_terminal):
        self.isatty = lambda: is_terminal
        self.told = ""

    def write(self, text):
        self.told += text

    def flush(self):
        pass


@pytest.mark.parametrize(
    ("progress", "is_terminal", "shown"),
    [(True, False, True), (False, True, False), (None, False, False), (None, True, True)],
)
def test_bars_are_for_those_who_look(monkeypatch, progress, is_terminal, shown):
    stream = Terminal(is_terminal)
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr("envlights._common.progress._DELAY", 0.0)
    assert list(progress_bar(range(5), "counting", "item", progress)) == list(range(5))
    assert ("counting: 100%" in stream.told) == shown


def test_short_work_shows_nothing_unasked(monkeypatch):
    stream = Terminal(True)
    monkeypatch.setattr(sys, "stderr", stream)
    assert list(progress_bar(range(5), "counting", "item", None)) == list(range(5))
    assert "counting" not in stream.told


def test_a_notebook_without_widgets_gets_a_bar_and_no_warning():
    pytest.importorskip("ipykernel")
    code = """if True:
        import ipykernel.zmqshell
        import tqdm.notebook
        from envlights._common import progress
        tqdm.notebook.IProgress = None
        list(progress.progress_bar(range(3), "counting", "item", True))
    """
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "counting: 100%" in told.stderr
    assert "IProgress" not in told.stderr
