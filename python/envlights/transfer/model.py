"""The transfer model: indirect light from direct light."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import amount, check_progress, flag
from envlights._common.printable import printable_parts
from envlights._native import EnvLightsError
from envlights.transfer.compact import CompactBasis, compress, places_of
from envlights.transfer.files import npz_file
from envlights.transfer.files.npz_file import Kind
from envlights.transfer.pairs import PairSummary, as_array, image_stack, pairs_of
from envlights.transfer.predictor import Predictor
from envlights.transfer.prior import TransferPrior
from envlights.transfer.report import TransferReport
from envlights.transfer.training import grow
from envlights.transfer.training.around_prior import Learning, check_prior, train_around
from envlights.transfer.training.basis import check_parameters
from envlights.transfer.training.train import nonnegative_priors, solve, train

#: Default limit on the number of directions, for models without a prior.
_RANK = 64
#: End of the note on black texels.
_BLACK = "texels are black in every image, so they are predicted black"

#: Arrays of a model, and those of a `PairSummary` in the order of its fields.
_ARRAYS = ("lit", "transfer", "mean")
_SUMMARY = ("direct", "coefficients", "outside", "energy")
#: Version 1 had wall times in its report. Versions before 3 had no non-negative models, and
#: versions before 4 had no priors. `scales` belong to a compact basis.
_KIND = Kind(
    "model",
    "envlights transfer model",
    4,
    (1, 2, 3, 4),
    (
        *("basis", "scales", "lit", "transfer", "mean", "size"),
        *_SUMMARY,
        *("parameters", "report"),
    ),
)


@dataclass(frozen=True, eq=False, repr=False)
class TransferModel(Predictor):
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

    @classmethod
    def fit(
        cls,
        direct: ArrayLike,
        indirect: ArrayLike,
        rank: int | float | None = None,
        ridge: float | str | None = None,
        *,
        error: float | None = None,
        nonnegative: bool = False,
        prior: TransferPrior | None = None,
        virtual: ArrayLike | None = None,
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
        rank : int or float, optional
            An int: largest number of directions. A float up to 1.0: fraction of the energy of the
            images that the basis holds. By default 64; with a `prior`, as many as let the basis
            leave out half of the error for new lights, and at most 256.
        ridge : float or "loo", optional
            Ridge of the regression, for direct images of norm 1; with a `prior`, of norm 1 once
            their texels are weighted. "loo": the ridge with the least leave-one-out errors, which
            is smaller for clean images than for noisy ones. By default 1e-3, or "loo" with
            ``nonnegative=True`` or a `prior`.
        error : float, optional
            Largest accepted relative RMS error of the images in the basis, which gets the fewest
            directions that reach it, and at most `rank`.
        nonnegative : bool
            First fit an operator without negative values from the direct texels to blocks of
            texels, then the ridge to the remainder. Errors for new lights are smaller, and the fit
            takes 0.1 to 0.3 s longer for direct images of 16x16 texels. The errors in the report
            are then those of 8 folds. On the noise-free room with 128 pairs the median error falls
            from 4.3 to 2.7 %.
        prior : TransferPrior, optional
            What the geometry of the scene says without pairs, from `MitsubaScene.gather`. The model
            learns the remainder, and errors for new lights are far smaller with few pairs.
        virtual : array_like, shape (n, h, w, 3 or 4), optional
            Direct images of other lights, with a `prior`: the basis then has directions for their
            indirect light too. By default blocks of direct texels, each alone.
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

        With ``nonnegative=True`` the ridge pulls towards a prior mean :math:`T_{0c}` instead of 0.
        It comes from non-negative least squares (ADMM; Boyd et al. 2011) for the sums over
        blocks of texels, spread over their texels by the RMS of each over all images.

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
        nonnegative, notebook = flag("nonnegative", nonnegative), flag("notebook", notebook)
        _refuse_both(nonnegative=nonnegative, notebook=notebook, prior=prior, virtual=virtual)
        if ridge is None:
            ridge = 1e-3 if prior is None and not nonnegative else "loo"
        is_free = prior is not None and rank is None and error is None
        limits = check_parameters(_RANK if rank is None else rank, ridge, error)
        check_progress(progress)
        # Store parameters as plain numbers, because a file holds only those.
        parameters = {
            "rank": limits.rank,
            "ridge": ridge if isinstance(ridge, str) else float(ridge),
            "error": limits.error,
            "nonnegative": nonnegative,
            "prior": prior is not None,
        }
        start = perf_counter()
        pairs = pairs_of(direct, indirect)
        if prior is not None:
            rows = check_prior(prior, np.shape(direct)[1:3], pairs, virtual)
            size = None if is_free else limits
            learning = train_around(pairs, prior, rows, size, ridge, progress)
            model = _around(learning, parameters, prior.size, pairs.notes)
            seconds = {"fit": perf_counter() - start}
            return replace(model, report=replace(model.report, seconds=seconds))
        columns, lit, mean, learnt, missed = train(pairs, limits, notebook, progress)
        height, width = np.shape(direct)[1:3]
        notes = (*pairs.notes, *missed)
        model = _solve(columns, lit, mean, (height, width), parameters, learnt, notes)
        seconds = {"fit": perf_counter() - start}
        return replace(model, report=replace(model.report, seconds=seconds))

    def compressed(self, error: float = 0.005) -> TransferModel:
        """Model with a rounded basis, a third or half of the bytes, for faster frames.

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

    def add(self, direct: ArrayLike, indirect: ArrayLike) -> TransferModel:
        """Add pairs to a trained model; only the new pairs are read.

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
        if self.parameters["prior"]:
            raise EnvLightsError(
                "a model with a prior cannot grow; fit all pairs again with the prior"
            )
        basis = self._dense("take more pairs")
        start = perf_counter()
        # Check the sizes with one image of each kind, before the work on all images.
        direct, indirect = as_array("direct", direct), as_array("indirect", indirect)
        image_stack("direct", direct[:1], self.size)
        image_stack("indirect", indirect[:1], self._shape)
        pairs = pairs_of(direct, indirect)
        # Extend the basis, then solve for the matrix.
        limits = check_parameters(**self.parameters)
        columns, lit, learnt, values = grow.extend(basis, self.lit, self.learnt, pairs, limits)
        rank, notes = columns.shape[1], (*self.report.notes, *pairs.notes)
        notes = grow.noting_missed(notes, limits, values, rank, self.learnt)
        model = _solve(columns, lit, self.mean, self.size, self.parameters, learnt, notes)
        seconds = {**self.report.seconds, "add": perf_counter() - start}
        return replace(model, report=replace(model.report, seconds=seconds))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the model as one .npz file with a version; a failure leaves no file behind.

        The suffix of `path` is ``.npz``; ``numpy.load(path, allow_pickle=False)`` opens it.
        """
        npz_file.write(path, _KIND, _to_file(self))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> TransferModel:
        """Read a model that `save` wrote; raises an error for another kind or version of file."""
        return npz_file.load(path, _KIND, _from_file)


