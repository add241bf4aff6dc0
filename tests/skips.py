"""Skips of each stage, and the same work without the skip.

A skip has no option: it is switched off by data that leave nothing to skip and change the result by
no more than the bound, or by the exact step that it replaces.
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

import envlights as el
from envlights import kernels, synthetic
from envlights.kernels.image import LUMINANCE
from tests.helpers import NORMALS, SOLID_ANGLES
from tests.stress.case import U32, light_of, lights_apart


class Skip(NamedTuple):
    """One skip of one stage on one scene."""

    scene: str
    stage: str
    skipped: str
    """Name and amount of the skipped work on this scene."""

    on: Callable[[], object]
    off: Callable[[], object]
    differ: Callable[[object, object], float]
    """Relative difference of both results."""

    bound: float
    reason: str

    def error(self):
        """Error of the skip."""
        return self.differ(self.on(), self.off())


def _gradient(height):
    up = kernels.pixel_directions(height, 2 * height)[..., 1:2]
    return ((1.5 + up) * [0.8, 1.0, 1.2]).astype(np.float32)


def _dark(height):
    """Three lamps, and nothing else."""
    radiance = np.zeros((height, 2 * height, 3), np.float32)
    for row, column, size in ((0.2, 0.1, 0.01), (0.25, 0.6, 0.02), (0.4, 0.8, 0.01)):
        side = max(1, int(size * height))
        top, left = int(row * height), int(2 * column * height)
        radiance[top : top + side, left : left + side] = 90, 70, 40
    return radiance


def _sunny(height):
    radiance = _gradient(height)
    radiance[height // 4, height // 3] = 4e4, 3.8e4, 3.4e4
    return radiance


def _clutter(height):
    return synthetic.hard(synthetic.EVALUATION[0], height).radiance.astype(np.float32)


#: Radiance of each scene, made for a number of rows.
SCENES = {"dark": _dark, "overcast": _gradient, "sunny": _sunny, "cluttered": _clutter}


def of_map(name, radiance):
    """Skips on a map of any kind; of detection, `off` tells the time alone.

    On a real map a speck may join a light, so what is checked are the tiles; that the lights are
    those of a tree without tiles is in `tests/detection/test_component_tree.py`.
    """
    yield _black_rows(name, radiance)
    yield _pixels(name, radiance)
    tiles = _dark_tiles(name, radiance)
    wrong = partial(_wrongly_shut, radiance)
    yield tiles._replace(differ=wrong, bound=0.0, reason="each bright pixel is in an open tile")


def skips(height=512, width=128):
    """Yield each skip on each scene, then those of the indirect light of the generated room."""
    for scene in SCENES:
        yield from of_scene(scene, height)
    yield from of_frames(width)


def of_scene(scene, height):
    """Yield each skip on one scene."""
    radiance = SCENES[scene](height)
    yield _black_rows(scene, radiance)
    yield _pixels(scene, radiance)
    yield _grey_channels(scene, radiance)
    yield _dark_tiles(scene, radiance)


def _differ(found, wanted):
    return kernels.relative_rms(found, wanted, SOLID_ANGLES)


def _black_rows(scene, radiance):
    """Rows that are black are not summed; a map that is black nowhere has none."""
    black = int((radiance == 0).all(axis=(1, 2)).sum())
    lit = np.maximum(radiance, np.float32(1e-9) * radiance.max())
    on, off = (partial(kernels.irradiance, each, NORMALS) for each in (radiance, lit))
    skipped = f"{black} of {len(radiance)} rows, which are black"
    root_mean_square = np.sqrt((on() ** 2).mean())
    bound = 8 * U32 + 1e-9 * float(radiance.max()) * np.pi / float(root_mean_square)
    return Skip(scene, "probe", skipped, on, off, _differ, bound, "what was added, and float32")


def _pixels(scene, radiance):
    """A fit works on a reduced map; the exact probe reads all pixels."""
    on = partial(kernels.working_irradiance, radiance, NORMALS)
    off = partial(kernels.irradiance, radiance, NORMALS)
    columns = kernels.probe.WORKING_COLUMNS
    skipped = f"all but {columns} of {radiance.shape[1]} columns; {on()[1]} cells are points"
    return Skip(
        scene, "fit: the probe", skipped, on, off, _first_differs, 2e-4, "`RENDERING_ERROR`"
    )


def _grey_channels(scene, radiance):
    """Channels that are equal are fitted once."""
    grey = np.repeat((radiance @ LUMINANCE)[..., None], 3, axis=2).astype(np.float32)
    coloured = grey * np.array([1, 1 + 1e-4, 1 - 1e-4], np.float32)
    on, off = (partial(el.fit, each, 4, sizes=False) for each in (grey, coloured))
    said = [note for note in on().report.skipped if "channels" in note]
    why = "the colour that was added"
    return Skip(scene, "fit of a grey map", "; ".join(said), on, off, _rigs_differ, 1e-3, why)


def _dark_tiles(scene, radiance):
    """Tiles without a bright pixel stay shut; a speck opens each, too dim to be a light."""
    lights = el.detect(radiance)
    level = 1.1 * lights.report.threshold
    specks = radiance.copy()
    places = specks[8::16, 8::16]
    places[places @ LUMINANCE < level] = level
    on, off = partial(el.detect, radiance), partial(el.detect, specks)
    said = [line for line in lights.report.details if "tiles" in line]
    why = "specks in the local background"
    return Skip(scene, "detection", "; ".join(said), on, off, _lights_differ, 1e-3, why)


def _wrongly_shut(radiance, lights, _, tile=16):
    """Difference between the tiles with a bright pixel and the opened tiles of the report."""
    luminance = kernels.reduced_luminance(radiance, 1024)
    rows, columns = np.nonzero(luminance > np.float32(lights.report.threshold))
    opened = len(set(zip(rows // tile, columns // tile, strict=True)))
    every = np.prod([-(-side // tile) for side in luminance.shape])
    said = f"{every - opened} of {every} tiles"
    return 0.0 if any(line.startswith(said) for line in lights.report.details) else np.inf


def _first_differs(found, wanted):
    return _differ(found[0], wanted)


def _rigs_differ(one, other):
    return _differ(one.probe(NORMALS), other.probe(NORMALS))


def _lights_differ(one, other):
    return lights_apart(other, one.direction, light_of(one), in_order=True)


def of_frames(width):
    """Skips of frames of indirect light; half of the texels are black in all images."""
    room = synthetic.room(64, width=width)
    direct, indirect, image = room.direct[:48], room.indirect[:48].copy(), room.direct[50]
    indirect[:, :, : width // 2] = 0
    model = el.TransferModel.fit(direct, indirect, 32)
    exact = partial(model.predict, image)
    for error in (0.01, 0.05):
        on, spared = partial(model.predict, image, error=error), _directions(model, image, error)
        stage, why = f"predict(error={error:g})", "the components left out, by Parseval"
        yield Skip("room", stage, spared, on, exact, _images_differ, error, why)
    compact = model.compressed()
    on, whole = partial(compact.predict, image, error=0.05), partial(compact.predict, image)
    spared = _directions(model, image, 0.05)
    yield Skip(
        "room", "compressed, predict(error=0.05)", spared, on, whole, _images_differ, 0.055, why
    )
    region = slice(10, 20), slice(-24, -4)
    on, off = partial(model.predict, image, region=region), lambda: exact()[region]
    spared, why = f"all texels but 10x20 of {width}x{width}", "the same sums in float32"
    yield Skip("room", "predict(region=)", spared, on, off, _images_differ, 1e-6, why)
    speckled = indirect.copy()
    speckled[0, :, : width // 2] = 1e-6 * indirect.max()
    whole = partial(el.TransferModel.fit(direct, speckled, 32).predict, image)
    said = [note for note in model.report.notes if "black" in note]
    why = "what was added"
    yield Skip("room", "predict", "; ".join(said), exact, whole, _images_differ, 1e-4, why)


def _images_differ(found, wanted):
    return float(np.linalg.norm(found - wanted) / np.linalg.norm(wanted))


def _directions(model, image, error):
    """Number of directions of the basis that the frame does not use."""
    from envlights.transfer.expand import truncate

    rows = image.transpose(2, 0, 1).reshape(1, 3, -1).astype(float)
    coefficients = np.swapaxes(rows.swapaxes(0, 1) @ model.transfer, 0, 1)
    rank = model.transfer.shape[2]
    return f"{rank - truncate(coefficients, error).shape[-1]} of {rank} directions"
