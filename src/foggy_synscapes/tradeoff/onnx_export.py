"""A network as an ONNX graph that stands alone: 8-bit images of any size in, logits or classes out.

The packages onnx, onnxscript and onnxruntime come with the extra `export`; nothing but this folder needs them.
"""

import contextlib
import json
import logging
import warnings
from collections.abc import Iterator
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

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
            graph,
            (torch.zeros(EXAMPLE, dtype=torch.uint8),),
            dynamo=True,
            input_names=[INPUT],
            output_names=list(OUTPUTS),
            dynamic_shapes=(SIDES,),
            opset_version=OPSET,
            verbose=False,
        )
    assert program is not None  # None is for the exporter that dynamo=False asks for
    proto = program.model_proto
    _strip(proto)
    _pool(proto.graph)
    about = {"network": asdict(model.config), "preprocessing": asdict(model.preprocessing), "scale": scale}
    onnx.helper.set_model_props(proto, {KEY: json.dumps(about, sort_keys=True)})
    proto.producer_name, proto.producer_version = "foggy-synscapes", ""
    onnx.checker.check_model(proto)
    return proto.SerializeToString(deterministic=True)


def with_output(data: bytes, output: str) -> bytes:
    """The graph with one of its outputs alone, and nothing that only the other needs."""
    import onnx

    proto = onnx.load_from_string(data)
    graph = proto.graph
    needed, kept = {output}, []
    for node in reversed(graph.node):
        if needed & set(node.output):
            needed.update(node.input)
            kept.append(node)
    _replace(graph.node, kept[::-1])
    _replace(graph.initializer, [one for one in graph.initializer if one.name in needed])
    _replace(graph.value_info, [one for one in graph.value_info if one.name in needed])
    _replace(graph.output, [one for one in graph.output if one.name == output])
    return proto.SerializeToString(deterministic=True)


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
    used = {name for node in graph.node for name in node.input}
    _replace(graph.initializer, [one for one in graph.initializer if one.name in used])


def _replace(field: Any, items: list) -> None:
    """Fill a repeated field anew; what it held may be among the new items."""
    copies = [type(item).FromString(item.SerializeToString()) for item in items]
    del field[:]
    field.extend(copies)


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
