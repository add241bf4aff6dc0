"""Transfer of direct to indirect light: from a small image of the one to an image of the other.

A model is learnt from pairs of images of one scene under many lights. These are the steps of
`TransferModel.fit`, and what else a model does:

| step                                             | file               |
|--------------------------------------------------|--------------------|
| checks of images; pairs, and their summary       | `pairs.py`         |
| inner products of all indirect images, in blocks | `gram.py`          |
| the directions that hold most of their energy    | `basis.py`         |
| both as tasks of Dask, for more than one machine | `cluster.py`       |
| from direct light to coefficients; the ridge     | `ridge.py`         |
| blocks of texels in the basis                    | `blocks.py`        |
| the non-negative operator to these blocks        | `nonnegative.py`   |
| the ridge around a prior mean; folds             | `remainder.py`     |
| errors on lights outside the pairs               | `leave_one_out.py` |
| all of these in order                            | `training.py`      |
| indirect light from geometry, without pairs      | `prior.py`         |
| its sums with indirect images, part by part      | `mixtures.py`      |
| regression that weighs direct texels by it       | `weights.py`       |
| training around it                               | `around_prior.py`  |
| size, times and errors                           | `report.py`        |
| more pairs, without starting over                | `grow.py`          |
| images from coefficients, and back               | `expand.py`        |
| the basis in bytes or halves, for faster frames  | `compact.py`       |
| lights unlike those of the pairs                 | `familiarity.py`   |
| refusals of fields that do not fit together      | `consistency.py`   |
| one file for a model                             | `archive.py`       |
| files of arrays with a version                   | `npz_file.py`      |
| fields and predictions of a model                | `predictor.py`     |
| the model                                        | `model.py`         |
| pairs on disk                                    | `database.py`      |
"""

from envlights.transfer.files.database import FilePairs, read_pairs
from envlights.transfer.model import TransferModel
from envlights.transfer.prior import TransferPrior
from envlights.transfer.report import TransferReport

__all__ = ["FilePairs", "TransferModel", "TransferPrior", "TransferReport", "read_pairs"]


def __dir__() -> list[str]:
    return sorted(__all__)
