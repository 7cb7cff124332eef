"""An ONNX graph in 8 bits: static quantisation, calibrated on images.

Activations are unsigned with one scale a tensor, weights signed with one scale a channel (U8S8): processors with VNNI
or AMX have instructions for it, on older ones sums of pairs may saturate. Source: ONNX Runtime's guide to quantisation.
"""

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from foggy_synscapes.tradeoff.onnx_export import INPUT, quiet

if TYPE_CHECKING:
    from onnx import ModelProto


def to_int8(data: bytes, images: Sequence[np.ndarray]) -> bytes:
    """Quantise a graph of `to_onnx` from its first to its last convolution.

    images : uint8 (H, W, 3), RGB; the ranges of all activations are the smallest and largest values on them

    Normalisation before and resizing after the convolutions stay as they are: they cost little, and the steps of
    8 bits would add up in the logits.

    Raises ValueError without images; ImportError where the extra `export` is not installed.
    """
    import onnx
    from onnxruntime.quantization import CalibrationDataReader, QuantFormat, QuantType, quantize_static

    if not images:
        raise ValueError("images: none, expected at least one to calibrate on")

    class Images(CalibrationDataReader):
        def __init__(self) -> None:
            self.rest = iter(images)

        def get_next(self) -> dict[str, np.ndarray] | None:
            image = next(self.rest, None)
            return None if image is None else {INPUT: image[None]}

    proto = onnx.load_from_string(data)
    # It asks for a pass that joins convolutions and batch norms; the exporter has done so.
    with quiet(None), tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "float32.onnx", Path(folder) / "int8.onnx"
        source.write_bytes(data)
        quantize_static(
            source,
            target,
            Images(),
            quant_format=QuantFormat.QDQ,
            per_channel=True,
            activation_type=QuantType.QUInt8,
            weight_type=QuantType.QInt8,
            nodes_to_exclude=_around_convolutions(proto),
        )
        quantised = onnx.load(target)
    del quantised.metadata_props[:]
    quantised.metadata_props.extend(proto.metadata_props)
    quantised.producer_name, quantised.producer_version = proto.producer_name, ""
    return quantised.SerializeToString(deterministic=True)


def _around_convolutions(proto: "ModelProto") -> list[str]:
    """Names of the nodes that no convolution comes before, or none after."""
    after: set[str] = set()
    before: set[str] = set()
    for node in proto.graph.node:
        if node.op_type == "Conv" or after & set(node.input):
            after.update(node.output)
    for node in reversed(proto.graph.node):
        if node.op_type == "Conv" or before & set(node.output):
            before.update(node.input)
    return [
        node.name
        for node in proto.graph.node
        if node.op_type != "Conv" and not (after & set(node.output) and before & set(node.output))
    ]
