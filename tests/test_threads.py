"""Threads of the kernels: their number, and systems without threads."""

import os
import subprocess
import sys

import pytest

import envlights as el

ALONE = """
import os, resource
import numpy as np
import envlights as el

image = np.random.default_rng(0).random((64, 128, 3), dtype=np.float32)
image[10, 10] = 500
if {limited}:
    if os.getuid() == 0:  # whom no limit stops
        os.setuid(65534)
    resource.setrlimit(resource.RLIMIT_NPROC, (1, 1))
for _ in range(2):
    print(el.fit(image, 2).lights.direction.tolist(), el.detect(image).direction.tolist())
"""


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere threads are not limited so")
def test_without_threads_to_be_had_the_thread_of_the_caller_does_the_work():
    alone, with_threads = (
        subprocess.run(
            [sys.executable, "-c", ALONE.format(limited=limited)],
            capture_output=True,
            text=True,
            check=True,
            env={**os.environ, "RAYON_NUM_THREADS": "2"},
        )
        for limited in (True, False)
    )
    assert alone.stdout == with_threads.stdout
    assert alone.stderr == ""


NUMBERS = """
import numpy as np
import envlights as el

image = np.random.default_rng(0).random((64, 128, 3), dtype=np.float32)
print(el.threads())
for number in (3, 1, 3):
    print(el.threads(number), el.threads(), el.fit(image, 2).lights.direction.tolist())
"""


@pytest.mark.parametrize("variable", [2, 5])
def test_the_environment_sets_the_threads_and_a_call_changes_them(variable):
    told = subprocess.run(
        [sys.executable, "-c", NUMBERS],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "RAYON_NUM_THREADS": str(variable)},
    )
    first, *others = told.stdout.splitlines()
    assert first == str(variable)
    assert [line.split()[:2] for line in others] == [["3", "3"], ["1", "1"], ["3", "3"]]
    assert len({line.split(maxsplit=2)[2] for line in others}) == 1


@pytest.mark.parametrize("number", [0, -1, 1.5, "2", True, 1025])
def test_numbers_of_threads_that_cannot_be_are_refused(number):
    before = el.threads()
    with pytest.raises(el.EnvLightsError, match="number must be"):
        el.threads(number)
    assert el.threads() == before
