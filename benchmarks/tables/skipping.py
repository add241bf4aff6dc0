"""Skipped work on each scene, with the time that it saves and the error that it adds.

Both variants alternate in one process. "without" is the same work on data that leave nothing to
skip, or the exact step. The comparisons are those of `tests/skips.py`. A negative saving means that
the skip takes more time than it saves. For detection on the maps of the other parts, the error is
the number of skipped tiles with a bright pixel. `env.probe` and `predict` return plain arrays
without a report, so this table lists their skips; `fit`, `detect`, `bake` and `TransferModel.fit`
report theirs.
"""

from itertools import chain

from curves.results import run_times, typical
from tests.skips import of_map, skips

TITLE = "What is skipped"


def rows(maps, effort):
    """Yield a row for each scene and skip, and for each map."""
    more = effort._replace(rounds=3 * effort.rounds, seconds=effort.seconds / 4)
    real = (skip for name, env in maps.items() for skip in of_map(name, env.radiance))
    for skip in chain(skips(width=64 if effort.is_quick else 256), real):
        found = run_times({"on": skip.on, "off": skip.off}, more)
        on, off = (typical([found[name]]) for name in ("on", "off"))
        error = float(skip.error())
        yield {
            "scene": skip.scene,
            "stage": skip.stage,
            "skipped": skip.skipped,
            "with skip": f"{1e3 * on:.3g} ms",
            "without": f"{1e3 * off:.3g} ms",
            "saved": f"{round(100 * (1 - on / off)) or 0} %",
            "error": error,
            "bound": float(skip.bound),
            "agrees": "yes" if error <= skip.bound else "NO",
        }
