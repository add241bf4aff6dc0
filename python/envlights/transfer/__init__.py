"""Transfer: indirect light from a small image of the direct light.

Learnt from pairs of images of one scene under many lights. `TransferModel.fit` is the story:

| step                                                   | file          |
|--------------------------------------------------------|---------------|
| what is asked of the images; pairs at one scale        | `pairs.py`    |
| the inner products of all indirect images, in blocks   | `gram.py`     |
| the directions that hold most of them                  | `basis.py`    |
| from direct light to coefficients; the ridge           | `ridge.py`    |
| errors on lights that were not seen                    | `leave_one_out.py`|
| the matrix of a basis, with its errors                 | `training.py` |
| images from coefficients, and back                     | `expand.py`   |
| the basis in bytes or halves, for faster frames        | `compact.py`  |
| what a model keeps of its pairs                        | `learnt.py`   |
| more pairs, without starting over                      | `grow.py`     |
| what was found, and how far it can be trusted          | `report.py`   |
| the model                                              | `model.py`    |
| one file for a model                                   | `archive.py`  |
| pairs on disk                                          | `database.py` |
| the looks at all images, for more than one machine     | `cluster.py`  |
"""

from envlights.transfer.database import FilePairs, read_pairs
from envlights.transfer.model import TransferModel
from envlights.transfer.report import TransferReport

__all__ = ["FilePairs", "TransferModel", "TransferReport", "read_pairs"]
