"""The two passes over the indirect images as Dask tasks, for more than one machine.

Dask cuts the images into rows of the lightmap, all images of a row together, and hands the blocks
to its workers. Each worker runs `gram.py` and `basis.py` on its blocks:

    G = sum over blocks of G_b,    B = the rows of all B_b, one below the other.

Between the machines travel a matrix of (3 k, 3 k) for each block, summed on the way, and the basis.
Images that are files become such an array by

    read = dask.delayed(lambda path: el.io.read_image(path).pixels)
    indirect = da.stack([da.from_delayed(read(path), (H, W, 3), np.float32) for path in paths])

They must then fit into the memory of all workers together, or be spilled to disk, because a block
needs a few rows of every image. Images that are stored by rows, as in Zarr, need not fit.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._native import EnvLightsError
from envlights.transfer.pairs import Pairs, check_finite
from envlights.transfer.training import basis as local_basis
from envlights.transfer.training import gram as local_gram
from envlights.transfer.training.basis import Directions
from envlights.transfer.training.gram import Gram


def gram(pairs: Pairs, centred: bool) -> Gram:
    """Compute `gram.gram` for indirect images in a Dask array."""
    import dask
    import dask.array as da

    # Make one task per block.
    shared = _shared(replace(pairs, indirect=None))
    products, energy, lit = [], [], []
    for where, block in _blocks(pairs):
        part = dask.delayed(_gram)(shared, block, where, centred)
        rows, height = 3 * len(pairs.scale), where.stop - where.start
        products.append(da.from_delayed(part.products, (rows, rows), np.float64))
        energy.append(da.from_delayed(part.energy, (rows // 3,), np.float64))
        lit.append(da.from_delayed(part.lit, (height, pairs.indirect.shape[2]), np.bool_))
    # Sum the results of the blocks, and join their masks.
    sums = da.stack(products).sum(axis=0), da.stack(energy).sum(axis=0)
    return Gram(*dask.compute(*sums, da.concatenate(lit)))


def basis(pairs: Pairs, measured: Gram, first: Directions, centred: bool) -> tuple[Any, Any]:
    """Compute `basis.basis` for indirect images in a Dask array."""
    import dask

    shared = _shared((replace(pairs, indirect=None), measured, first))
    parts = [dask.delayed(_basis)(shared, block, where, centred) for where, block in _blocks(pairs)]
    columns, mean = zip(*dask.compute(*parts), strict=True)
    return np.concatenate(columns), np.concatenate(mean)


def _shared(values: Any) -> Any:
    """Inputs of all tasks, sent to each worker once, and not searched for Dask arrays."""
    import dask

    return dask.delayed(values, pure=False, traverse=False)


def _blocks(pairs: Pairs) -> list[tuple[slice, Any]]:
    """Row slices of the lightmap, and all images in these rows as lazy arrays.

    The setting ``array.chunk-size`` of Dask decides how many rows make a block.
    """
    images = pairs.indirect.rechunk({0: -1, 1: "auto", 2: -1, 3: -1})
    ends = np.cumsum(images.chunks[1]).tolist()
    where = [slice(begin, end) for begin, end in zip([0, *ends[:-1]], ends, strict=True)]
    return list(zip(where, images.to_delayed().ravel(), strict=True))


def _gram(pairs: Pairs, images: NDArray[Any], where: slice, centred: bool) -> Gram:
    try:
        return local_gram.gram(replace(pairs, indirect=images), centred)
    except EnvLightsError:
        check_finite("indirect", images, first_row=where.start)
        raise


def _basis(
    shared: tuple[Pairs, Gram, Directions], images: NDArray[Any], where: slice, centred: bool
) -> tuple[Any, Any]:
    pairs, measured, first = shared
    here = replace(measured, lit=measured.lit[where])
    return local_basis.basis(replace(pairs, indirect=images), here, first, centred)
