"""Work on many maps, with rows and files, and labels for training.

| step                                   | file           |
|----------------------------------------|----------------|
| maps from paths, folders and iterators | `sources.py`   |
| row of a result                        | `rows.py`      |
| name of a function of the user         | `functions.py` |
| work on one map                        | `work.py`      |
| executors and threads                  | `executors.py` |
| rows that survive a kill               | `journal.py`   |
| columns of the tables                  | `columns.py`   |
| files of tables                        | `tables.py`    |
| result of a batch                      | `result.py`    |
| the batch                              | `batch.py`     |
| arrays for training                    | `labels.py`    |
"""

from envlights.batches.labels import LabelArrays
from envlights.batches.result import Batch

__all__ = [
    "Batch",
    "LabelArrays",
]
