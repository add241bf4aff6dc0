"""Draw every figure for every map of a folder, to look at: python benchmarks/gallery.py MAPS OUT.

MAPS is searched with its folders; OUT gets a PNG for each map and figure. Prints their seconds.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from pathlib import Path

import envlights as el
from envlights import plot

SUFFIXES = (".hdr", ".exr", ".png")


def figures(env: el.EnvMap) -> Iterator[tuple[str, plot.Picture]]:
    """Each figure of a map, by name."""
    rigs = [el.fit(env, lights=lights) for lights in (1, 4, 8)]
    found = el.detect(env)
    yield "map", plot.map_picture(env)
    yield "stops", plot.map_picture(env, stops=True)
    yield "rig", plot.picture(env, rigs[1])
    yield "rigs", plot.rigs_picture(env, *rigs)
    yield "errors", plot.error_picture(rigs[-1])
    yield "detected", plot.detection_picture(env, found)
    yield "sphere", plot.sphere_picture(env, found)
    yield "article", plot.article_picture(env)


def main(maps: Path, out: Path) -> None:
    out.mkdir(parents=True, exist_ok=True)
    for path in sorted(path for path in maps.rglob("*") if path.suffix in SUFFIXES):
        try:
            env = el.EnvMap.open(path)
        except el.EnvLightsError as refusal:
            print(refusal)
            continue
        start = time.perf_counter()
        for name, figure in figures(env):
            plot.save(figure, out / f"{path.stem}_{name}.png")
            now = time.perf_counter()
            print(f"{path.stem} {name} {now - start:.2f} s", flush=True)
            start = now


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:3]))
