"""The two looks at the indirect images as tasks of Dask, for more than one machine.

Dask cuts the images into rows of the lightmap, all images of a row together, and hands the blocks
to its workers. Each worker does what one machine does, `gram.py` and `basis.py`, on its blocks:

    G = sum over blocks of G_b,    B = the rows of all B_b, one below the other.

What travels is a matrix of (3 k, 3 k) for each block, summed on the way, and the basis. Images of
which each stands in a file of its own become such an array by

    read = dask.delayed(lambda path: el.io.read_image(path).pixels)
    indirect = da.stack([da.from_delayed(read(path), (H, W, 3), np.float32) for path in paths])

and must then fit into the memories of all workers together, or be spilled: a block needs a little
of every image. Images that are stored in rows, as of Zarr, need not.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._native import EnvLightsError
from envlights.transfer import basis as local_basis
from envlights.transfer import gram as local_gram
from envlights.transfer.basis import Directions
from envlights.transfer.gram import Gram
from envlights.transfer.pairs import Pairs, check_finite


def gram(pairs: Pairs, centred: bool) -> Gram:
    """What `gram.gram` gives, for indirect images that are an array of Dask."""
    import dask
    import dask.array as da

    shared = _shared(replace(pairs, indirect=None))
    products, energy, lit = [], [], []
    for where, block in _blocks(pairs):
        part = dask.delayed(_gram)(shared, block, where, centred)
        rows, height = 3 * len(pairs.scale), where.stop - where.start
        products.append(da.from_delayed(part.products, (rows, rows), np.float64))
        energy.append(da.from_delayed(part.energy, (rows // 3,), np.float64))
        lit.append(da.from_delayed(part.lit, (height, pairs.indirect.shape[2]), np.bool_))
    sums = da.stack(products).sum(axis=0), da.stack(energy).sum(axis=0)
    return Gram(*dask.compute(*sums, da.concatenate(lit)))


def basis(pairs: Pairs, seen: Gram, first: Directions, centred: bool) -> tuple[Any, Any]:
    """What `basis.basis` gives, for indirect images that are an array of Dask."""
    import dask

    shared = _shared((replace(pairs, indirect=None), seen, first))
    parts = [dask.delayed(_basis)(shared, block, where, centred) for where, block in _blocks(pairs)]
    columns, mean = zip(*dask.compute(*parts), strict=True)
    return np.concatenate(columns), np.concatenate(mean)


def _shared(values: Any) -> Any:
    """What every task needs, sent to each worker once; not searched for arrays of Dask."""
    import dask

    return dask.delayed(values, pure=False, traverse=False)


def _blocks(pairs: Pairs) -> list[tuple[slice, Any]]:
    """Rows of the lightmap, and all images there, still to be computed.

    As many rows as make a block of the size that Dask is set to, ``array.chunk-size``.
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
    pairs, seen, first = shared
    here = replace(seen, lit=seen.lit[where])
    return local_basis.basis(replace(pairs, indirect=images), here, first, centred)
