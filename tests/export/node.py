"""Node and the packages of `tests/export/package.json`, where they are installed."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest

_HERE = Path(__file__).parent


def needs(package):
    """Skip where a package of npm is not installed: ``npm install --prefix tests/export``."""
    return pytest.mark.skipif(not has(package), reason=f"needs Node and {package} from npm")


def has(package):
    """True if Node and the package are installed."""
    return bool(shutil.which("node")) and (_HERE / "node_modules" / package).is_dir()


def report(script, path, *more):
    """Report of a script of this folder on a file, with further arguments."""
    command = ["node", _HERE / script, path, *more]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert not done.stderr
    return json.loads(done.stdout)
