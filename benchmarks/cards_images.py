"""Images under the cards of a split map, beside those under the map itself.

    ENVLIGHTS_MAPS=folder python benchmarks/cards_images.py [NAME ...]

A ball and a box on a floor in Mitsuba, three bounces, 60 x 40 pixels, seen from the brightest card.
The remainder and the lights are drawn into one map: as discs, as cards of one colour, and as cards
with their textures. The difference is the relative RMS without the noise; the noise is that of the
noisier image. The mirror ball has 192 pixels and is looked up in the maps.
"""

import sys
from pathlib import Path

import numpy as np
from tests.helpers import EQUIRECTANGULAR, paths_of_real_maps

import envlights as el
from envlights.export.look_up import looked_up
from envlights.plot.ball import ball
from envlights.scene.mitsuba.path_traced import Still
from envlights.scene.still_life import still_life

#: Interiors whose lights have shapes.
_MAPS = ("empty_warehouse_01", "env_home_office", "studio_small_03", "f3d_defaultHDRI")
#: Columns of the maps, and paths through each pixel.
_COLUMNS, _PATHS = 1024, 400
_NORMALS, _SOLID_ANGLES = el.kernels.icosphere(5120)


def main():
    names = sys.argv[1:] or _MAPS
    print(f"{'map':>24} {'variant':>10} {'mirror':>8} {'irradiance':>10} {'image':>7} {'noise':>7}")
    for path in paths_of_real_maps(*EQUIRECTANGULAR):
        if any(Path(path).stem.startswith(name) for name in names):
            _rows(path)


def _rows(path):
    env = el.EnvMap.open(path)
    env = env.resized(_COLUMNS) if env.width > _COLUMNS else env
    parts = el.split(env, shapes=True)
    azimuth = 2 * np.pi * el.kernels.direction_to_uv(parts.cards.direction[:1])[0, 0]
    truth = _still(env, azimuth, 1)
    print(f"{Path(path).stem[:24]:>24} {parts.cards.in_short()}", flush=True)
    for seed, (name, each) in enumerate(variants(env, parts).items(), 2):
        still = _still(each, azimuth, seed)
        probe = el.kernels.relative_rms(each.probe(_NORMALS), env.probe(_NORMALS), _SOLID_ANGLES)
        print(
            f"{'':>24} {name:>10} {_mirror(each, env, azimuth):>8.2%} {probe:>10.3%}"
            f" {still.error(truth):>7.2%} {max(still.noise, truth.noise):>7.2%}",
            flush=True,
        )


def variants(env, parts):
    """Maps of the remainder with the lights as discs, and as cards."""
    cards, rest = parts
    plain, whole = el.split(env), rest.radiance
    uniform = el.Cards(
        cards.shape, cards.matrix, cards.irradiance, angular_radius=cards.angular_radius
    )
    # Lights without an outline are discs in every variant.
    distant = cards.distant.to_map(env.height).radiance
    flat = cards.has_outline
    drawn = {
        "discs": plain.remainder.radiance + plain.lights.to_map(env.height).radiance,
        "uniform": whole + distant + uniform[flat].to_map(env.width).radiance,
        "textured": whole + distant + cards[flat].to_map(env.width).radiance,
    }
    return {name: el.EnvMap(each) for name, each in drawn.items()}


def _still(env, azimuth, seed):
    """The scene under a map; four pixels are averaged to one, which halves the noise."""
    still = still_life(env, azimuth, _PATHS, seed)
    return Still(*(image.reshape(40, 2, 60, 2, 3).mean(axis=(1, 3)) for image in still))


def _mirror(env, truth, azimuth):
    """Relative RMS difference of a mirror ball seen from an azimuth."""
    eye = np.array([np.sin(azimuth), 0.0, -np.cos(azimuth)])
    normals = ball(eye).normals
    towards = 2 * (normals @ eye)[:, None] * normals - eye
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    seen, wanted = (looked_up(each, towards).astype(float) for each in (env, truth))
    return np.linalg.norm(seen - wanted) / np.linalg.norm(wanted)


if __name__ == "__main__":
    main()
