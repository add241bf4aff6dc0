"""Prediction of indirect light from a basis and a matrix: a model without its training."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common import html
from envlights._common.check import amount
from envlights._common.check import count as whole_number
from envlights._common.result import Result
from envlights._common.tables import Table
from envlights._native import EnvLightsError
from envlights.kernels import thumbnails
from envlights.transfer.compact import CompactBasis
from envlights.transfer.consistency import check_fields
from envlights.transfer.expand import bound, check_range, expand, project, region_mask, truncate
from envlights.transfer.pairs import PairSummary, image_stack, rgb_rows
from envlights.transfer.report import TransferReport
from envlights.transfer.training import familiarity
from envlights.transfer.training.basis import check_parameters

_PARAMETERS = {"rank", "ridge", "error", "nonnegative", "prior"}


@dataclass(frozen=True, eq=False, repr=False)
class Predictor(Result):
    """Basis of indirect images, with a matrix from direct light to coefficients in the basis."""

    basis: NDArray[Any] | CompactBasis
    """Orthonormal columns over the texels of `lit`, (texels, rank); rounded if the model is
    `compressed`."""

    lit: NDArray[np.bool_]
    """Texels that are lit in at least one image, (H, W). All other texels are predicted black."""

    transfer: NDArray[np.float64]
    """Matrices from direct light to coefficients, one per channel, (3, h * w, rank). With
    ``notebook=True`` each matrix takes all channels, (3, 3 * h * w, rank)."""

    mean: NDArray[Any]
    """Mean of all images in the texels of `lit` with ``notebook=True``; otherwise empty."""

    size: tuple[int, int]
    """Height and width of the direct images."""

    parameters: Mapping[str, Any]
    """Arguments `rank`, `ridge`, `error`, `nonnegative` of `fit`; True if it had a `prior`."""

    learnt: PairSummary
    """Summary of the training pairs, without their texels."""

    report: TransferReport
    """Size, times and errors of the model, also for lights outside the training pairs."""

    def __post_init__(self) -> None:
        if not isinstance(self.learnt, PairSummary) or not isinstance(self.report, TransferReport):
            raise EnvLightsError("learnt must be a PairSummary, and report a TransferReport")
        if set(self.parameters) != _PARAMETERS:
            names, given = (", ".join(sorted(each)) for each in (_PARAMETERS, self.parameters))
            raise EnvLightsError(f"parameters must be {names}; got {given or 'none'}")
        check_parameters(**self.parameters)
        arrays = {"transfer": self.transfer, "mean": self.mean, **vars(self.learnt)}
        check_fields(self.basis, self.lit, self.size, arrays)

    @property
    def is_notebook(self) -> bool:
        """True for a model with ``notebook=True``."""
        return len(self.mean) > 0

    def predict(
        self,
        direct: ArrayLike,
        *,
        error: float = 0.0,
        region: tuple[slice, slice] | None = None,
    ) -> NDArray[Any]:
        """Indirect light under new direct light.

        Parameters
        ----------
        direct : array_like, shape (h, w, 3 or 4) or (n, h, w, 3 or 4)
            One image or several, of the size and in the units of the pairs.
        error : float
            Relative RMS error that may be added for speed: each frame leaves out as many of the
            last directions as this error allows.
        region : (slice, slice), optional
            Rows and columns of the images to compute.

        Returns
        -------
        ndarray, shape (H, W, 3) or (n, H, W, 3)
            Linear RGB, of the `region` if one is given. It may be slightly negative where the truth
            is black; with ``nonnegative=True``, such texels are 0.

        Examples
        --------
        >>> import envlights as el
        >>> room = el.synthetic.room(32, width=16)
        >>> model = el.TransferModel.fit(room.direct[:24], room.indirect[:24])
        >>> model.predict(room.direct[24], error=0.05, region=(slice(4, 12), slice(16))).shape
        (8, 16, 3)
        """
        stack, is_one = image_stack("direct", direct, self.size)
        rows = rgb_rows(stack)
        # Scale the mean of a notebook model by the norm of each direct image.
        norm = np.linalg.norm(rows, axis=(1, 2)) if self.is_notebook else np.zeros(len(rows))
        features = rows.reshape(len(rows), 1, -1) if self.is_notebook else rows
        coefficients = np.swapaxes(features.swapaxes(0, 1) @ self.transfer, 0, 1)
        if amount("error", error, most=1.0) > 0:
            self._refuse_mean("leave directions out of a frame")
        # Compute the blocks of texels in the region, then crop.
        wanted = None if region is None else region_mask(region, self._shape)
        predicted = self._expanded(coefficients, norm, wanted, error)
        if self.parameters["nonnegative"]:
            np.maximum(predicted, 0, out=predicted)
        if region is not None:
            predicted = predicted[:, region[0], region[1]].copy()
        return predicted[0] if is_one else predicted

    def _expanded(
        self,
        coefficients: NDArray[np.float64],
        norm: NDArray[np.float64],
        wanted: NDArray[np.bool_] | None,
        error: float = 0.0,
    ) -> NDArray[Any]:
        check_range(bound(coefficients, norm, self.mean), self.basis.dtype)
        # Drop the directions that each frame does not need for this error.
        if error > 0:
            coefficients = truncate(coefficients, error)
        if isinstance(self.basis, CompactBasis):
            return self.basis.expand(coefficients, self._shape, wanted)
        return expand(coefficients, self.basis, self.lit, self.mean, norm, wanted)

    @property
    def _shape(self) -> tuple[int, int]:
        """Height and width of the indirect images."""
        return self.lit.shape[0], self.lit.shape[1]

    def _refuse_mean(self, what: str) -> None:
        # The mean is not orthogonal to the basis, so the error is unknown.
        if self.is_notebook:
            raise EnvLightsError(f"a model with notebook=True cannot {what}; fit without it")

    def project(self, indirect: ArrayLike) -> NDArray[Any]:
        """Project images onto the basis: the nearest images that `predict` could return.

        Parameters
        ----------
        indirect : array_like, shape (H, W, 3 or 4) or (n, H, W, 3 or 4)
            Images of indirect light.

        Returns
        -------
        ndarray, shape (H, W, 3) or (n, H, W, 3)
            Linear RGB.
        """
        stack, is_one = image_stack("indirect", indirect, self._shape)
        basis = self.basis.dense(self.lit) if isinstance(self.basis, CompactBasis) else self.basis
        coefficients = project(stack, basis, self.lit, self.mean)
        projected = self._expanded(coefficients, np.ones(len(stack)), None)
        return projected[0] if is_one else projected

    def unfamiliar(self, direct: ArrayLike) -> NDArray[np.float64]:
        """Fraction of direct light that no mixture of the training images explains.

        It is known before the image and grows with the error of `predict`: near 0, the light is
        like those of the pairs; towards 1, bake a pair for it and `add` it.

        Parameters
        ----------
        direct : array_like, shape (h, w, 3 or 4) or (n, h, w, 3 or 4)
            One image or several, of the size and in the units of the pairs.

        Returns
        -------
        ndarray, shape () or (n,)
            Norm of the part outside the training images, with a ridge of 1e-3, over that of the
            image; 0 where the image is black.

        Examples
        --------
        >>> import envlights as el
        >>> room = el.synthetic.room(32, width=16)
        >>> model = el.TransferModel.fit(room.direct[:24], room.indirect[:24])
        >>> old, new = model.unfamiliar(room.direct[:24]), model.unfamiliar(room.direct[24:])
        >>> bool(old.max() < new.min())
        True
        """
        stack, is_one = image_stack("direct", direct, self.size)
        found = familiarity.unfamiliarity(self.learnt.direct, rgb_rows(stack))
        return found[0] if is_one else found

    def next_lights(self, candidates: ArrayLike, count: int) -> NDArray[np.int64]:
        """Indices of candidates to bake next, each the most unfamiliar after all earlier ones.

        Parameters
        ----------
        candidates : array_like, shape (n, h, w, 3 or 4)
            Direct images of possible lights, which need no path tracing.
        count : int
            Number of lights, at most `n`.

        Returns
        -------
        ndarray, shape (count,)
            Indices of candidates, the most unfamiliar first.

        Examples
        --------
        >>> import envlights as el
        >>> room = el.synthetic.room(32, width=16)
        >>> model = el.TransferModel.fit(room.direct[:24], room.indirect[:24])
        >>> model.next_lights(room.direct[20:], count=3)
        array([ 9, 11,  7])
        """
        stack, _ = image_stack("candidates", candidates, self.size)
        if whole_number("count", count) > len(stack):
            raise EnvLightsError(f"count must be at most the {len(stack)} candidates; got {count}")
        return familiarity.most_unfamiliar(self.learnt.direct, rgb_rows(stack), count)

    def _noted(self, note: str) -> TransferReport:
        return replace(self.report, notes=(*self.report.notes, note))

    def _dense(self, what: str) -> NDArray[Any]:
        if isinstance(self.basis, CompactBasis):
            raise EnvLightsError(
                f"a compressed model cannot {what}; use the model before the compression"
            )
        return self.basis

    def in_short(self) -> str:
        """Rank of the model, and sizes of the images."""
        (rows, columns), (height, width) = self.size, self.lit.shape
        rank = self.transfer.shape[2]
        return f"rank {rank}, {columns}x{rows} to {width}x{height} pixels"

    def __str__(self) -> str:
        return str(self.report)

    def _table(self) -> Table:
        return self.report._table()

    def _lines(self) -> list[str]:
        return [self.report.in_short(), *self.report._lines()]

    def _pictures(self) -> tuple[str, ...]:
        return (html.picture(thumbnails.of_signed(self.directions(4)), "first directions"),)

    def directions(self, most: int) -> NDArray[Any]:
        """First columns of the basis as images; black texels stay black.

        Parameters
        ----------
        most : int
            Largest number of images.

        Returns
        -------
        ndarray, shape (n, H, W)
            Orthonormal: the sum of squares of each is 1, in a `compressed` model up to rounding.
        """
        components = min(whole_number("most", most), self.transfer.shape[2])
        one_each = np.repeat(np.eye(components)[:, None], 3, axis=1)
        return self._expanded(one_each, np.zeros(components), None)[..., 0]
