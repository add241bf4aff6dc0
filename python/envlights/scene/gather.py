"""Light transport between the texels of a scene, by rays from each texel.

Rays leave a point with a density of cos / pi, so the fraction of them that hits a direct texel is
its form factor. Their directions are the points of Hammersley, shifted at random for each point of
the surface (Cranley and Patterson 1976). A sequence of shifts along the rows would repeat in the
same columns of each row, and bias the means over direct texels.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from envlights import kernels
from envlights._common.check import count, flag
from envlights._common.progress import progress_bar
from envlights._native import EnvLightsError
from envlights.scene.sky import cosine_hemisphere
from envlights.scene.surface import Surface, tangent_frames
from envlights.transfer.prior import MOST_RAYS, TransferPrior

#: Default texels along a side of direct images, and rays per texel.
DIRECT, RAYS = 16, 256
#: Results of a ray tracer for rays that hit no direct texel.
SKY, BACK = -1, -2
#: Ray tracer: origins (n, 3), unit directions (n, 3) -> index of the direct texel that each ray
#: hits (n,).
TexelHit = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.integer]]

#: Ratio of rays per direct texel to rays per lightmap texel, because errors of direct texels affect
#: all bounces.
_MORE = 4
#: Fraction of rays that hit back faces, above which a point is inside a solid.
_INSIDE = 0.9
#: Number of rays held in memory at once.
_BLOCK = 2**18


def gather(
    lightmap: Surface,
    points: Surface,
    texel_hit: TexelHit,
    rays: int = RAYS,
    *,
    size: int = DIRECT,
    irradiance: bool = False,
    progress: bool | None = None,
) -> TransferPrior:
    r"""Indirect light of diffuse surfaces from rays alone, with any ray tracer.

    Parameters
    ----------
    lightmap : Surface
        Surfaces behind the texels of the indirect images.
    points : Surface
        Points at which direct light is measured, several for each texel of the direct images, which
        are their means (see `Surface.means`). Its rows and columns are multiples of `size`.
    texel_hit : callable
        A function of origins and unit directions, (n, 3) each, that returns the texel of the direct
        image that each ray hits, (n,): ``row * size + column``. It returns -1 for the sky, and -2
        for the back of a surface, where direct light is not measured.
    rays : int
        Rays from each texel of the lightmap, and a quarter of those from each texel of the direct
        images.
    size : int
        Texels along a side of the direct images.
    irradiance : bool
        True if the images hold irradiance instead of reflected radiance.
    progress : bool, optional
        True: show a progress bar. Default: after a second, in a terminal or a notebook.

    Returns
    -------
    TransferPrior
        It predicts without any pair, and `TransferModel.fit` learns what it misses.

    Raises
    ------
    EnvLightsError
        If an albedo is 1 or more, the sizes do not fit, or the ray tracer returns anything else.

    Notes
    -----
    See `TransferPrior`. Points from which nearly all rays hit backs are inside a solid: they count
    as hidden and stay black. The rays are the same in each call.

    Examples
    --------
    Two squares with sides of 1 face each other at a distance of 1. Their form factor is 0.1998
    (Howell, *A Catalog of Radiation Heat Transfer Configuration Factors*, C-11):

    >>> import numpy as np
    >>> from envlights.scene import Surface
    >>> z, x = np.mgrid[0:16, 0:32] / 16 + 1 / 32
    >>> top = x > 1
    >>> place = np.stack([x % 1, top, z], axis=-1)
    >>> place, top = (np.pad(each, ((0, 16), (0, 0), (0, 0))[: each.ndim]) for each in (place, top))
    >>> normal = np.zeros(place.shape)
    >>> normal[:16, :, 1] = np.where(top[:16], -1, 1)
    >>> squares = Surface(place, normal, np.full(place.shape, 0.5))
    >>> def texel_hit(origins, directions):
    ...     goal = (directions[:, 1] > 0).astype(int)
    ...     steps = (goal - origins[:, 1]) / directions[:, 1]
    ...     ends = origins + steps[:, None] * directions
    ...     return np.where(((ends > 0) & (ends < 1))[:, [0, 2]].all(axis=1), goal, -1)
    >>> prior = gather(squares, squares, texel_hit, rays=1024, size=2)
    >>> prior.between[:2, :2].round(2)
    array([[0. , 0.2],
           [0.2, 0. ]])
    """
    rays, size = count("rays", rays, least=1, most=MOST_RAYS), count("size", size, least=1)
    flag("irradiance", irradiance)
    tracer = _Tracer(texel_hit, size * size, progress)
    group = _texels(points, size)
    hits, _ = tracer.trace(lightmap, rays)
    # Trace rays from the points, and sum them per direct texel, without points inside solids.
    of_point = -(-_MORE * rays * size * size // points.covered.size)
    seen, backs = tracer.trace(points, of_point)
    is_open = backs <= _INSIDE * of_point
    between = _sums(seen[is_open], group[is_open], size * size)
    number = np.maximum(np.bincount(group, minlength=size * size), 1)
    return TransferPrior(
        hits=hits,
        rays=rays,
        between=between / (of_point * number[:, None]),
        visible=np.bincount(group[is_open], minlength=size * size) / number,
        albedo=lightmap.albedo,
        covered=lightmap.covered,
        direct_albedo=points.means(points.albedo, size).reshape(-1, 3),
        size=(size, size),
        irradiance=irradiance,
    )


@dataclass(frozen=True, eq=False)
class _Tracer:
    """Rays from surfaces, counted by the direct texels that they hit."""

    texel_hit: TexelHit
    texels: int
    progress: bool | None

    def trace(self, surface: Surface, rays: int) -> tuple[NDArray[np.uint16], NDArray[np.int64]]:
        """Rays from each covered texel that hit each direct texel, and back faces."""
        origins, normals = surface.lifted()
        square = kernels.hammersley(rays)
        shifts = np.random.default_rng(0).random((len(origins), 2))
        hits = np.zeros((len(origins), self.texels), np.uint16)
        backs = np.zeros(len(origins), np.int64)
        step = max(1, _BLOCK // rays)
        blocks = range(0, len(origins), step)
        for first in progress_bar(blocks, "gathering", "block", self.progress):
            some = slice(first, first + step)
            frames = tangent_frames(normals[some])
            directions = cosine_hemisphere((square + shifts[some, None]) % 1) @ frames
            at = np.repeat(origins[some], rays, axis=0)
            hit = self._checked(at, directions.reshape(-1, 3)).reshape(-1, rays)
            hits[some], backs[some] = _counts(hit, self.texels), np.sum(hit == BACK, axis=1)
        return hits, backs

    def _checked(
        self, origins: NDArray[np.float64], directions: NDArray[np.float64]
    ) -> NDArray[np.int64]:
        """Result of the ray tracer; raises an error for invalid values."""
        answer = np.asarray(self.texel_hit(origins, directions))
        is_texel = answer.dtype.kind in "iu" and answer.shape == (len(origins),)
        if not is_texel or ((answer < BACK) | (answer >= self.texels)).any():
            span = f" from {answer.min()} to {answer.max()}" if is_texel else ""
            raise EnvLightsError(
                f"texel_hit must return a texel from 0 to {self.texels - 1}, -1 for the sky or -2"
                f" for a back, for each of {len(origins)} rays; got the dtype {answer.dtype} and"
                f" the shape {answer.shape}{span}"
            )
        return answer.astype(np.int64)


def _counts(hit: NDArray[np.int64], texels: int) -> NDArray[np.int64]:
    """Number of rays in each row that hit each texel, (n, texels)."""
    row, _ = np.nonzero(hit >= 0)
    flat = np.bincount(row * texels + hit[hit >= 0], minlength=len(hit) * texels)
    return flat.reshape(len(hit), texels)


def _sums(rows: NDArray[np.uint16], group: NDArray[np.int64], groups: int) -> NDArray[np.float64]:
    """Sums of rows by group, (groups, columns)."""
    sums = np.zeros((groups, rows.shape[1]))
    order = np.argsort(group, kind="stable")
    present, starts = np.unique(group[order], return_index=True)
    sums[present] = np.add.reduceat(rows[order], starts, axis=0, dtype=np.float64)
    return sums


def check_blocks(points: Surface, size: int) -> None:
    """Raise an error unless rows and columns of the points are multiples of `size`."""
    rows, columns = points.covered.shape
    if rows % size or columns % size:
        raise EnvLightsError(
            f"points must have a multiple of {size} rows and columns; got {rows}x{columns}"
        )


def _texels(points: Surface, size: int) -> NDArray[np.int64]:
    """Direct texel of each covered point; raises an error if a texel has none."""
    check_blocks(points, size)
    rows, columns = points.covered.shape
    row, column = np.nonzero(points.covered)
    return np.asarray(row // (rows // size) * size + column // (columns // size))
