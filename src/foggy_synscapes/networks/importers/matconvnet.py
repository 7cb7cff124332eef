"""MatConvNet's parameters in PyTorch's terms.

MatConvNet keeps filters as (rows, columns, inputs, outputs), and batch norm's statistics as one array of means and
standard deviations. Source: the documentation of vl_nnconv and vl_nnbnorm.
"""

import numpy as np
import torch
from torch import Tensor

EPSILON = 1e-5  # what PyTorch's batch norm adds to the variance; MatConvNet's deviations include its own
PARTS = {"filter": "weight", "mult": "weight", "bias": "bias"}
HEAD = "clf_conv"  # the classifier is in a group of its own and has no name there


def tensors(arrays: dict[str, np.ndarray]) -> dict[str, Tensor]:
    """Turn named arrays into named tensors.

    arrays : as MATLAB shows them: "conv1_filter" (7, 7, 3, 64), "bn_conv1_moments" (64, 2), "bn_conv1_mult" (64, 1);
        the classifier's are "filters" and "biases"

    Returns
    -------
    float32 tensors: "conv1.weight" (64, 3, 7, 7), "bn_conv1.running_mean" (64), ...

    Raises ValueError for a name of another kind, or a shape that is not what its name promises.
    """
    found: dict[str, Tensor] = {}
    for name, array in arrays.items():
        values = torch.from_numpy(np.ascontiguousarray(array, dtype=np.float32))
        base, _, kind = name.rpartition("_")
        if name == "filters":
            found[f"{HEAD}.weight"] = _filter(name, values)
        elif name == "biases":
            found[f"{HEAD}.bias"] = values.flatten()
        elif kind == "filter":
            found[f"{base}.weight"] = _filter(name, values)
        elif kind == "moments":
            if values.ndim != 2 or values.shape[1] != 2:
                raise ValueError(f"{name}: {tuple(values.shape)}, expected a mean and a deviation for each channel")
            found[f"{base}.running_mean"] = values[:, 0].contiguous()
            found[f"{base}.running_var"] = (values[:, 1].double() ** 2 - EPSILON).float()
        elif kind in PARTS:
            found[f"{base}.{PARTS[kind]}"] = values.flatten()
        else:
            raise ValueError(f"{name}: not a parameter of MatConvNet's layers (filter, bias, mult, moments)")
    return found


def _filter(name: str, values: Tensor) -> Tensor:
    if values.ndim != 4:
        raise ValueError(f"{name}: {tuple(values.shape)}, expected rows, columns, inputs and outputs")
    return values.permute(3, 2, 0, 1).contiguous()
