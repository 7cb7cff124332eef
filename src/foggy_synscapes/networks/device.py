"""Where networks compute, and by which rules of arithmetic."""

import os

import torch


def take(device: str, threads: int, tf32: bool = False, deterministic: bool = False, search: bool = False) -> str:
    """Set how this process computes; returns where, "cpu" or "cuda".

    device : "cpu", "cuda" or "auto", a GPU where there is one; threads : of the CPU, part of what makes its bytes
    tf32, deterministic, search : of a GPU, see the params section `gpu`

    Raises ValueError where "cuda" is asked for and PyTorch finds no GPU.
    """
    torch.set_num_threads(threads)
    found = torch.cuda.is_available()
    if device == "cuda" and not found:
        raise ValueError(
            f"device: cuda, but PyTorch {torch.__version__} finds no GPU. Ask for cpu or auto, or install the build of "
            "PyTorch for your CUDA (pytorch.org) and look at `nvidia-smi`."
        )
    used = "cuda" if found and device != "cpu" else "cpu"
    # On a CPU repeatable algorithms cost nothing. On a GPU they take a slow way of resizing.
    # `torch.use_deterministic_algorithms` sets the same, but loads PyTorch's compiler, at half the time of a small job.
    torch.set_deterministic_debug_mode("error" if deterministic or used == "cpu" else "default")
    # Filling new memory would only hide reads of it, which these operations do not make, and costs time.
    torch.utils.deterministic.fill_uninitialized_memory = False  # type: ignore[attr-defined]  # not in PyTorch's types
    if deterministic:
        os.environ.setdefault("CUBLAS_WORKSPACE_CONFIG", ":4096:8")  # without it cuBLAS is refused
    torch.set_float32_matmul_precision("high" if tf32 else "highest")
    torch.backends.cudnn.allow_tf32 = tf32
    torch.backends.cudnn.benchmark = search
    torch.backends.cudnn.deterministic = deterministic
    return used
