"""Optimal assignment of rows to columns of a table of costs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def assignment(costs: NDArray[np.float64]) -> NDArray[np.intp]:
    """Column of each row in the assignment with the least sum of costs, for a square table.

    The method of shortest augmenting paths (Jonker and Volgenant 1987) takes n^3 steps.

    Examples
    --------
    >>> assignment(np.array([[1.0, 2.0], [1.0, 9.0]]))
    array([1, 0])
    """
    size = len(costs)
    # Row 0 and column 0 of the arrays stand for "no row" and "no column".
    of_row, of_column = np.zeros(size + 1), np.zeros(size + 1)
    row_of = np.zeros(size + 1, np.intp)
    for row in range(1, size + 1):
        row_of[0] = row
        _augment(costs, of_row, of_column, row_of)
    columns = np.zeros(size, np.intp)
    columns[row_of[1:] - 1] = np.arange(size)
    return columns


def _augment(
    costs: NDArray[np.float64],
    of_row: NDArray[np.float64],
    of_column: NDArray[np.float64],
    row_of: NDArray[np.intp],
) -> None:
    """Give the row in `row_of[0]` a column, along the cheapest path of exchanges."""
    size = len(costs)
    least, before = np.full(size + 1, np.inf), np.zeros(size + 1, np.intp)
    is_reached = np.zeros(size + 1, bool)
    column = 0
    while column == 0 or row_of[column]:
        is_reached[column] = True
        row, is_open = row_of[column], ~is_reached
        is_open[0] = False
        reduced = np.full(size + 1, np.inf)
        reduced[1:] = costs[row - 1] - of_row[row] - of_column[1:]
        is_better = is_open & (reduced < least)
        least[is_better], before[is_better] = reduced[is_better], column
        following = int(np.where(is_open, least, np.inf).argmin())
        step = least[following]
        of_row[row_of[is_reached]] += step
        of_column[is_reached] -= step
        least[is_open] -= step
        column = following
    while column:
        row_of[column] = row_of[before[column]]
        column = int(before[column])
