"""The transfer model: indirect light from direct light."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _html, _thumbnails
from envlights._check import amount, check_progress, count, flag
from envlights._native import EnvLightsError
from envlights._result import Result
from envlights.transfer import archive, grow
from envlights.transfer.basis import check_parameters
from envlights.transfer.compact import CompactBasis, compress
from envlights.transfer.consistency import check_fields
from envlights.transfer.expand import check_range, expand, project, region_mask, truncate
from envlights.transfer.pair_summary import PairSummary
from envlights.transfer.pairs import as_array, image_stack, pairs_of, rgb_rows
from envlights.transfer.report import TransferReport
from envlights.transfer.training import solve, train

_PARAMETERS = {"rank", "ridge", "error"}
#: End of the note on black texels.
_BLACK = "texels are black in every image, so they are predicted black"


@dataclass(frozen=True, eq=False, repr=False)
class TransferModel(Result):
    """A linear map from small images of direct light to images of indirect light.

    Light is linear, and so is the model, for any brightness; it neither clips nor applies gamma.

    Examples
    --------
    A small room that the package generates, with 24 lightings to learn from and 8 new ones:

    >>> import envlights as el
    >>> room = el.synthetic.room(32, width=16)
    >>> model = el.TransferModel.fit(room.direct[:24], room.indirect[:24], rank=16)
    >>> model.predict(room.direct[24:]).shape
    (8, 16, 16, 3)
    >>> print(model)  # doctest: +ELLIPSIS
    rank 16 from 24 pairs, ...
    """

    basis: NDArray[Any] | CompactBasis
    """Orthonormal columns over the texels of `lit`, (texels, rank); rounded in a model that is
    `compressed`."""

    lit: NDArray[np.bool_]
    """Texels that are not black in every image, (H, W). The others are predicted black."""

    transfer: NDArray[np.float64]
    """Matrices from direct light to coefficients, one for each channel, (3, h * w, rank). With
    ``notebook=True`` each takes all channels, (3, 3 * h * w, rank)."""

    mean: NDArray[Any]
    """Mean of all images in the texels of `lit` with ``notebook=True``; otherwise empty."""

    size: tuple[int, int]
    """Height and width of the direct images."""

    parameters: Mapping[str, Any]
    """Arguments `rank`, `ridge` and `error` of `fit`."""

    learnt: PairSummary
    """Summary of the pairs, without their texels."""

    report: TransferReport
    """Size, times and errors of the model, among them those on lights outside its pairs."""

    def __post_init__(self) -> None:
        if not isinstance(self.learnt, PairSummary) or not isinstance(self.report, TransferReport):
            raise EnvLightsError("learnt must be a PairSummary, and report a TransferReport")
        if set(self.parameters) != _PARAMETERS:
            names, given = (", ".join(sorted(each)) for each in (_PARAMETERS, self.parameters))
            raise EnvLightsError(f"parameters must be {names}; got {given or 'none'}")
        check_parameters(**self.parameters)
        arrays = {"transfer": self.transfer, "mean": self.mean, **vars(self.learnt)}
        check_fields(self.basis, self.lit, self.size, arrays)

    @classmethod
    def fit(
        cls,
        direct: ArrayLike,
        indirect: ArrayLike,
        rank: int | float = 64,
        ridge: float | str = 1e-3,
        *,
        error: float | None = None,
        notebook: bool = False,
        progress: bool | None = None,
    ) -> TransferModel:
        r"""Learn from pairs of images of one scene under many lights.

        Parameters
        ----------
        direct : array_like, shape (k, h, w, 3 or 4)
            Linear RGB of the direct light at a few points of the scene, as irradiance or as
            reflected radiance. Alpha is dropped.
        indirect : array_like, shape (k, H, W, 3 or 4)
            Linear RGB of the indirect light: an array, a mapped file, or an array of Dask. The
            basis of float64 images is float64, which ranks above about 200 need.
        rank : int or float
            An int: largest number of directions. A float up to 1.0: fraction of the energy of the
            images that the basis holds.
        ridge : float or "loo"
            Ridge of the regression, for direct images of norm 1. "loo": the ridge with the least
            leave-one-out errors, which is smaller for clean images than for noisy ones.
        error : float, optional
            Largest accepted relative RMS error of the images in the basis, which gets the fewest
            directions that reach it, and at most `rank`.
        notebook : bool
            Fit the model of the notebook of Belcour, Deliot, Barbier and Soler, for comparison:
            around the mean image, each channel from all channels, with direct images of norm 1.
        progress : bool, optional
            Progress bars for the two passes over the images; see `read_pairs`.

        Returns
        -------
        TransferModel
            With leave-one-out errors in its `report`.

        Raises
        ------
        EnvLightsError
            If the images do not fit together, hold NaN or infinities, or are all black; if a
            parameter is not one of the above.

        Notes
        -----
        With the rows :math:`x_c` of the direct and :math:`y_c` of the indirect image in the channel
        :math:`c`, the orthonormal basis :math:`B` and the ridge :math:`\lambda`,

        .. math:: \hat y_c = B T_c^T x_c, \quad
            T_c = X_c^T (X_c X_c^T + \lambda I)^{-1} Y_c B .

        Examples
        --------
        >>> import numpy as np
        >>> rng = np.random.default_rng(0)
        >>> direct = rng.random((40, 2, 2, 3))
        >>> indirect = np.repeat(direct.mean(axis=(1, 2), keepdims=True), 8, axis=1)
        >>> model = TransferModel.fit(direct, indirect, ridge=0.0)
        >>> model.report.rank, model.report.error < 1e-6
        (1, True)
        """
        limits, notebook = check_parameters(rank, ridge, error), flag("notebook", notebook)
        check_progress(progress)
        # Keep parameters as plain numbers, which a file can hold.
        ridge = ridge if isinstance(ridge, str) else float(ridge)
        parameters = {"rank": limits.rank, "ridge": ridge, "error": limits.error}
        start = perf_counter()
        pairs = pairs_of(direct, indirect)
        columns, lit, mean, learnt, missed = train(pairs, limits, notebook, progress)
        height, width = np.shape(direct)[1:3]
        notes = (*pairs.notes, *missed)
        model = _solve(columns, lit, mean, (height, width), parameters, learnt, notes)
        seconds = {"fit": perf_counter() - start}
        return replace(model, report=replace(model.report, seconds=seconds))

    @property
    def is_notebook(self) -> bool:
        """True for the notebook's model."""
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
            is black.

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
        # The notebook's model is linear at a given norm: its mean is multiplied by that norm.
        norm = np.linalg.norm(rows, axis=(1, 2)) if self.is_notebook else np.zeros(len(rows))
        features = rows.reshape(len(rows), 1, -1) if self.is_notebook else rows
        coefficients = np.swapaxes(features.swapaxes(0, 1) @ self.transfer, 0, 1)
        # Leave out the directions that each frame can spare.
        if amount("error", error, most=1.0) > 0:
            self._refuse_mean("leave directions out of a frame")
            coefficients = truncate(coefficients, error)
        # Compute the blocks of texels that the region touches, then crop.
        wanted = None if region is None else region_mask(region, self._shape)
        predicted = self._expanded(coefficients, norm, wanted)
        if region is not None:
            predicted = predicted[:, region[0], region[1]].copy()
        return predicted[0] if is_one else predicted

    def _expanded(
        self,
        coefficients: NDArray[np.float64],
        norm: NDArray[np.float64],
        wanted: NDArray[np.bool_] | None,
    ) -> NDArray[Any]:
        check_range(coefficients, norm, self.mean, self.basis.dtype)
        if isinstance(self.basis, CompactBasis):
            return self.basis.expand(coefficients, self._shape, wanted)
        return expand(coefficients, self.basis, self.lit, self.mean, norm, wanted)

    @property
    def _shape(self) -> tuple[int, int]:
        """Height and width of the indirect images."""
        return self.lit.shape[0], self.lit.shape[1]

    def _refuse_mean(self, what: str) -> None:
        # The mean is not at right angles to the basis: nothing is known of the error.
        if self.is_notebook:
            raise EnvLightsError(f"a model with notebook=True cannot {what}; fit without it")

    def compressed(self, error: float = 0.005) -> TransferModel:
        """Model with a smaller basis, a third or half of the bytes, for faster frames.

        The basis is stored in the most compact type that keeps the bound: int8, float16, or
        unchanged. The notes of the report name the type and its error. Single frames gain most,
        batches of 32 or more least, because their frames share one pass over the basis.

        Parameters
        ----------
        error : float
            Largest relative RMS error that the rounding may add to a frame, for any light.

        Returns
        -------
        TransferModel
            It predicts, projects and is saved like any other, but `add` refuses it.

        Examples
        --------
        >>> import envlights as el
        >>> room = el.synthetic.room(32, width=16)
        >>> model = el.TransferModel.fit(room.direct, room.indirect)
        >>> print(model.compressed(error=0.01).report.notes[-1])  # doctest: +ELLIPSIS
        the basis is stored as int8: no frame changes by more than 0... % of its norm, ...
        """
        amount("error", error)
        self._refuse_mean("be compressed")
        basis = self._dense("be compressed again")
        compact, note = compress(basis, self.lit, self.learnt.coefficients, error)
        return replace(self, basis=compact, report=self._noted(note))

    def _noted(self, note: str) -> TransferReport:
        """Report with one more note."""
        return replace(self.report, notes=(*self.report.notes, note))

    def _dense(self, what: str) -> NDArray[Any]:
        """Uncompressed basis, or a refusal."""
        if isinstance(self.basis, CompactBasis):
            raise EnvLightsError(
                f"a compressed model cannot {what}; use the model before the compression"
            )
        return self.basis

    def project(self, indirect: ArrayLike) -> NDArray[Any]:
        """Project images onto the basis: the nearest images that `predict` could give.

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

    def add(self, direct: ArrayLike, indirect: ArrayLike) -> TransferModel:
        """Add pairs to those of the model; only the new pairs are read.

        The model holds only the part of its earlier pairs inside the basis. So the new basis is
        slightly worse than that of a fit to all pairs, and errors of earlier pairs are estimates.

        Parameters
        ----------
        direct : array_like, shape (n, h, w, 3 or 4)
            Direct light of the new pairs.
        indirect : array_like, shape (n, H, W, 3 or 4)
            Indirect light of the new pairs. An array of Dask is computed first.

        Returns
        -------
        TransferModel
            Of all pairs, with the same parameters.
        """
        if self.is_notebook:
            raise EnvLightsError("a model with notebook=True cannot grow; fit all pairs again")
        basis = self._dense("take more pairs")
        start = perf_counter()
        # Check the sizes by one image of each, before the work on all.
        direct, indirect = as_array("direct", direct), as_array("indirect", indirect)
        image_stack("direct", direct[:1], self.size)
        image_stack("indirect", indirect[:1], self._shape)
        pairs = pairs_of(direct, indirect)
        # Grow the basis, then solve for its matrix.
        limits = check_parameters(**self.parameters)
        columns, lit, learnt = grow.extend(basis, self.lit, self.learnt, pairs, limits)
        notes = (*self.report.notes, *pairs.notes)
        model = _solve(columns, lit, self.mean, self.size, self.parameters, learnt, notes)
        seconds = {**self.report.seconds, "add": perf_counter() - start}
        return replace(model, report=replace(model.report, seconds=seconds))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the model as one .npz file with a version; a failure leaves no file behind.

        The suffix of `path` is ``.npz``; ``numpy.load(path, allow_pickle=False)`` opens it.
        """
        archive.save(path, vars(self))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> TransferModel:
        """Read a model that `save` wrote, or refuse a file of another kind or version."""
        return archive.load(path, cls)

    def in_short(self) -> str:
        """Rank of the model, and sizes of the images."""
        (rows, columns), (height, width) = self.size, self.lit.shape
        rank = self.transfer.shape[2]
        return f"rank {rank}, {columns}x{rows} to {width}x{height} pixels"

    def __str__(self) -> str:
        return str(self.report)

    def _html_parts(self) -> tuple[str, ...]:
        picture = _html.picture(_thumbnails.of_signed(self.directions(4)), "first directions")
        return (picture, *self.report._html_parts())

    def directions(self, most: int) -> NDArray[Any]:
        """First columns of the basis as images, black where all images are.

        Parameters
        ----------
        most : int
            Largest number of images.

        Returns
        -------
        ndarray, shape (n, H, W)
            Orthonormal: the sum of squares of each is 1, in a `compressed` model up to rounding.
        """
        components = min(count("most", most), self.transfer.shape[2])
        one_each = np.repeat(np.eye(components)[:, None], 3, axis=1)
        return self._expanded(one_each, np.zeros(components), None)[..., 0]


def _solve(
    columns: NDArray[Any],
    lit: NDArray[np.bool_],
    mean: NDArray[Any],
    size: tuple[int, int],
    parameters: Mapping[str, Any],
    learnt: PairSummary,
    notes: tuple[str, ...],
) -> TransferModel:
    """Model of a basis, with its transfer matrix and its errors."""
    # Remove the count of an earlier model from its notes.
    notes = tuple(note for note in notes if not note.endswith(_BLACK))
    if black := np.count_nonzero(~lit):
        notes = (*notes, f"{black} of {lit.size} {_BLACK}")
    transfer, report = solve(learnt, parameters["ridge"], channelwise=not len(mean), notes=notes)
    return TransferModel(columns, lit, transfer, mean, size, parameters, learnt, report)
