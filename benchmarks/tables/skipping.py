"""Each skip on each scene, with the time that it saves and the error that it costs.

Both ways take turns; "without" is the same work on data that leave nothing to skip, or the exact
step. The comparisons are those of `tests/skips.py`. Where the saving is negative, the skip costs
more time than it saves.
"""

from curves.results import timed
from tests.skips import skips

TITLE = "What is skipped"


def rows(_maps, effort):
    """Yield a row for each scene and skip."""
    for skip in skips():
        found = timed({"on": skip.on, "off": skip.off}, effort._replace(rounds=3 * effort.rounds))
        (on, _), (off, _) = found["on"], found["off"]
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
