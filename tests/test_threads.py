"""The threads of the kernels: where the system gives none."""

import subprocess
import sys

import pytest

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
        )
        for limited in (True, False)
    )
    assert alone.stdout == with_threads.stdout
    assert alone.stderr == ""
