"""Lights of `fit` against published fits of 100 spherical Gaussians to three maps.

Usage: python benchmarks/published_gaussians.py FOLDER

FOLDER is `code/envmaps` of the repository PhySG: three maps, and for each the file of its
Gaussians. These are drawn at the pixels that they were fitted to, rows from pole to pole.
docs/lab/fit.md has the result.
"""

import argparse
from pathlib import Path

import numpy as np

import envlights as el


def to_map(lobes, height, width):
    """Map of Gaussians: a row each of axis, sharpness and radiance."""
    theta, phi = np.meshgrid(
        np.linspace(0, np.pi, height), np.linspace(0, 2 * np.pi, width), indexing="ij"
    )
    sine = np.sin(theta)
    towards = np.stack([np.cos(phi) * sine, np.cos(theta), np.sin(phi) * sine], axis=-1)
    axes = lobes[:, :3] / np.linalg.norm(lobes[:, :3], axis=1, keepdims=True)
    values = np.exp(np.abs(lobes[:, 3]) * (towards @ axes.T - 1))
    return np.float32(values @ np.abs(lobes[:, 4:]))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    for path in sorted(folder.glob("envmap?.exr")):
        env = el.EnvMap.open(path)
        lobes = np.load(next((folder / f"{path.stem}_sg_fit").glob("*_100.npy"))).astype(float)
        guesses = {"100 Gaussians": el.EnvMap(to_map(lobes, *env.radiance.shape[:2]))}
        guesses |= {f"{count} lights": el.fit(env, count) for count in (4, 8, 16, 24)}
        for name, guess in guesses.items():
            found = el.compare(env, guess)
            errors = found.probe_error, found.shadow_error, found.gloss_error()
            print(f"{path.stem}, {name}:", *(f"{error:.2%}" for error in errors))


if __name__ == "__main__":
    main()
