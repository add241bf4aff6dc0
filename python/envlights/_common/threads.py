"""Number of threads of the kernels."""

from __future__ import annotations

from envlights import _native
from envlights._common.check import count
from envlights._native import EnvLightsError

#: Largest number of threads; more would only waste memory.
_MOST = 1024


def threads(number: int | None = None) -> int:
    """Set or get the number of threads of the kernels; results have the same bits for any number.

    The default is the number of cores, or the environment variable ``RAYON_NUM_THREADS`` at the
    first call. NumPy multiplies the matrices of `TransferModel` with its own threads, which follow
    ``OPENBLAS_NUM_THREADS`` or ``OMP_NUM_THREADS``.

    Parameters
    ----------
    number : int, optional
        Number for all following calls in this process. When left out, nothing changes.

    Returns
    -------
    int
        Current number of threads; 1 if the system allows none.

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
