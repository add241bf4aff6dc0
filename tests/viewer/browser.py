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
    `wait`, an expression that must become true first, `picture`, the path of a screenshot, and
    `files`, the number of files that the script saves in `folder`.
    """
    job = {
        "chromium": CHROMIUM,
        "size": (320, 240),
        "scheme": "light",
        "still": True,
        "webgl": True,
        "files": 0,
    }
    job |= {"script": script, "argument": argument, "picture": None, "wait": "true"} | options
    path = page.with_suffix(".job.json")
    path.write_text(json.dumps(job))
    command = ["node", _HERE / "browser.mjs", page, path]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def overlapping_texts(page, **options):
    """Pairs of captions and controls of a page that overlap, and the number of all."""
    script = """() => {
      const names = ".probes span, .hint, .refining, .sides span, h1, legend, .slider span, output, .lamp > *, .files button, .note";
      const boxOf = (each) => { const range = document.createRange(); range.selectNodeContents(each); return (each.textContent ? range : each).getBoundingClientRect(); };
      const boxes = [...document.querySelectorAll(names)].map((each) => [each.className || each.textContent, boxOf(each)]).filter(([, box]) => box.width);
      const pairs = boxes.flatMap(([name, a], k) => boxes.slice(k + 1).filter(([, b]) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom).map(([other]) => [name, other]));
      return [pairs, boxes.length];
    }"""  # noqa: E501
    return run(page, script, **options)["result"]
