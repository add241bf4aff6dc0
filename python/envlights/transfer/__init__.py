"""Transfer of direct to indirect light: from small direct images to images of indirect light.

A model is learnt from pairs of images of one scene under many lights. These are the steps of
`TransferModel.fit`, and what else a model does:

| step                                             | file                        |
|--------------------------------------------------|-----------------------------|
| checks of the images; pairs at one scale         | `pairs.py`                  |
| inner products of all indirect images, in blocks | `training/gram.py`          |
| the directions that hold most of their energy    | `training/basis.py`         |
| both as tasks of Dask, for more than one machine | `training/cluster.py`       |
| from direct light to coefficients; the ridge     | `training/ridge.py`         |
| blocks of texels in the basis                    | `training/blocks.py`        |
| the non-negative operator to these blocks        | `training/nonnegative.py`   |
| the ridge around a prior mean; folds             | `training/remainder.py`     |
| errors on lights outside the pairs               | `training/leave_one_out.py` |
| all of these in order                            | `training/train.py`         |
| indirect light from geometry, without pairs      | `prior.py`                  |
| regression that weighs direct texels by it       | `training/weights.py`       |
| training around it                               | `training/around_prior.py`  |
| more pairs, without starting over                | `training/grow.py`          |
| lights unlike those of the pairs                 | `training/familiarity.py`   |
| size, times and errors                           | `report.py`                 |
| images from coefficients, and back               | `expand.py`                 |
| the basis in bytes or halves, for faster frames  | `compact.py`                |
| refusals of fields that do not fit together      | `consistency.py`            |
| files of arrays with a version                   | `files/npz_file.py`         |
| fields and predictions of a model                | `predictor.py`              |
| the model                                        | `model.py`                  |
| pairs on disk                                    | `files/database.py`         |
"""

from envlights.transfer.files.database import FilePairs, read_pairs
from envlights.transfer.model import TransferModel
from envlights.transfer.prior import TransferPrior
from envlights.transfer.report import TransferReport

__all__ = ["FilePairs", "TransferModel", "TransferPrior", "TransferReport", "read_pairs"]


def __dir__() -> list[str]:
    return sorted(__all__)
