"""ONNX Runtime on one image at a time."""

import numpy as np

from foggy_synscapes.tradeoff.onnx_export import INPUT


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
