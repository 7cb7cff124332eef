"""How inner loops are compiled: by Numba, at their first call, the machine code kept for the next process."""

from collections.abc import Callable

import numba


def compiled(function: Callable) -> Callable:
    """Compile a function of arrays and numbers; in each process anew where machine code can be kept nowhere."""
    try:
        return numba.njit(cache=True)(function)
    except RuntimeError:  # neither the package's folder nor the user's cache can be written
        return numba.njit(function)
