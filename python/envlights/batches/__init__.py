"""Work on many maps, with rows and files, and labels for training.

| step                                   | file           |
|----------------------------------------|----------------|
| maps from paths, folders and iterators | `sources.py`   |
| row of a result                        | `rows.py`      |
| work on one map                        | `work.py`      |
| executors and threads                  | `executors.py` |
| rows that survive a kill               | `journal.py`   |
| columns of the tables, and their files | `columns.py`   |
| result of a batch                      | `result.py`    |
| the batch                              | `batch.py`     |
| arrays for training                    | `labels.py`    |
"""

from envlights.batches.labels import LabelArrays, label_arrays
from envlights.batches.result import Batch
from envlights.batches.work import row

__all__ = [
    "Batch",
    "LabelArrays",
    "label_arrays",
    "row",
]
