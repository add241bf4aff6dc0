"""Every kind of save, killed or on a full disk again and again: the old file stays, or the new one.

`python -m tests.saves 100` kills each kind that often, and fills the disk that often.
"""

import collections
import os
import signal
import sys
import tempfile
import time
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np

import envlights as el
from envlights._common.files import PICTURES
from envlights.environment.files.image_output import write_png, write_tiff
from envlights.sequence.formats import SUFFIXES
from tests.call_transfer import PRIOR
from tests.helpers import disk_that_is_full_after

#: Seconds until a process is killed at most: each saves a few times in it.
LONGEST = 0.06
ROOM = el.synthetic.room(8, width=64)
IMAGES = [el.synthetic.plain(seed, 128).radiance for seed in (0, 1)]
# Wide discs are saved as a map beside the file, points in it: their files differ.
RIGS = [el.fit(image, lights=2, sizes=not which) for which, image in enumerate(IMAGES)]
PHOTOGRAPHS = [el.detect_photograph(image) for image in IMAGES]
FIGURES = [
    el.plot.picture(*pair, figsize=(4, 3), dpi=40).figure for pair in zip(IMAGES, RIGS, strict=True)
]
MODELS = [
    el.TransferModel.fit(ROOM.direct[:pairs], ROOM.indirect[:pairs], rank=4) for pairs in (6, 8)
]
PRIORS = [replace(PRIOR, visible=PRIOR.visible / (1 + which)) for which in (0, 1)]


SUNS = [
    el.with_sun(image, el.sun.Sun("sun", direction=[0, 0.6, 0.8], irradiance=[9 + which] * 3))
    for which, image in enumerate(IMAGES)
]
CARDS = [
    el.cards.CardSplit(
        el.Cards(
            ["rectangle"],
            [np.array([[-1.0 - which, 0, 0.5], [0, -1, 0.5], [0, 0, 1]])],
            [[1.0] * 3],
        ),
        el.EnvMap(np.ones((8, 16, 3), np.float32)),
    )
    for which in (0, 1)
]
SHADOWS = [
    el.scene.shadow_overlay(rig, el.scene.Ball((0, 0.5, 0), 0.5), columns=64) for rig in RIGS
]
PAGES = [el.view(rig) for rig in RIGS]


TABLES = [
    el.comparison.FolderComparison(
        el.comparison.Protocol(), {"hall": el.compare(IMAGES[which], RIGS[which])}, {}
    )
    for which in (0, 1)
]

BATCHES = [
    el.batch([("hall", image)], lights=1 + which, jobs=1) for which, image in enumerate(IMAGES)
]


SEQUENCES = [el.follow([image, image], lights=2).sequence() for image in IMAGES]

#: For each kind the name of its file, and how the first or the second thing is saved there.
SAVES = {
    **{
        suffix: (f"rig{suffix}", lambda path, which: RIGS[which].save(path))
        for target in el.export.TARGETS
        for suffix in target.suffixes
        # Crates are packed by OpenUSD, in a folder of its own, and not everywhere.
        if suffix != ".usdc"
    },
    **{
        f"comparison {suffix}": (f"table{suffix}", lambda path, which: TABLES[which].save(path))
        for suffix in (".csv", ".json")
    },
    "prior": ("prior.npz", lambda path, which: PRIORS[which].save(path)),
    "batch .jsonl": ("lights.jsonl", lambda path, which: BATCHES[which].save(path)),
    "model": ("model.npz", lambda path, which: MODELS[which].save(path)),
    "image": ("image.exr", lambda path, which: el.io.write_exr(path, IMAGES[which])),
    "tif": ("image.tif", lambda path, which: write_tiff(path, IMAGES[which])),
    "sun": ("sun.usda", lambda path, which: SUNS[which].save(path)),
    "cards": ("cards.usda", lambda path, which: CARDS[which].save(path)),
    "codes": ("image.png", lambda path, which: write_png(path, IMAGES[which].clip(0, 1))),
    "places": ("photograph.csv", lambda path, which: PHOTOGRAPHS[which].save(path)),
    **{
        f"overlay {suffix}": (f"shadow{suffix}", lambda path, which: SHADOWS[which].save(path))
        for suffix in (".exr", ".png")
    },
    **{
        f"sequence {suffix}": (f"rigs{suffix}", lambda path, which: SEQUENCES[which].save(path))
        for suffix in SUFFIXES
        if suffix != ".usdc"
    },
    "page": ("page.html", lambda path, which: PAGES[which].save(path)),
    **{
        suffix: (f"picture{suffix}", lambda path, which: el.plot.save(FIGURES[which], path))
        for suffix in PICTURES
    },
    # Last: once pyarrow has worked, processes that are forked crash when they write an EXR.
    **(
        {"batch .parquet": ("lights.parquet", lambda path, which: BATCHES[which].save(path))}
        if find_spec("pyarrow")
        else {}
    ),
}


def kill_saves(name, times):
    """Kill a process `times` times while it saves; count which file stood there then."""
    file, save = SAVES[name]
    counted = collections.Counter()
    rng = np.random.default_rng(0)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / file
        whole = contents(path, save)
        for _ in range(times):
            process = os.fork()
            if not process:
                save_for_ever(path, save)
            time.sleep(LONGEST * rng.random())
            os.kill(process, signal.SIGKILL)
            assert os.waitpid(process, 0)[1] == signal.SIGKILL
            counted[whole.index(path.read_bytes())] += 1
        # The next save clears away what the killed ones left.
        save(path, 0)
        left = [each for each in Path(folder).iterdir() if each.name.startswith(".")]
        assert not left, [(each, each.stat()) for each in left]
    return counted


def save_for_ever(path, save):
    """Save one thing and the other in turn; leave only when killed."""
    try:
        for turn in range(10**9):
            save(path, turn % 2)
    finally:
        os._exit(1)


def contents(path, save):
    """The bytes of the two files."""
    whole = []
    for which in (1, 0):
        save(path, which)
        whole.insert(0, path.read_bytes())
    assert whole[0] != whole[1]
    return whole


def save_on_full_disk(name, times):
    """Save on a disk that is full after more and more bytes; count which file stood there then."""
    file, save = SAVES[name]
    counted = collections.Counter()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / file
        whole = contents(path, save)
        for size in np.linspace(0, 1.01 * len(whole[1]), times, dtype=int):
            save(path, 0)
            old = path.read_bytes()
            beside = sorted(Path(folder).iterdir())
            try:
                with disk_that_is_full_after(int(size)):
                    save(path, 1)
                assert path.read_bytes() != old
                counted[1] += 1
            except el.EnvLightsError:
                assert path.read_bytes() == old
                counted[0] += 1
            assert sorted(Path(folder).iterdir()) == beside
    return counted


def main(times):
    """Print the counts of each kind."""
    for name in SAVES:
        # To draw takes longer than a process lives.
        kills = "" if name in PICTURES else f"killed {dict(kill_saves(name, times))}, "
        print(f"{name:<12} {kills}full {dict(save_on_full_disk(name, times))}")


if __name__ == "__main__":
    main(int(sys.argv[1]))
