"""Pairs of direct and indirect images for training."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import count
from envlights._common.progress import progress_bar
from envlights._native import EnvLightsError
from envlights.scene.direct import AnyLights, as_rig
from envlights.scene.gather import DIRECT, check_blocks
from envlights.scene.mitsuba.scene import MitsubaScene
from envlights.transfer.files.database import ImagePairs
from envlights.transfer.prior import TransferPrior


@dataclass(frozen=True, eq=False, repr=False)
class BakedPairs(ImagePairs):
    """Reflected radiance of a scene under many rigs.

    Direct light, (k, 16, 16, 3), is that of `MitsubaScene.direct`; indirect light, (k, H, W, 3), is
    path-traced on the lightmap.
    """

    noise: NDArray[np.float64]
    """Relative noise of each indirect image, (k,)."""

    prior: TransferPrior | None = None
    """Prior of indirect light from the geometry, for `TransferModel.fit`; None if impossible, with
    a note in `skipped`."""

    skipped: tuple[str, ...] = ()
    """Notes on texels that were not rendered, and on a missing prior."""


def bake(
    scene: MitsubaScene,
    rigs: Iterable[AnyLights],
    samples: int = 256,
    *,
    seed: int = 0,
    size: int = DIRECT,
    progress: bool | None = None,
) -> BakedPairs:
    """Light a scene with each of many rigs, for `TransferModel.fit` to learn from.

    Parameters
    ----------
    scene : MitsubaScene
    rigs : iterable of Rig, Lights or DetectedLights
        Rigs like those of later predictions, with several lights in each and from all directions.
        Lights without a rig have no ambient term.
    samples : int
        Paths for each texel of the lightmap. Few are enough, because a model averages over rigs and
        so over noise.
    seed : int
        Seed of the paths, which differ from rig to rig.
    size : int
        Texels along a side of the direct images. 32 help only with the `prior` of the result.
    progress : bool, optional
        True: show a progress bar. Default: after a second, in a terminal or a notebook.

    Returns
    -------
    BakedPairs

    Examples
    --------
    >>> import envlights as el
    >>> yard = el.scene.MitsubaScene(el.synthetic.courtyard(), lightmap=16)
    >>> pairs = bake(yard, el.synthetic.rigs(8), samples=16)
    >>> model = el.TransferModel.fit(pairs.direct, pairs.indirect, prior=pairs.prior)
    >>> (new,) = el.synthetic.rigs(1, seed=1)
    >>> model.predict(yard.direct(new)).shape
    (16, 16, 3)
    """
    if not isinstance(scene, MitsubaScene):
        raise EnvLightsError(
            f"scene must be a MitsubaScene; got an object of the type {type(scene).__name__}"
        )
    lights = [as_rig(each) for each in rigs]
    if not lights:
        raise EnvLightsError("rigs is empty; give at least one rig")
    seed, size = count("seed", seed), count("size", size, least=1)
    prior, notes = _prior(scene, size, progress)
    direct, noise = [], []
    # Allocate all lightmaps first, because a copy might not fit into memory.
    indirect = np.empty((len(lights), *scene.lightmap.albedo.shape), np.float32)
    for k, rig in enumerate(progress_bar(lights, "baking", "rig", progress)):
        direct.append(scene.direct(rig, size))
        rendered = scene.indirect(rig, samples, seed + k)
        indirect[k] = rendered.image
        noise.append(rendered.noise)
    notes = (*_skip_notes(scene), *notes)
    return BakedPairs(np.stack(direct), indirect, np.array(noise), prior, notes)


def _prior(
    scene: MitsubaScene, size: int, progress: bool | None
) -> tuple[TransferPrior | None, tuple[str, ...]]:
    """Prior of the scene, or a note on why there is none."""
    check_blocks(scene.points, size)
    try:
        return scene.gather(size=size, progress=progress), ()
    except EnvLightsError as error:
        return None, (f"no prior: {error}",)


def _skip_notes(scene: MitsubaScene) -> tuple[str, ...]:
    """Note on lightmap texels without a surface."""
    covered = scene.lightmap.covered
    bare = np.count_nonzero(~covered)
    return (f"{bare} of {covered.size} texels of the lightmap: no surface",) if bare else ()
