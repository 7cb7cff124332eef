"""A network as an ONNX graph that stands alone: 8-bit images of any size in, logits or classes out. Made, put into
8 bits, and run.

The packages onnx, onnxscript and onnxruntime come with the extra `export`; nothing but this folder needs them.
"""

import contextlib
import json
import logging
import tempfile
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import torch

from foggy_synscapes.networks.weights import Model
from foggy_synscapes.tradeoff.graph import Graph, with_paired_stems

if TYPE_CHECKING:
    from onnx import GraphProto, ModelProto

OPSET = 18  # the first that the exporter writes without converting; ONNX Runtime reads it since 1.14
INPUT = "image"
OUTPUTS = ("logits", "classes")
SIDES = {0: "batch", 1: "height", 2: "width"}  # axes of any length
EXAMPLE = (2, 100, 150, 3)  # no axis that could pass for fixed, or for a multiple of the stride
KEY = "foggy"


def to_onnx(model: Model, scale: float = 1.0) -> bytes:
    """The ONNX graph of `Graph`, with weights: equal models give equal bytes, which hold no path and no time.

    Input `image`: uint8 (batch, height, width, 3), RGB. Outputs `logits`: float32 (batch, classes, height, width) and
    `classes`: uint8 (batch, height, width), trainIds. Its metadata (key `foggy`) tell network, preprocessing and scale.

    Raises ImportError where the extra `export` is not installed.
    """
    import onnx
    import onnxscript  # noqa: F401  # the exporter needs it; missing, it is to be named here and not deep inside

    graph = Graph(with_paired_stems(model), scale).eval()
    with quiet("torch.onnx"):
        program = torch.onnx.export(
            graph, (torch.zeros(EXAMPLE, dtype=torch.uint8),), dynamo=True, input_names=[INPUT],
            output_names=list(OUTPUTS), dynamic_shapes=(SIDES,), opset_version=OPSET, verbose=False,
        )  # fmt: skip
    assert program is not None  # None is for the exporter that dynamo=False asks for
    proto = program.model_proto
    _strip(proto)
    _pool(proto.graph)
    _keep(proto, OUTPUTS)
    about = {"network": asdict(model.config), "preprocessing": asdict(model.preprocessing), "scale": scale}
    onnx.helper.set_model_props(proto, {KEY: json.dumps(about, sort_keys=True)})
    proto.producer_name, proto.producer_version = "foggy-synscapes", ""
    onnx.checker.check_model(proto)
    return proto.SerializeToString(deterministic=True)


def with_output(data: bytes, output: str) -> bytes:
    """The graph with one of its outputs alone, and nothing that only the other needs."""
    import onnx

    proto = onnx.load_from_string(data)
    _keep(proto, [output])
    return proto.SerializeToString(deterministic=True)


def to_int8(data: bytes, images: Sequence[np.ndarray]) -> bytes:
    """Quantise a graph of `to_onnx` from its first to its last convolution: static, calibrated on images.

    images : uint8 (H, W, 3), RGB; the ranges of all activations are the smallest and largest values on them

    Normalisation before and resizing after the convolutions stay as they are: they cost little, and the steps of
    8 bits would add up in the logits. Activations are unsigned with one scale a tensor, weights signed with one scale a
    channel (U8S8): processors with VNNI or AMX have instructions for it, on older ones sums of pairs may saturate.
    Source: ONNX Runtime's guide to quantisation.

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
            source, target, Images(), quant_format=QuantFormat.QDQ, per_channel=True, weight_type=QuantType.QInt8,
            activation_type=QuantType.QUInt8, nodes_to_exclude=_around_convolutions(proto),
        )  # fmt: skip
        quantised = onnx.load(target)
    del quantised.metadata_props[:]
    quantised.metadata_props.extend(proto.metadata_props)
    quantised.producer_name, quantised.producer_version = proto.producer_name, ""
    return quantised.SerializeToString(deterministic=True)


class Session:
    """A graph of `to_onnx` or `to_int8`, ready to run on so many threads.

    Raises ImportError where the extra `export` is not installed; ValueError where the data are no ONNX graph.
    """

    def __init__(self, data: bytes, threads: int) -> None:
        import onnxruntime

        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads, options.inter_op_num_threads = threads, 1
        options.log_severity_level = 3
        try:
            self._session = onnxruntime.InferenceSession(data, options, providers=["CPUExecutionProvider"])
        except Exception as error:  # its classes have no common base of their own
            raise ValueError(f"ONNX Runtime refuses the graph: {str(error).splitlines()[0]}") from error

    def __call__(self, rgb: np.ndarray, output: str) -> np.ndarray:
        """rgb uint8 (H, W, 3) -> logits float32 (classes, H, W), or classes uint8 (H, W)."""
        return self._session.run([output], {INPUT: rgb[None]})[0][0]


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


def _strip(proto: "ModelProto") -> None:
    """Leave out where in which source file a node comes from: these are paths of the machine."""
    graph = proto.graph
    for part in (graph, *graph.node, *graph.initializer, *graph.value_info, *graph.input, *graph.output):
        part.ClearField("metadata_props")
        part.ClearField("doc_string")
    graph.name = "foggy"


def _pool(graph: "GraphProto") -> None:
    """Write means over all pixels as the pooling that they are: runtimes have 8-bit arithmetic for that alone."""
    import onnx

    values = {one.name: one for one in graph.initializer}
    for node in graph.node:
        if node.op_type != "ReduceMean" or len(node.input) < 2 or node.input[1] not in values:
            continue
        keep = all(one.i == 1 for one in node.attribute if one.name == "keepdims")
        if keep and onnx.numpy_helper.to_array(values[node.input[1]]).tolist() == [2, 3]:
            node.op_type = "GlobalAveragePool"
            del node.input[1:]
            del node.attribute[:]


def _keep(proto: "ModelProto", outputs: Sequence[str]) -> None:
    """Leave out what these outputs do not need."""
    import onnx.utils

    found = onnx.utils.Extractor(proto).extract_model([INPUT], list(outputs)).graph
    found.name = proto.graph.name
    proto.graph.CopyFrom(found)


@contextlib.contextmanager
def quiet(logger: str | None) -> Iterator[None]:
    """Keep a logger (None: the root) and warnings to errors: exporters warn of what they could do otherwise."""
    log = logging.getLogger(logger)
    level = log.level
    log.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        log.setLevel(level)
