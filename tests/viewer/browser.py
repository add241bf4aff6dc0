"""Chromium, driven by Node and playwright-core of `tests/viewer/package.json`, where installed."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest

_HERE = Path(__file__).parent
CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
_HAS_DRIVER = (_HERE / "node_modules" / "playwright-core").is_dir()

#: Skip where no browser can be driven: ``npm install --prefix tests/viewer``.
needs_browser = pytest.mark.skipif(
    not (CHROMIUM and shutil.which("node") and _HAS_DRIVER),
    reason="needs Chromium, Node and playwright-core from npm",
)


def run(page, script, argument=None, **options):
    """Result of a JavaScript function in a page, its messages, requests and time to open.

    Options: `size` in pixels, `scheme` of colours, `still` to draw nothing by itself, `webgl`,
    `wait`, an expression that must become true first, and `picture`, the path of a screenshot.
    """
    job = {
        "chromium": CHROMIUM,
        "size": (320, 240),
        "scheme": "light",
        "still": True,
        "webgl": True,
    }
    job |= {"script": script, "argument": argument, "picture": None, "wait": "true"} | options
    path = page.with_suffix(".job.json")
    path.write_text(json.dumps(job))
    command = ["node", _HERE / "browser.mjs", page, path]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)
