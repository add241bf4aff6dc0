"""Open damaged files, each in a watched process of its own.

`python -m tests.fuzz images 0 200` opens the files of these seeds and prints how many ended how.
"""

import collections
import contextlib
import faulthandler
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import envlights as el
from tests.helpers import limited_memory
from tests.mutations import mutate, mutated_json, mutated_npz, mutated_png, mutated_tokens

#: How a damaged file may end.
ALLOWED = {"answer", "EnvLightsError", "MemoryError"}
#: No file of these sizes takes that long.
SECONDS = 20
#: Memory beside what the process has: a header may ask for any.
BYTES = 2**32
AXES = np.vstack([np.eye(3), -np.eye(3)])


def images(folder):
    """Images of each format, and how to damage and to use one."""
    import OpenImageIO as oiio  # noqa: N813

    radiance = el.synthetic.hall(16).radiance
    codes = np.uint8(255 * np.clip(radiance, 0, 1))
    kinds = {
        "map.hdr": (radiance, {}),
        "zip.exr": (radiance, {"compression": "zip"}),
        "piz.exr": (radiance.astype(np.float16), {"compression": "piz"}),
        "tiles.exr": (radiance, {"tile": 16}),
        "8.png": (codes, {}),
        "16.png": (np.uint16(257) * codes, {}),
        "map.jpg": (codes, {}),
        "8.tif": (codes, {"compression": "zip"}),
        "float.tif": (radiance, {}),
        "map.tga": (codes, {}),
        "map.bmp": (codes, {}),
    }
    for name, (pixels, options) in kinds.items():
        spec = oiio.ImageSpec(32, 16, 3, oiio.TypeDesc(str(pixels.dtype)))
        if "tile" in options:
            spec.tile_width = spec.tile_height = options["tile"]
        if "compression" in options:
            spec.attribute("compression", options["compression"])
        file = oiio.ImageOutput.create(str(folder / name))
        assert file.open(str(folder / name), spec), name
        assert file.write_image(pixels), name
        file.close()

    def damage(path, rng):
        if path.suffix == ".png" and rng.integers(2):
            return mutated_png(path.read_bytes(), rng)
        return mutate(path.read_bytes(), rng)

    return sorted(folder.iterdir()), damage, lambda path: el.EnvMap.open(path).probe(AXES)


def models(folder):
    """Models, whole and compressed, with a notebook and without."""
    room = el.synthetic.room(16, width=16)
    model = el.TransferModel.fit(room.direct, room.indirect, rank=8)
    model.save(folder / "model.npz")
    model.compressed(0.05).save(folder / "compact.npz")
    el.TransferModel.fit(room.direct, room.indirect, rank=8, notebook=True).save(
        folder / "notebook.npz"
    )

    def use(path):
        model = el.TransferModel.load(path)
        assert str(model)
        answer = model.predict(room.direct[:1])
        assert np.isfinite(answer).all()

    return sorted(folder.iterdir()), mutated_npz, use


def rigs(folder):
    """Rigs with lights of each kind."""
    image = el.synthetic.hall(32).radiance
    el.fit(image, lights=3).save(folder / "discs.json")
    el.fit(image, lights=2, sizes=False, ambient="sh2").save(folder / "points.json")
    el.fit(image, lights=0).save(folder / "none.json")

    def damage(path, rng):
        kind = rng.integers(3)
        if kind == 0:
            return mutate(path.read_bytes(), rng)
        change = mutated_json if kind == 1 else mutated_tokens
        return change(path.read_text(), rng).encode()

    def use(path):
        rig = el.Rig.load(path)
        assert str(rig)
        assert not np.isnan(rig.probe(AXES)).any()

    return sorted(folder.iterdir()), damage, use


KINDS = {"images": images, "models": models, "rigs": rigs}


def open_damaged(kind, first, last):
    """Open the files of the seeds from `first` to `last`; print a line before and after each."""
    with tempfile.TemporaryDirectory() as name, limited_memory(BYTES):
        folder = Path(name)
        (folder / "whole").mkdir()
        wholes, damage, use = KINDS[kind](folder / "whole")
        for seed in range(first, last):
            rng = np.random.default_rng(seed)
            whole = wholes[seed % len(wholes)]
            damaged = folder / f"damaged{whole.suffix}"
            damaged.write_bytes(damage(whole, rng))
            print(seed, flush=True)
            print(seed, outcome(use, damaged, folder / "stderr"), sep="\t", flush=True)


def outcome(use, path, stderr):
    """Outcome of the use of a file; text on stderr is an outcome of its own."""
    faulthandler.dump_traceback_later(SECONDS, exit=True, file=sys.__stdout__)
    with words_to(stderr):
        try:
            use(path)
            end = "answer"
        except Exception as error:
            is_refusal = isinstance(error, el.EnvLightsError)
            end = "EnvLightsError" if is_refusal else type(error).__name__
            if end not in ALLOWED:
                end += f": {error}".replace("\n", " ")
    faulthandler.cancel_dump_traceback_later()
    words = stderr.read_text(errors="replace").strip().replace("\n", " ")
    return f"stderr: {words}" if words else end


@contextlib.contextmanager
def words_to(path):
    """Redirect stderr of this process, C code included, into a file."""
    kept = os.dup(2)
    with path.open("wb") as file:
        os.dup2(file.fileno(), 2)
        try:
            yield
        finally:
            sys.stderr.flush()
            os.dup2(kept, 2)
            os.close(kept)


def outcomes(kind, first, last):
    """Count of each outcome for these seeds, and the seeds of each forbidden outcome."""
    counted, bad = collections.Counter(), {}
    while first < last:
        command = [
            sys.executable,
            "-W",
            "error",
            "-m",
            "tests.fuzz",
            "--",
            kind,
            str(first),
            str(last),
        ]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        begun, ended = first, {}
        for line in done.stdout.splitlines():
            seed, _, end = line.partition("\t")
            if seed.isdecimal():
                begun = int(seed)
            if end:
                ended[begun] = end
        if done.returncode:
            # It was hung up or killed with the file of the last seed, or never began.
            ended[begun] = f"the process ended with {done.returncode}: {done.stderr[-300:]}"
        for seed, end in ended.items():
            counted[end if end in ALLOWED else "other"] += 1
            if end not in ALLOWED:
                bad[seed] = end
        first = max(ended) + 1
    return counted, bad


if __name__ == "__main__":
    is_watched = sys.argv[1] == "--"
    kind, first, last = sys.argv[1 + is_watched :]
    if is_watched:
        open_damaged(kind, int(first), int(last))
    else:
        counted, bad = outcomes(kind, int(first), int(last))
        print(kind, dict(counted))
        for seed, end in bad.items():
            print(f"  seed {seed}: {end}")
