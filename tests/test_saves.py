"""A save that is killed, or for which there is no place, leaves the old file or the new one."""

import os
import subprocess
import sys

import pytest

from tests.conftest import fills_a_disk
from tests.helpers import cases


@pytest.mark.slow
@fills_a_disk
@pytest.mark.skipif(not hasattr(os, "fork"), reason="nobody is killed so on Windows")
def test_the_old_file_or_the_new_one_stays():
    """In a process of its own: pytest has threads, and a forked child has none of them."""
    command = [sys.executable, "-m", "tests.saves", str(cases(short=6, long=100))]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    print(f"\n{done.stdout}")
    assert done.returncode == 0, done.stderr