def _refuse_both(nonnegative: bool, notebook: bool, prior: object, virtual: object) -> None:
    given = {
        "nonnegative=True": nonnegative,
        "notebook=True": notebook,
        "prior": prior is not None,
    }
    names = [name for name, is_given in given.items() if is_given]
    if len(names) > 1:
        raise EnvLightsError(f"{' and '.join(names)} exclude each other; drop one")
    if virtual is not None and prior is None:
        raise EnvLightsError("virtual lights need a prior; give one or drop virtual")


def _around(
    learning: Learning,
    parameters: Mapping[str, Any],
    size: tuple[int, int],
    notes: tuple[str, ...],
) -> TransferModel:
    columns, lit, mean, learnt, _ = learning.training
    report = replace(learning.report, notes=_noting_black((*notes, *learning.report.notes), lit))
    chosen = {**parameters, "rank": report.rank}
    return TransferModel(columns, lit, learning.transfer, mean, size, chosen, learnt, report)


def _noting_black(notes: tuple[str, ...], lit: NDArray[np.bool_]) -> tuple[str, ...]:
    """Notes, with the note on black texels replaced by the current one."""
    notes = tuple(note for note in notes if not note.endswith(_BLACK))
    black = np.count_nonzero(~lit)
    return (*notes, f"{black} of {lit.size} {_BLACK}") if black else notes


def _solve(
    columns: NDArray[Any],
    lit: NDArray[np.bool_],
    mean: NDArray[Any],
    size: tuple[int, int],
    parameters: Mapping[str, Any],
    learnt: PairSummary,
    notes: tuple[str, ...],
) -> TransferModel:
    notes = _noting_black(notes, lit)
    priors = nonnegative_priors(columns, lit, learnt) if parameters["nonnegative"] else None
    transfer, report = solve(learnt, parameters["ridge"], not len(mean), notes, priors)
    return TransferModel(columns, lit, transfer, mean, size, parameters, learnt, report)


def _to_file(model: TransferModel) -> dict[str, Any]:
    """Arrays to store in a file."""
    basis: dict[str, Any] = {"basis": model.basis}
    if isinstance(model.basis, CompactBasis):
        basis = {"basis": model.basis.values, "scales": model.basis.scales}
    return {
        **basis,
        **{name: getattr(model, name) for name in _ARRAYS},
        "size": np.array(model.size),
        **vars(model.learnt),
        "parameters": np.array(json.dumps(dict(model.parameters))),
        "report": np.array(json.dumps(model.report.to_dict())),
    }


def _from_file(data: Mapping[str, NDArray[Any]]) -> TransferModel:
    """Model from the arrays of a file; its constructor checks them."""
    basis: NDArray[Any] | CompactBasis = data["basis"]
    if "scales" in data:
        basis = CompactBasis(data["basis"], data["scales"], places_of(data["lit"]))
    return TransferModel(
        basis,
        **{name: data[name] for name in _ARRAYS},
        size=tuple(data["size"].tolist()),
        learnt=PairSummary(*(data[name] for name in _SUMMARY)),
        parameters={"nonnegative": False, "prior": False, **json.loads(str(data["parameters"]))},
        report=TransferReport.from_dict(printable_parts(json.loads(str(data["report"])))),
    )
