"""The instruction set that decides how floating-point sums are ordered and rounded: part of what makes bytes.

PyTorch, NumPy and Numba choose their inner loops by what the processor can do, so that equal code, versions and
threads may still give other last digits on another kind of processor. Its name is not needed for that, its
instructions are.
"""

import importlib
import os
import platform
from pathlib import Path

# What limits the libraries below the processor's own instructions, where it is set.
LIMITS = ("ATEN_CPU_CAPABILITY", "DNNL_MAX_CPU_ISA", "MKL_ENABLE_INSTRUCTIONS", "NUMBA_CPU_NAME", "ONEDNN_MAX_CPU_ISA")


def instructions() -> dict[str, str]:
    """Machine and instruction set extensions as NumPy finds them, and the environment's limits on them.

    >>> sorted(instructions())[:2]
    ['extensions', 'machine']
    """
    # By name, because no job computes with NumPy through this: another version of it re-runs nothing for that. No
    # public function returns these features; NPY_DISABLE_CPU_FEATURES is respected.
    features = importlib.import_module("numpy._core._multiarray_umath").__cpu_features__
    found = " ".join(sorted(name for name, there in features.items() if there))
    limits = {name: os.environ[name] for name in LIMITS if os.environ.get(name)}
    return {"machine": platform.machine(), "extensions": found, **limits}


def gpu() -> dict[str, str]:
    """What decides the bytes that a GPU makes: its model, the driver, and the versions of CUDA and cuDNN."""
    torch = importlib.import_module("torch")
    driver = Path("/sys/module/nvidia/version")  # PyTorch knows the driver's level of CUDA only
    return {
        "model": torch.cuda.get_device_name(),
        "driver": driver.read_text(encoding="ascii").strip() if driver.is_file() else "unknown",
        "cuda": str(torch.version.cuda),
        "cudnn": str(torch.backends.cudnn.version()),
    }
