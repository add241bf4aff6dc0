"""Draw all figures for all maps of a folder: python benchmarks/gallery.py MAPS OUT.

MAPS is searched with its folders; OUT gets a PNG for each map and figure. Prints the seconds of
processor time that each takes.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import envlights as el
from envlights import plot

SUFFIXES = (".hdr", ".exr", ".png")


def figures(env: el.EnvMap) -> dict[str, Callable[[], plot.Picture]]:
    """Each figure of a map, by name, yet to be drawn."""
    rigs = [el.fit(env, lights=lights) for lights in (1, 4, 8)]
    found = el.detect(env)
    drawn = {
        "map": partial(plot.map_picture, env),
        "stops": partial(plot.map_picture, env, stops=True),
        "rig": partial(plot.picture, env, rigs[1]),
        "rigs": partial(plot.rigs_picture, env, *rigs),
        "errors": partial(plot.error_picture, rigs[-1]),
        "detected": partial(plot.detection_picture, env, found),
        "sphere": partial(plot.sphere_picture, env, found),
        "article": partial(plot.loghin_picture, env),
        "split": partial(plot.split_picture, env, el.split(env)),
    }
    if found.weight is not None:
        drawn["plateau"] = partial(plot.plateau_picture, env, found)
    return drawn


def main(maps: Path, out: Path) -> None:
    out.mkdir(parents=True, exist_ok=True)
    for path in sorted(path for path in maps.rglob("*") if path.suffix in SUFFIXES):
        try:
            env = el.EnvMap.open(path)
        except el.EnvLightsError as refusal:
            print(refusal)
            continue
        for name, draw in figures(env).items():
            start = time.process_time()
            plot.save(draw(), out / f"{path.stem}_{name}.png")
            print(f"{path.stem} {name} {time.process_time() - start:.2f} s", flush=True)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:3]))
