"""The model: from direct light to indirect light."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._check import amount, check_choice
from envlights._native import EnvLightsError
from envlights._result import Result
from envlights.transfer import archive, cluster, grow
from envlights.transfer.basis import Wanted, basis, directions, outside
from envlights.transfer.compact import LARGEST, CompactBasis, rounded
from envlights.transfer.expand import enough, expand, gather, inside
from envlights.transfer.gram import gram
from envlights.transfer.learnt import Learnt
from envlights.transfer.pairs import as_array, frames, pairs_of
from envlights.transfer.report import TransferReport
from envlights.transfer.training import solved


@dataclass(frozen=True, eq=False, repr=False)
class TransferModel(Result):
    """A linear map from small images of direct light to images of indirect light.

    Light is linear: twice the light gives twice the image, and the image of two lights is the sum
    of theirs. So does the model, for any brightness; nothing is clipped and no gamma applied.

    Examples
    --------
    A small room that the package makes itself, 24 lightings to learn from and 8 that are new:

    >>> import envlights as el
    >>> room = el.synthetic.room(32, width=16)
    >>> model = el.TransferModel.fit(room.direct[:24], room.indirect[:24], rank=16)
    >>> model.predict(room.direct[24:]).shape
    (8, 16, 16, 3)
    >>> print(model)  # doctest: +ELLIPSIS
    rank 16 from 24 pairs, ...
    """

    basis: NDArray[Any] | CompactBasis
    """Orthonormal columns over the texels that are not black in every image, (lit texels, rank);
    of a model that is `compressed`, what is kept of them."""

    lit: NDArray[np.bool_]
    """Those texels, (H, W). The others are predicted black."""

    transfer: NDArray[np.float64]
    """What takes direct light to coefficients, (3, h * w, rank): one matrix for each channel. With
    ``notebook=True`` each sees all channels, (3, 3 * h * w, rank)."""

    mean: NDArray[Any]
    """Mean of all images in the lit texels, with ``notebook=True``; else empty."""

    size: tuple[int, int]
    """Height and width of the direct images."""

    parameters: Mapping[str, Any]
    """`rank`, `ridge` and `error` as they were asked for."""

    learnt: Learnt
    """What is kept of the pairs."""

    report: TransferReport
    """How the model was found, with its errors on lights that it has not seen."""

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
    ) -> TransferModel:
        r"""Learn from pairs of images of one scene under many lights.

        Parameters
        ----------
        direct : array_like, shape (k, h, w, 3 or 4)
            Linear RGB of the direct light at a few places of the scene, as irradiance or as the
            radiance that is reflected. Alpha is dropped and noted.
        indirect : array_like, shape (k, H, W, 3 or 4)
            Linear RGB of the indirect light. It is read in blocks: a mapped file does as well, and
            so does an array of Dask, on whose workers the blocks are then read. With float64 the
            basis is float64, for ranks beyond about 200; else float32.
        rank : int or float
            Directions of the basis at most, as an int; or the share of the energy of the images
            that they hold, as a float up to 1.0.
        ridge : float or "loo"
            Ridge of the regression, for direct images of norm 1; "loo": the one whose leave-one-out
            errors are least, which are lower for clean images than for noisy ones.
        error : float, optional
            Relative RMS error of the learnt images in the basis that is good enough: the fewest
            directions that reach it, and at most `rank`.
        notebook : bool
            The model of the notebook of Belcour, Deliot, Barbier and Soler instead, for comparison:
            around the mean image, every channel from all channels, in directions of norm 1.

        Returns
        -------
        TransferModel
            With leave-one-out errors in its `report`.

        Raises
        ------
        EnvLightsError
            If the images do not fit together, hold NaN or infinities, or are all black; if a
            parameter is none of the above.

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
        wanted = _wanted(rank, ridge, error)
        # Plain numbers, whatever they came as: they are saved.
        held = ridge if isinstance(ridge, str) else float(ridge)
        parameters = {"rank": wanted.rank, "ridge": held, "error": wanted.error}
        start = perf_counter()
        pairs = pairs_of(direct, indirect)
        gram_of, basis_of = (cluster.gram, cluster.basis) if pairs.is_lazy else (gram, basis)
        seen = gram_of(pairs, centred=notebook)
        found = directions(seen.products, pairs.dtype, seen.energy.sum())
        if not len(found.values):
            what = "the same in every image" if notebook else "black in every image"
            raise EnvLightsError(f"indirect is {what}; there is nothing to learn")
        rank = wanted.count(found.values)
        columns, mean = basis_of(pairs, seen, found.first(rank), centred=notebook)
        coefficients = found.first(rank).coefficients
        left = outside(seen.products, coefficients)
        learnt = Learnt(pairs.direct, coefficients, left, seen.energy)
        size = np.shape(direct)[1:3]
        notes = (*pairs.notes, *wanted.missed(found.values, rank))
        model = _solved(columns, seen.lit, mean, (size[0], size[1]), parameters, learnt, notes)
        seconds = {"fit": perf_counter() - start}
        return replace(model, report=replace(model.report, seconds=seconds))

    @property
    def is_notebook(self) -> bool:
        """Whether this is the notebook's model."""
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
            One image or several, of the size and the units that were learnt.
        error : float
            Relative RMS error that may be added for speed: each frame leaves out the last
            directions that it can do without.
        region : (slice, slice), optional
            Rows and columns of the images that are wanted; the others are not computed.

        Returns
        -------
        ndarray, shape (H, W, 3) or (n, H, W, 3)
            Linear RGB, or the `region` of it. Where the truth is black it may be slightly negative.

        Examples
        --------
        >>> import envlights as el
        >>> room = el.synthetic.room(32, width=16)
        >>> model = el.TransferModel.fit(room.direct[:24], room.indirect[:24])
        >>> model.predict(room.direct[24], error=0.05, region=(slice(4, 12), slice(16))).shape
        (8, 16, 3)
        """
        stack, is_one = frames("direct", direct, self.size)
        rows = np.moveaxis(stack, -1, 1).reshape(len(stack), 3, -1).astype(np.float64)
        norm = np.linalg.norm(rows, axis=(1, 2)) if self.is_notebook else np.zeros(len(rows))
        # The notebook's model is linear for a given norm: its mean is multiplied by it.
        features = rows.reshape(len(rows), 1, -1) if self.is_notebook else rows
        coefficients = np.swapaxes(features.swapaxes(0, 1) @ self.transfer, 0, 1)
        if amount("error", error, most=1.0) > 0:
            self._refuse_mean("leave directions out of a frame")
            coefficients = enough(coefficients, error)
        wanted = None if region is None else inside(region, self._shape)
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
        """A model whose frames are faster: its basis takes a third or half of the bytes.

        The basis is kept in int8 or float16, with a scale for 16 texels of each direction, or else
        as it is: in the most compact form that keeps the bound. The notes of the report say which
        one, and what it changes. Single frames and frames that stop early gain most, and batches of
        32 or more least: there the full basis is read once for all.

        Parameters
        ----------
        error : float
            Relative RMS error that the rounding may add, at most, to a frame of any light.

        Returns
        -------
        TransferModel
            One that predicts, projects, and is saved as any other, but takes no more pairs.

        Examples
        --------
        >>> import envlights as el
        >>> room = el.synthetic.room(32, width=16)
        >>> model = el.TransferModel.fit(room.direct, room.indirect)
        >>> print(model.compressed(error=0.01).report.notes[-1])  # doctest: +ELLIPSIS
        the basis is kept in int8: no frame changes by more than 0... % of its norm, ...
        """
        amount("error", error)
        self._refuse_mean("be compressed")
        basis = self._dense("be compressed again")
        energy = np.einsum("kcr,kcs->rs", self.learnt.coefficients, self.learnt.coefficients)
        for dtype in LARGEST:
            kept, wrong = rounded(basis, self.lit, dtype)
            most = np.sqrt(np.linalg.eigvalsh(wrong)[-1])
            if most <= error:
                usual = np.sqrt(np.sum(wrong * energy) / np.trace(energy))
                note = (
                    f"the basis is kept in {dtype}: no frame changes by more than"
                    f" {100 * most:.2g} % of its norm, those learnt by {100 * usual:.2g} %"
                )
                notes = (*self.report.notes, note)
                return replace(self, basis=kept, report=replace(self.report, notes=notes))
        notes = (*self.report.notes, f"neither int8 nor float16 keeps the error {error:g}")
        return replace(self, report=replace(self.report, notes=notes))

    def _dense(self, what: str) -> NDArray[Any]:
        """The basis in full, or a refusal."""
        if isinstance(self.basis, CompactBasis):
            raise EnvLightsError(
                f"a compressed model cannot {what}; take the one that it was made from"
            )
        return self.basis

    def project(self, indirect: ArrayLike) -> NDArray[Any]:
        """The nearest image that the basis holds: the best that `predict` could do.

        Parameters
        ----------
        indirect : array_like, shape (H, W, 3 or 4) or (n, H, W, 3 or 4)
            Images of indirect light.

        Returns
        -------
        ndarray, shape (H, W, 3) or (n, H, W, 3)
            Linear RGB.
        """
        stack, is_one = frames("indirect", indirect, self._shape)
        basis = self.basis.dense(self.lit) if isinstance(self.basis, CompactBasis) else self.basis
        coefficients = gather(stack, basis, self.lit, self.mean)
        held = self._expanded(coefficients, np.ones(len(stack)), None)
        return held[0] if is_one else held

    def add(self, direct: ArrayLike, indirect: ArrayLike) -> TransferModel:
        """A model of these pairs as well; only they are read.

        What the basis of this model left out of its own pairs is lost but for its size, so the
        basis is a little less good than that of a fit to all pairs at once, and the errors told of
        the earlier pairs are estimates.

        Parameters
        ----------
        direct : array_like, shape (n, h, w, 3 or 4)
            Direct light of the new pairs.
        indirect : array_like, shape (n, H, W, 3 or 4)
            Indirect light of the new pairs. An array of Dask is computed first.

        Returns
        -------
        TransferModel
            With the same parameters.
        """
        if self.is_notebook:
            raise EnvLightsError("a model with notebook=True takes no more pairs; fit all again")
        basis = self._dense("take more pairs")
        start = perf_counter()
        direct, indirect = as_array("direct", direct), as_array("indirect", indirect)
        frames("direct", direct[:1], self.size)
        frames("indirect", indirect[:1], self._shape)
        pairs = pairs_of(direct, indirect)
        wanted = _wanted(**self.parameters)
        columns, lit, learnt = grow.grown(basis, self.lit, self.learnt, pairs, wanted)
        notes = (*self.report.notes, *pairs.notes)
        model = _solved(columns, lit, self.mean, self.size, self.parameters, learnt, notes)
        seconds = {**self.report.seconds, "add": perf_counter() - start}
        return replace(model, report=replace(model.report, seconds=seconds))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the model as one .npz file, versioned, whole or not at all.

        Parameters
        ----------
        path : path-like
            A file with the suffix ``.npz``; ``numpy.load(path, allow_pickle=False)`` opens it.
        """
        archive.save(path, self)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> TransferModel:
        """Read a model that `save` wrote.

        Raises
        ------
        EnvLightsError
            If the file is missing, damaged, or of another kind or version.
        """
        return archive.load(path)

    def in_short(self) -> str:
        """Its rank, and the sizes of the images."""
        (rows, columns), (height, width) = self.size, self.lit.shape
        rank = self.transfer.shape[2]
        return f"rank {rank}, {columns}x{rows} to {width}x{height} pixels"

    def __str__(self) -> str:
        return str(self.report)


def _wanted(rank: object, ridge: object, error: object) -> Wanted:
    """The parameters of `fit`, or a refusal."""
    if isinstance(ridge, str):
        check_choice("ridge", ridge, ("loo",))
    else:
        amount("ridge", ridge)
    return Wanted.checked(rank, error)


def _solved(
    columns: NDArray[Any],
    lit: NDArray[np.bool_],
    mean: NDArray[Any],
    size: tuple[int, int],
    parameters: Mapping[str, Any],
    learnt: Learnt,
    notes: tuple[str, ...],
) -> TransferModel:
    """The model of a basis: its transfer matrix and its errors."""
    transfer, report = solved(learnt, parameters["ridge"], channelwise=not len(mean), notes=notes)
    return TransferModel(columns, lit, transfer, mean, size, parameters, learnt, report)
