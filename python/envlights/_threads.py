"""How many threads the kernels use."""

from __future__ import annotations

from envlights import _native
from envlights._check import count
from envlights._native import EnvLightsError

#: Threads, at most: more would cost memory and help nobody.
_MOST = 1024


def threads(number: int | None = None) -> int:
    """Set or get how many threads the kernels use; results are the same bits for any number.

    At first they use as many as there are cores, or as the environment variable
    ``RAYON_NUM_THREADS`` says when they are first called. NumPy's own threads, which multiply the
    matrices of `TransferModel`, follow ``OPENBLAS_NUM_THREADS`` or ``OMP_NUM_THREADS``.

    Parameters
    ----------
    number : int, optional
        From the next call on, in this process, for all of its Python threads. Left out: nothing
        changes.

    Returns
    -------
    int
        The threads that are in use now; 1 where the system gives none.

    Raises
    ------
    EnvLightsError
        If `number` is not from 1 to 1024.

    Examples
    --------
    >>> before = threads()
    >>> threads(1)
    1
    >>> threads(before) == before
    True
    """
    if number is not None and count("number", number, least=1) > _MOST:
        raise EnvLightsError(f"number must be at most {_MOST} threads; got {number}")
    return _native.threads(None if number is None else int(number))
