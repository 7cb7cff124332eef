"""How inner loops are compiled: by Numba, at their first call, the machine code kept for the next process.

Machine code is kept until the file of its function changes. After an edit here, remove __pycache__/*.nbi.
"""

import platform
import sys
from collections.abc import Callable

import llvmlite.binding
import numba
from numba.core import event

# LLVM takes half of the vector registers of some processors, whose clock sank under wide vectors. On a processor with
# AVX-512, fog takes a sixth less time with the whole registers; what is computed is the same at any width.
if numba.config.CPU_FEATURES is None and platform.machine() == "x86_64":
    numba.config.CPU_FEATURES = llvmlite.binding.get_host_cpu_features().flatten() + ",-prefer-256-bit"

# The loops hold instructions that only a compiler understands: switched off for the debugger, nothing would run.
numba.config.DISABLE_JIT = 0


class _Told(event.Listener):
    """Says once that loops are compiled: it takes up to half a minute the first time, which would pass in silence."""

    said = False

    def on_start(self, event: object) -> None:
        """A function is compiled, for which there is no machine code yet."""
        if not self.said:
            print("compiling what this needs, kept for the next run: up to half a minute", file=sys.stderr, flush=True)
            self.said = True

    def on_end(self, event: object) -> None:
        """It was compiled."""


event.register("numba:compile", _Told())


def jit(function: Callable) -> Callable:
    """Compile a function of arrays and numbers; in each process anew where machine code can be kept nowhere."""
    return _jit(function)


def jit_contracted(function: Callable) -> Callable:
    """The same for functions whose last bit does not matter: products and sums may be rounded once, in one step."""
    return _jit(function, fastmath={"contract"})


def _jit(function: Callable, **options: object) -> Callable:
    try:
        return numba.njit(cache=True, **options)(function)
    except RuntimeError:  # neither the package's folder nor the user's cache can be written
        return numba.njit(**options)(function)
