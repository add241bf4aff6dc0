"""Calls without enough memory raise a MemoryError, as NumPy does."""

import os
import subprocess
import sys

import pytest

CALLS = {
    "blur": "kernels.blur(grey, 3.0)",
    "resize_bilinear": "kernels.resize_bilinear(grey, 4096, 8192)",
    "bresenham_line": "kernels.bresenham_line((0, 0), (9_000_000, 3_000_000))",
    "suppress": "kernels.suppress(points, 1e-3)",
    "neighbour_maximum": "kernels.neighbour_maximum(grey, pixels, 1)",
    "probe_jacobian": "kernels.probe_jacobian(unknowns, points, points)",
    "fit_probe": "el.fit_probe(points, points, 4)",
    "halton": "kernels.halton(9_000_000)",
    "pixel_directions": "kernels.pixel_directions(2048, 4096)",
    "predict": "compressed.predict(direct)",
    "resized": "env.resized(4096)",
    "rotated": "env.rotated([[0.36, 0.48, -0.8], [-0.8, 0.6, 0], [0.48, 0.64, 0.6]])",
}
CODE = """
import resource, sys
import numpy as np
import envlights as el
from envlights import kernels

rng = np.random.default_rng(0)
grey = rng.random((1024, 2048), dtype=np.float32)
points = rng.normal(size=(500_000, 3))
points /= np.linalg.norm(points, axis=1, keepdims=True)
pixels = np.argwhere(grey > 0.5)
unknowns = np.full(3 + 5 * 9, 0.5)
room = el.synthetic.room(16, width=64)
compressed = el.TransferModel.fit(room.direct, room.indirect).compressed(0.05)
direct = np.tile(room.direct, (60, 1, 1, 1))
env = el.EnvMap(np.tile(grey[..., None], 3))
# Start the threads, and what else takes memory once.
compressed.predict(direct[:1])
kernels.blur(grey[:8, :16], 1.0)

used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + 4_000_000,) * 2)
for call in sys.argv[1:]:
    try:
        eval(call)
        print("answered", flush=True)
    except MemoryError:
        print("refused", flush=True)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere memory is not limited so")
def test_what_does_not_fit_into_memory_is_refused():
    # Memory of earlier calls, and that which each thread has in reserve, would serve too.
    lean = {"MALLOC_ARENA_MAX": "1", "MALLOC_MMAP_THRESHOLD_": "65536", "OPENBLAS_NUM_THREADS": "1"}
    run = [sys.executable, "-c", CODE, *CALLS.values()]
    done = subprocess.run(
        run, capture_output=True, text=True, timeout=120, check=False, env=os.environ | lean
    )
    assert dict(zip(CALLS, done.stdout.split(), strict=False)) == dict.fromkeys(CALLS, "refused")
    assert done.returncode == 0
